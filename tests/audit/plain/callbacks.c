/* Callbacks of bodies that have been moved, which the program counts by, looks by, damps by. */
#include "plain.h"

enum { most = 4 };
static int calls[most];
static double seen[most][3]; /* in the last call */
static double damping[most]; /* as the last call has set it */
static double drawn;         /* in the last call of all */

static int number(dBodyID body) {
  int i = 0;
  while (bodies[i] != body) ++i;
  return i;
}

/* Each is called once in a step, with its own numbers: what it set, and what is drawn after what it has drawn. */
static void notice(dBodyID body) {
  const int i = number(body);
  if (dBodyGetLinearDamping(body) != damping[i]) exit(4);
  damping[i] += 1e-6;
  dBodySetLinearDamping(body, damping[i]);
  for (int k = 0; k < 3; ++k) seen[i][k] = dBodyGetPosition(body)[k];
  ++calls[i];
  drawn = dRandReal();
}

/* Ends the program if a body that a step has moved was not told of once, where the step has moved it to, or one was
 * that it has not moved. */
static void look_who_moved(void) {
  static double before[most][3];
  static long steps;
  static unsigned long seed;
  for (int i = 0; i < count; ++i) {
    const dReal* at = dBodyGetPosition(bodies[i]);
    const int moved = at[0] != before[i][0] || at[1] != before[i][1] || at[2] != before[i][2];
    if (steps > 0 && calls[i] != moved) exit(4);
    for (int k = 0; k < 3; ++k) {
      if (steps > 0 && moved && seen[i][k] != at[k]) exit(4);
      before[i][k] = at[k];
    }
    calls[i] = 0;
  }
  if (dBodyGetLinearDamping(bodies[0]) != damping[0]) exit(4);
  if (steps > 0 && drawn == 0) exit(4);
  if (steps > 0 && dRandGetSeed() == seed) exit(4); /* what the callbacks have drawn is not drawn again */
  seed = dRandGetSeed();
  ++steps;
}

/* Two links, a box that damping puts to sleep within a step, and a box that is asleep. */
static void noticed(void) {
  make_box(add(0, 0.5, 2), 1, 0.1, 1, 0.1);
  make_box(add(0, 1.5, 2), 1, 0.1, 1, 0.1);
  for (int i = 0; i < 2; ++i) {
    dJointID hinge = dJointCreateHinge(world, 0);
    dJointAttach(hinge, bodies[i], i == 0 ? 0 : bodies[0]);
    dJointSetHingeAnchor(hinge, 0, i, 2);
    dJointSetHingeAxis(hinge, 1, 0, 0);
  }
  dBodySetLinearVel(float_at(5, 0, 0), 1, 0, 0);
  dJointAttach(dJointCreateNull(world, 0), bodies[2], 0); /* without a joint none is put to sleep */
  dBodySetAutoDisableFlag(bodies[2], 1);
  dBodySetAutoDisableLinearThreshold(bodies[2], 0.5);
  dBodySetAutoDisableTime(bodies[2], 0);
  dBodySetAutoDisableSteps(bodies[2], 10);
  dBodyDisable(float_at(7, 0, 0));
  for (int i = 0; i < count; ++i) {
    damping[i] = i == 2 ? 0.004 : 1e-3;
    dBodySetLinearDampingThreshold(bodies[i], 0);
    dBodySetLinearDamping(bodies[i], damping[i]);
    dBodySetMovedCallback(bodies[i], notice);
  }
  control = look_who_moved;
}

static void brake(dBodyID body) {
  const dReal* v = dBodyGetLinearVel(body);
  const dReal* w = dBodyGetAngularVel(body);
  dBodySetLinearVel(body, (1 - h) * v[0], (1 - h) * v[1], (1 - h) * v[2]);
  dBodySetAngularVel(body, (1 - 2 * h) * w[0], (1 - 2 * h) * w[1], (1 - 2 * h) * w[2]);
}

/* A box that floats and turns about its own axis, and that keeps 1 - h of its velocity and 1 - 2 h of its spin, once in
 * each step: until then both stay, whatever a step is made of. */
static void braked(void) {
  float_at(0, 0, 0);
  dBodySetLinearVel(bodies[0], 1, 0, 0);
  dBodySetAngularVel(bodies[0], 0, 0, 3);
  dBodySetFiniteRotationMode(bodies[0], 1);
  dBodySetMovedCallback(bodies[0], brake);
}

static void damp(dBodyID body) { dBodySetLinearDamping(body, 1 - exp(-h)); }

/* A body without weight that keeps exp(-t) of its velocity by ODE's damping, which the callback sets again in each
 * step. */
static void self_damped(void) {
  float_at(0, 0, 0);
  dBodySetLinearVel(bodies[0], 1, 0, 0);
  dBodySetLinearDampingThreshold(bodies[0], 0);
  damp(bodies[0]);
  dBodySetMovedCallback(bodies[0], damp);
}

static void pull_along(void) { dBodyAddForce(bodies[0], 2, 0, 0); }

/* The same, pulled by 2 N, and damped besides: it keeps 1 - h/2 of its velocity. */
static void braked_and_pulled(void) {
  braked();
  dBodySetLinearDamping(bodies[0], h / 2);
  dBodySetLinearDampingThreshold(bodies[0], 0);
  control = pull_along;
}

const Scenario of_callbacks[] = {
    {"noticed", noticed, 0},
    {"braked", braked, 0},
    {"self_damped", self_damped, 0},
    {"braked_and_pulled", braked_and_pulled, 0},
    {0, 0, 0},
};
