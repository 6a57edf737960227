// The smallest program that swaps dWorldStep for the accurate step: a link on a hinge above the ground.
//
//   swing            dWorldStep
//   swing accurate   odeval::AccurateStep
//
// Prints what the energy did in ten seconds and where the bounces were.
#include <ode/ode.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "engines/ode_rk4/accurate_step.hpp"

namespace {

dWorldID world;
dSpaceID space;
dJointGroupID contacts;
constexpr double bounciness = 0.9;

void near(void*, dGeomID one, dGeomID other) {
  dContact contact[4]{};
  const int count = dCollide(one, other, 4, &contact[0].geom, sizeof(dContact));
  for (int i = 0; i < count; ++i) {
    contact[i].surface.mode = dContactBounce;
    contact[i].surface.bounce = bounciness;
    dJointAttach(dJointCreateContact(world, contacts, &contact[i]), dGeomGetBody(one), dGeomGetBody(other));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool accurate = argc > 1 && std::strcmp(argv[1], "accurate") == 0;
  dInitODE2(0);
  world = dWorldCreate();
  space = dHashSpaceCreate(nullptr);
  contacts = dJointGroupCreate(0);
  dWorldSetGravity(world, 0, 0, -9.81);

  const dBodyID link = dBodyCreate(world);
  dMass mass;
  dMassSetBoxTotal(&mass, 1, 1, 0.1, 0.1);
  dBodySetMass(link, &mass);
  dBodySetPosition(link, 0.5, 0, 0.9);
  const dGeomID box = dCreateBox(space, 1, 0.1, 0.1);
  dGeomSetBody(box, link);
  const dJointID hinge = dJointCreateHinge(world, nullptr);
  dJointAttach(hinge, link, nullptr);
  dJointSetHingeAnchor(hinge, 0, 0, 0.9);
  dJointSetHingeAxis(hinge, 0, 1, 0);
  dCreatePlane(space, 0, 0, 1, 0);

  odeval::AccurateStepOptions options;
  options.contact = [](dxGeom*, dxGeom*) { return std::optional(odeval::Bounce{bounciness}); };
  odeval::AccurateStep step(world, space, options);

  const double h = 0.01;
  for (int k = 0; k < 1000; ++k) {
    if (accurate) {
      step(h);
    } else {
      dSpaceCollide(space, nullptr, near);
      dWorldStep(world, h);
      dJointGroupEmpty(contacts);
    }
  }
  const dReal* v = dBodyGetLinearVel(link);
  const dReal* w = dBodyGetAngularVel(link);
  const double energy = 0.5 * (v[0] * v[0] + v[2] * v[2] + mass.I[5] * w[1] * w[1]) + 9.81 * dBodyGetPosition(link)[2];
  std::printf("%s: energy %.6f J after 10 s, hinge angle %.6f rad\n", accurate ? "AccurateStep" : "dWorldStep", energy,
              dJointGetHingeAngle(hinge));
  dJointGroupDestroy(contacts);
  dSpaceDestroy(space);
  dWorldDestroy(world);
  dCloseODE();
}
