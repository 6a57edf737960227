#include "tests/benchmark/bare_loop.h"

#include <ode/ode.h>

#define PI 3.14159265358979323846

static dWorldID world;
static dSpaceID space;
static dBodyID body[2];
static dJointFeedback feedback[2];

static void add_body(int i, dReal turn, dReal y, dReal z) {
  dMass mass;
  dMatrix3 rotation;
  body[i] = dBodyCreate(world);
  dMassSetBoxTotal(&mass, 1, 0.1, 0.1, 1);
  dBodySetMass(body[i], &mass);
  dRFromAxisAndAngle(rotation, 1, 0, 0, turn);
  dBodySetRotation(body[i], rotation);
  dBodySetPosition(body[i], 0, y, z);
  dGeomSetBody(dCreateBox(space, 0.1, 0.1, 1), body[i]);
}

static void add_hinge(int i, dBodyID first, dBodyID second, dReal y, dReal z) {
  dJointID hinge = dJointCreateHinge(world, 0);
  dJointAttach(hinge, first, second);
  dJointSetHingeAnchor(hinge, 0, y, z);
  dJointSetHingeAxis(hinge, 1, 0, 0);
  dJointSetFeedback(hinge, &feedback[i]);
}

void bare_pendulum_create(void) {
  const dReal half = dSqrt(0.5);
  dInitODE2(0);
  dAllocateODEDataForThread((unsigned int)dAllocateMaskAll);
  world = dWorldCreate();
  space = dHashSpaceCreate(0);
  dWorldSetGravity(world, 0, 0, -9.81);
  dWorldSetERP(world, 0.2);
  dWorldSetCFM(world, 1e-5);
  dCreatePlane(space, 0, 0, 1, 0);
  add_body(0, 0.75 * PI, half / 2, 2.1 + half / 2);
  add_hinge(0, body[0], 0, 0, 2.1);
  add_body(1, 0.5 * PI, half + 0.5, 2.1 + half);
  add_hinge(1, body[0], body[1], half, 2.1 + half);
}

void bare_pendulum_run(long steps) {
  long k;
  for (k = 0; k < steps; ++k) dWorldStep(world, 0.001);
}

double bare_pendulum_height(void) { return dBodyGetPosition(body[1])[2]; }

void bare_pendulum_destroy(void) {
  dSpaceDestroy(space);
  dWorldDestroy(world);
  dCloseODE();
}
