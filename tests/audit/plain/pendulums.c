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

static dJointFeedback felt[2]; /* of the hinge by which each link hangs */
static void feel_hinges(void) {
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < dBodyGetNumJoints(bodies[i]); ++j) {
      dJointID hinge = dBodyGetJoint(bodies[i], j);
      if (dJointGetBody(hinge, 0) == bodies[i]) dJointSetFeedback(hinge, &felt[i]);
    }
  }
}
static void push_as_felt(void) { dBodyAddForce(bodies[0], 0, 0, -0.2 * felt[0].f1[2]); }

/* The same link, pushed by a part of what its hinge was felt to do in the step before. */
static void feeling(void) {
  links(1);
  feel_hinges();
  control = push_as_felt;
}

/* Two links, left alone, which end the program if what their hinges were felt to do to each, with its weight, is not
 * what its momentum changed by: in ODE it is, to rounding, whatever the step. */
static void weigh_what_was_felt(void) {
  static int looked = 0;
  static dReal before[2][3], turned_before[2];
  for (int link = 0; link < count; ++link) {
    const dReal* v = dBodyGetLinearVel(bodies[link]);
    const dReal turned = dBodyGetAngularVel(bodies[link])[0]; /* about the hinge's axis */
    const int bears = link + 1 < count;
    dVector3 gravity;
    dWorldGetGravity(world, gravity);
    dMass mass;
    dBodyGetMass(bodies[link], &mass);
    for (int i = 0; i < 3; ++i) {
      const double force = felt[link].f1[i] + (bears ? felt[link + 1].f2[i] : 0);
      const double left = mass.mass * (v[i] - before[link][i] - h * gravity[i]) - h * force;
      if (looked && fabs(left) > 1e-12) exit(4);
      before[link][i] = v[i];
    }
    const double torque = felt[link].t1[0] + (bears ? felt[link + 1].t2[0] : 0);
    if (looked && fabs(mass.I[0] * (turned - turned_before[link]) - h * torque) > 1e-12) exit(4);
    turned_before[link] = turned;
  }
  looked = 1;
}
static void weighing(void) {
  links(2);
  feel_hinges();
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
