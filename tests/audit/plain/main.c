/* Programs as users of ODE write them: some of the project's scenarios, with nothing of the project in them.
 *
 *   plain SCENARIO H SECONDS [POSES]
 *
 * POSES gets a line a step and body, position and quaternion in hexadecimal. */
#include "plain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { most_bodies = 64 };

dWorldID world;
dSpaceID space;
dBodyID bodies[most_bodies];
int count;
double h;
void (*control)(void);
double bounce, friction, friction2;
int coefficients = dContactApprox1;
const dReal* first_direction;
enum Softness contact_is;
void (*feel)(dJointID touch);

static dJointGroupID contacts;

dBodyID add(double x, double y, double z) {
  dBodyID body = dBodyCreate(world);
  dBodySetPosition(body, x, y, z);
  bodies[count++] = body;
  return body;
}

void make_box(dBodyID body, double mass, double x, double y, double z) {
  dMass m;
  dMassSetBoxTotal(&m, mass, x, y, z);
  dBodySetMass(body, &m);
  dGeomSetBody(dCreateBox(space, x, y, z), body);
}

void make_ball(dBodyID body, double mass, double radius) {
  dMass m;
  dMassSetSphereTotal(&m, mass, radius);
  dBodySetMass(body, &m);
  dGeomSetBody(dCreateSphere(space, radius), body);
}

dBodyID float_at(double x, double y, double z) {
  dBodyID body = add(x, y, z);
  make_box(body, 1, 0.1, 0.1, 0.1);
  dBodySetGravityMode(body, 0);
  return body;
}

double erp(void) { return h * 1000 / (h * 1000 + 20); }
double cfm(void) { return 1 / (h * 1000 + 20); }

static void near(void* data, dGeomID one, dGeomID other) {
  (void)data;
  dContact contact[8];
  memset(contact, 0, sizeof contact);
  int found = dCollide(one, other, 8, &contact[0].geom, sizeof(dContact));
  for (int i = 0; i < found; ++i) {
    contact[i].surface.mode = dContactBounce | coefficients;
    contact[i].surface.bounce = bounce;
    contact[i].surface.mu = friction;
    if (friction2 > 0) {
      contact[i].surface.mode |= dContactMu2;
      contact[i].surface.mu2 = friction2;
    }
    if (first_direction) {
      contact[i].surface.mode |= dContactFDir1;
      memcpy(contact[i].fdir1, first_direction, sizeof contact[i].fdir1);
    }
    if (contact_is != hard) {
      contact[i].surface.mode =
          (contact_is != only_soft_cfm ? dContactSoftERP : 0) | (contact_is != only_soft_erp ? dContactSoftCFM : 0);
      contact[i].surface.soft_erp = contact_is != only_soft_cfm ? erp() : 0.9; /* which is not read */
      contact[i].surface.soft_cfm = contact_is != only_soft_erp ? cfm() : 0.9;
    }
    dJointID touch = dJointCreateContact(world, contacts, &contact[i]);
    dJointAttach(touch, dGeomGetBody(one), dGeomGetBody(other));
    if (feel) feel(touch);
  }
}

static void write_poses(FILE* poses) {
  for (int i = 0; i < count; ++i) {
    const dReal* p = dBodyGetPosition(bodies[i]);
    const dReal* q = dBodyGetQuaternion(bodies[i]);
    fprintf(poses, "%a %a %a %a %a %a %a\n", p[0], p[1], p[2], q[0], q[1], q[2], q[3]);
  }
}

static const Scenario* find(const char* name) {
  const Scenario* const tables[] = {of_bodies, of_callbacks, of_contacts, of_joints, of_motors, of_pendulums, of_stops};
  for (unsigned i = 0; i < sizeof tables / sizeof tables[0]; ++i) {
    for (const Scenario* one = tables[i]; one->name; ++one) {
      if (strcmp(one->name, name) == 0) return one;
    }
  }
  return 0;
}

int main(int argc, char** argv) {
  const Scenario* scenario = argc >= 4 ? find(argv[1]) : 0;
  if (!scenario) {
    fprintf(stderr, "usage: plain SCENARIO H SECONDS [POSES]\n");
    return 2;
  }
  h = atof(argv[2]);
  dInitODE2(0);
  world = dWorldCreate();
  space = dHashSpaceCreate(0);
  contacts = dJointGroupCreate(0);
  dWorldSetGravity(world, 0, 0, -9.81);
  scenario->make();
  FILE* poses = argc > 4 ? fopen(argv[4], "w") : 0;
  const long steps = lround(atof(argv[3]) / h);
  for (long i = 0; i < steps; ++i) {
    if (control) control();
    if (scenario->touches) dSpaceCollide(space, 0, near);
    dWorldStep(world, h);
    dJointGroupEmpty(contacts);
    if (poses) write_poses(poses);
  }
  if (poses) fclose(poses);
  dJointGroupDestroy(contacts);
  dSpaceDestroy(space);
  dWorldDestroy(world);
  dCloseODE();
  return 0;
}
