/* Links on hinges: left alone, against a wall, held by a controller, felt by their feedback. */
#include "plain.h"

/* Links of 1 m and 1 kg in the y-z plane, hinged at (0, 0, 2.1); the first at 45 degrees, the others level. */
static void links(int n) {
  double y = 0, z = 2.1;
  dBodyID before = 0;
  for (int i = 0; i < n; ++i) {
    double angle = i == 0 ? M_PI / 4 : 0;
    dMatrix3 turn;
    dBodyID link = add(0, y + cos(angle) / 2, z + sin(angle) / 2);
    dRFromAxisAndAngle(turn, 1, 0, 0, angle);
    dBodySetRotation(link, turn);
    make_box(link, 1, 0.1, 1, 0.1);
    dJointID hinge = dJointCreateHinge(world, 0);
    dJointAttach(hinge, link, before);
    dJointSetHingeAnchor(hinge, 0, y, z);
    dJointSetHingeAxis(hinge, 1, 0, 0);
    y += cos(angle);
    z += sin(angle);
    before = link;
  }
}

static void double_pendulum(void) { links(2); }
static void chain(void) { links(10); }

/* A link that swings down from the horizontal against a wall. */
static void wall_pendulum(void) {
  bounce = 1;
  dWorldSetGravity(world, 0, 0, -9.8);
  make_box(add(1.5, 0, 3), 1, 1, 0.1, 0.1);
  dJointID hinge = dJointCreateHinge(world, 0);
  dJointAttach(hinge, bodies[0], 0);
  dJointSetHingeAnchor(hinge, 1, 0, 3);
  dJointSetHingeAxis(hinge, 0, 1, 0);
  dGeomSetPosition(dCreateBox(space, 1.8, 2, 6), 0, 0, 3);
}

static dJointID elbow;
static void hold_the_arm(void) {
  dJointAddHingeTorque(elbow, -20 * dJointGetHingeAngle(elbow) - 2 * dJointGetHingeAngleRate(elbow));
}

/* The first link of the pendulums with a controller at its hinge. */
static void arm(void) {
  links(1);
  elbow = dBodyGetJoint(bodies[0], 0);
  control = hold_the_arm;
}

static dJointFeedback felt;
static void push_as_felt(void) { dBodyAddForce(bodies[0], 0, 0, -0.2 * felt.f1[2]); }

/* The same link, pushed by a part of what its hinge was felt to do in the step before. */
static void feeling(void) {
  links(1);
  dJointSetFeedback(dBodyGetJoint(bodies[0], 0), &felt);
  control = push_as_felt;
}

/* The same link, left alone, which ends the program if what its hinge was felt to do, with its weight, is not what its
 * momentum changed by: in ODE it is, to rounding, whatever the step. */
static void weigh_what_was_felt(void) {
  static int looked = 0;
  static dReal before[3], turned_before;
  const dReal* v = dBodyGetLinearVel(bodies[0]);
  const dReal turned = dBodyGetAngularVel(bodies[0])[0]; /* about the hinge's axis */
  dVector3 gravity;
  dWorldGetGravity(world, gravity);
  dMass mass;
  dBodyGetMass(bodies[0], &mass);
  for (int i = 0; i < 3; ++i) {
    const double left = mass.mass * (v[i] - before[i] - h * gravity[i]) - h * felt.f1[i];
    if (looked && fabs(left) > 1e-12) exit(4);
    before[i] = v[i];
  }
  if (looked && fabs(mass.I[0] * (turned - turned_before) - h * felt.t1[0]) > 1e-12) exit(4);
  turned_before = turned;
  looked = 1;
}
static void weighing(void) {
  feeling();
  control = weigh_what_was_felt;
}

const Scenario of_pendulums[] = {
    {"double_pendulum", double_pendulum, 0},
    {"chain", chain, 0},
    {"wall_pendulum", wall_pendulum, 1},
    {"arm", arm, 0},
    {"feeling", feeling, 0},
    {"weighing", weighing, 0},
    {0, 0, 0},
};
