/* Bodies alone: in flight, damped, put to sleep, changed by hand, in several worlds. */
#include "plain.h"

static void free_box(void) {
  dWorldSetGravity(world, 0, 0, -9.8);
  make_box(add(0, 0, 0), 10, 0.1, 0.4, 0.9);
  dBodySetLinearVel(bodies[0], -2, 2, 8);
  dBodySetAngularVel(bodies[0], 0.1, 5, 0.1);
}

/* A ball that keeps exp(-t) of its velocity and exp(-2 t) of its spin, on which the weight acts. */
static void damped(void) {
  dWorldSetLinearDamping(world, 1 - exp(-h));
  dWorldSetLinearDampingThreshold(world, 0);
  dWorldSetAngularDamping(world, 1 - exp(-2 * h));
  dWorldSetAngularDampingThreshold(world, 0);
  make_ball(add(0, 0, 10), 1, 0.1);
  dBodySetLinearVel(bodies[0], 1, 0, 0);
  dBodySetAngularVel(bodies[0], 0, 3, 4);
}

/* The same, slower than what damping asks for. */
static void too_slow(void) {
  damped();
  dBodySetLinearDampingThreshold(bodies[0], 1e3);
  dBodySetAngularDampingThreshold(bodies[0], 1e3);
}

/* A box without weight that damping slows until it is at 0.9 m/s and turns at 4 rad/s, about an axis of its own. */
static void slows_down(void) {
  float_at(0, 0, 0);
  dBodySetLinearVel(bodies[0], 1, 0, 0);
  dBodySetAngularVel(bodies[0], 0, 0, 5);
  dBodySetLinearDamping(bodies[0], 1 - exp(-h));
  dBodySetLinearDampingThreshold(bodies[0], 0.9);
  dBodySetAngularDamping(bodies[0], 1 - exp(-2 * h));
  dBodySetAngularDampingThreshold(bodies[0], 4);
}

/* A ball that damping slows: its velocity is averaged over 10 ms, and slow for 50 ms it is put to sleep, 0.11 m early.
 */
static unsigned samples(void) { return (unsigned)lround(0.01 / h); }
static void tired(void) {
  damped();
  dBodySetAngularVel(bodies[0], 0, 0, 0);
  dWorldSetGravity(world, 0, 0, 0);
  dBodySetAutoDisableFlag(bodies[0], 1);
  dBodySetAutoDisableLinearThreshold(bodies[0], 0.5);
  dBodySetAutoDisableTime(bodies[0], 0);
  dBodySetAutoDisableSteps(bodies[0], (int)lround(0.05 / h));
  dJointAttach(dJointCreateNull(world, 0), bodies[0], 0); /* without a joint none is put to sleep */
}

static void sleeper(void) {
  tired();
  dBodySetAutoDisableAverageSamplesCount(bodies[0], samples());
}

/* Its samples are those of the world that it is made in. */
static void born_sleeper(void) {
  dWorldSetAutoDisableAverageSamplesCount(world, samples());
  tired();
}

static dBodyID fly(double speed) {
  dBodyID body = dBodyCreate(world);
  dBodySetGravityMode(body, 0);
  dBodySetLinearVel(body, speed, 0, 0);
  return body;
}

static dBodyID goes;
static void set_by_hand(void) {
  static int step;
  ++step;
  if (step == 100) dBodySetLinearVel(bodies[0], 3, 0, 0);
  if (step == 200) fly(2);
  if (step == 300) dBodyDestroy(goes);
  const dReal* place = dBodyGetPosition(bodies[1]);
  if (step == 400) dBodySetPosition(bodies[1], place[0], place[1], place[2] + 2);
}

/* Of bodies of a kilogram, one that floats is given 3 m/s, one of 2 m/s comes, one of 1 m/s goes, and one that falls is
 * put 2 m up. */
static void by_hand(void) {
  bodies[count++] = fly(0);
  goes = fly(1);
  add(0, 0, 0);
  control = set_by_hand;
}

static dWorldID second;
static void step_the_second(void) { dWorldStep(second, h); }

/* Two worlds, the second of which is stepped first. */
static void two_worlds(void) {
  second = dWorldCreate();
  dBodyCreate(second);
  add(0, 0, 0);
  control = step_the_second;
}

/* A world that is never stepped is made before the one that is. */
static void second_only(void) {
  dBodyCreate(world);
  dWorldSetGravity(world, 0, 0, -1);
  world = dWorldCreate();
  dWorldSetGravity(world, 0, 0, -3);
  dWorldSetERP(world, 0.3);
  add(0, 0, 0);
}

const Scenario of_bodies[] = {
    {"free_box", free_box, 0},       {"damped", damped, 0},
    {"too_slow", too_slow, 0},       {"slows_down", slows_down, 0},
    {"sleeper", sleeper, 0},         {"born_sleeper", born_sleeper, 0},
    {"by_hand", by_hand, 0},         {"two_worlds", two_worlds, 0},
    {"second_only", second_only, 0}, {0, 0, 0},
};
