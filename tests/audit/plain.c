/* Programs as users of ODE write them: some of the project's scenarios, with nothing of the project in them.
 *
 *   plain SCENARIO H SECONDS [POSES]
 *
 * POSES gets a line a step and body, position and quaternion in hexadecimal. */
#include <ode/ode.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { most_bodies = 64 };

static dWorldID world;
static dSpaceID space;
static dJointGroupID contacts;
static dBodyID bodies[most_bodies];
static int count;
static double h;
static double bounce, friction, friction2;
static const dReal* first_direction; /* of friction; 0: ODE's */
static enum { hard, soft, only_soft_erp, only_soft_cfm } contact_is;
static void (*control)(void);

static dBodyID add(double x, double y, double z) {
  dBodyID body = dBodyCreate(world);
  dBodySetPosition(body, x, y, z);
  bodies[count++] = body;
  return body;
}

static void make_box(dBodyID body, double mass, double x, double y, double z) {
  dMass m;
  dMassSetBoxTotal(&m, mass, x, y, z);
  dBodySetMass(body, &m);
  dGeomSetBody(dCreateBox(space, x, y, z), body);
}

static void make_ball(dBodyID body, double mass, double radius) {
  dMass m;
  dMassSetSphereTotal(&m, mass, radius);
  dBodySetMass(body, &m);
  dGeomSetBody(dCreateSphere(space, radius), body);
}

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

static void free_box(void) {
  dWorldSetGravity(world, 0, 0, -9.8);
  make_box(add(0, 0, 0), 10, 0.1, 0.4, 0.9);
  dBodySetLinearVel(bodies[0], -2, 2, 8);
  dBodySetAngularVel(bodies[0], 0.1, 5, 0.1);
}

static void bouncing_ball(void) {
  bounce = 0.7;
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 1.1), 1, 0.1);
}

static void friction_slide(void) {
  friction = 0.3;
  dCreatePlane(space, 0, 0, 1, 0);
  make_box(add(0, 0, 0.05), 2, 0.4, 0.4, 0.1);
  dBodySetLinearVel(bodies[0], 2, 0, 0);
}

/* The same box, askew, with a third of the friction along the second of ODE's directions, x, or across a slope's. */
static void two_frictions(void) {
  friction_slide();
  friction2 = 0.1;
  dBodySetLinearVel(bodies[0], 2, 1, 0);
}

static void directed_frictions(void) {
  static const dVector3 slope = {0.6, 0.8, 0};
  two_frictions();
  first_direction = slope;
}

/* A weight of 1 kg that a motor of at most 15 N lifts at 0.5 m/s, from rest. */
static void motor(void) {
  make_box(add(0, 0, 1), 1, 0.1, 0.1, 0.1);
  dJointID slider = dJointCreateSlider(world, 0);
  dJointAttach(slider, bodies[0], 0);
  dJointSetSliderAxis(slider, 0, 0, 1);
  dJointSetSliderParam(slider, dParamVel, 0.5);
  dJointSetSliderParam(slider, dParamFMax, 15);
}

/* Springs of 1000 N/m and 20 N s/m, as ERP and CFM at this step. */
static double erp(void) { return h * 1000 / (h * 1000 + 20); }
static double cfm(void) { return 1 / (h * 1000 + 20); }

/* A ball joint that is 0.1 m open. */
static void spring(void) {
  dWorldSetERP(world, erp());
  dWorldSetCFM(world, cfm());
  make_box(add(0, 0, 1), 1, 0.1, 0.1, 0.1);
  dJointID ball = dJointCreateBall(world, 0);
  dJointAttach(ball, bodies[0], 0);
  dJointSetBallAnchor(ball, 0, 0, 1);
  dBodySetPosition(bodies[0], 0.1, 0, 1);
}

/* A slider that falls on its stop. */
static void soft_stop(void) {
  make_box(add(0, 0, 1), 1, 0.1, 0.1, 0.1);
  dJointID slider = dJointCreateSlider(world, 0);
  dJointAttach(slider, bodies[0], 0);
  dJointSetSliderAxis(slider, 0, 0, 1);
  dJointSetSliderParam(slider, dParamLoStop, -0.1);
  dJointSetSliderParam(slider, dParamHiStop, 10);
  dJointSetSliderParam(slider, dParamStopERP, erp());
  dJointSetSliderParam(slider, dParamStopCFM, cfm());
}

/* A box that is welded with a spring of its own, and 0.1 m away. */
static void soft_weld(void) {
  make_box(add(0, 0, 1), 1, 0.1, 0.1, 0.1);
  dJointID weld = dJointCreateFixed(world, 0);
  dJointAttach(weld, bodies[0], 0);
  dJointSetFixed(weld);
  dJointSetFixedParam(weld, dParamERP, erp());
  dJointSetFixedParam(weld, dParamCFM, cfm());
  dBodySetPosition(bodies[0], 0.1, 0, 1);
}

/* A wheel on the suspension of something that stands still, 0.1 m below. */
static void suspension(void) {
  dBodyID chassis = dBodyCreate(world);
  dBodySetPosition(chassis, 0, 0, 1);
  dBodySetKinematic(chassis);
  make_ball(add(0, 0.5, 1), 1, 0.1);
  dJointID fork = dJointCreateHinge2(world, 0);
  dJointAttach(fork, chassis, bodies[0]);
  dJointSetHinge2Anchor(fork, 0, 0.5, 1);
  const dVector3 up = {0, 0, 1}, along = {0, 1, 0};
  dJointSetHinge2Axes(fork, up, along);
  dJointSetHinge2Param(fork, dParamSuspensionERP, erp());
  dJointSetHinge2Param(fork, dParamSuspensionCFM, cfm());
  dBodySetPosition(bodies[0], 0, 0.5, 0.9);
}

/* A mast that one motor turns, a boom beside it that another pushes out, and a hook on it that a third turns back; none
 * gets to its speed. */
static void crane(void) {
  make_box(add(0.3, -0.2, 2), 1, 0.1, 0.1, 0.1);
  make_box(add(1, 0.5, 2), 1, 0.1, 0.1, 0.1);
  make_box(add(1.7, 0.5, 2), 1, 0.1, 0.1, 0.1);
  dJointID mast = dJointCreateHinge(world, 0);
  dJointAttach(mast, bodies[0], 0);
  dJointSetHingeAnchor(mast, 0, 0, 2);
  dJointSetHingeAxis(mast, 0, 0, 1);
  dJointSetHingeParam(mast, dParamVel, 100);
  dJointSetHingeParam(mast, dParamFMax, 5);
  dJointID boom = dJointCreateSlider(world, 0);
  dJointAttach(boom, bodies[1], bodies[0]);
  dJointSetSliderAxis(boom, 1, 0, 0);
  dJointSetSliderParam(boom, dParamVel, 100);
  dJointSetSliderParam(boom, dParamFMax, 3);
  dJointID hook = dJointCreateHinge(world, 0);
  dJointAttach(hook, bodies[2], bodies[1]);
  dJointSetHingeAnchor(hook, 1.2, 0.5, 2);
  dJointSetHingeAxis(hook, 0, 0, 1);
  dJointSetHingeParam(hook, dParamVel, -100);
  dJointSetHingeParam(hook, dParamFMax, 2);
}

static void soften(dJointID joint, void (*set)(dJointID, int, dReal), int groups) {
  for (int i = 0; i < groups; ++i) {
    set(joint, i * dParamGroup + dParamLoStop, -0.1);
    set(joint, i * dParamGroup + dParamHiStop, 0.1);
    set(joint, i * dParamGroup + dParamStopERP, erp());
    set(joint, i * dParamGroup + dParamStopCFM, cfm());
  }
}

static dBodyID float_at(double x, double y, double z) {
  dBodyID body = add(x, y, z);
  make_box(body, 1, 0.1, 0.1, 0.1);
  dBodySetGravityMode(body, 0);
  return body;
}

/* A weight on a slider, a pair on a hinge and a box on a hinge from the world to it: the motor of each presses it on a
 * soft stop. */
static void pressed(void) {
  make_box(add(0, 0, 1), 1, 0.1, 0.1, 0.1);
  dJointID slider = dJointCreateSlider(world, 0);
  dJointAttach(slider, bodies[0], 0);
  dJointSetSliderAxis(slider, 0, 0, 1);
  soften(slider, dJointSetSliderParam, 1);
  dJointSetSliderParam(slider, dParamVel, 0.5);
  dJointSetSliderParam(slider, dParamFMax, 15);
  dJointID hinge[2];
  for (int i = 0; i < 2; ++i) {
    dBodyID first = float_at(2 + 4 * i, 0, 0);
    hinge[i] = dJointCreateHinge(world, 0);
    dJointAttach(hinge[i], i == 0 ? first : 0, i == 0 ? float_at(3, 0, 0) : first);
    dJointSetHingeAnchor(hinge[i], 2.5 + 3.5 * i, 0, 0);
    dJointSetHingeAxis(hinge[i], 0, 1, 0);
    soften(hinge[i], dJointSetHingeParam, 1);
    dJointSetHingeParam(hinge[i], dParamHiStop, 1);
    dJointSetHingeParam(hinge[i], dParamVel, -10);
    dJointSetHingeParam(hinge[i], dParamFMax, 5);
  }
}

/* Two boxes that float on a universal, one of which hangs from the world, the other has the world on it; each is turned
 * about the axis that its first parameters are of, and a third is pressed on a stop there. */
static void crossed(void) {
  for (int i = 0; i < 3; ++i) {
    dBodyID body = float_at(5 * i + 0.5, 0, 1);
    dJointID cross = dJointCreateUniversal(world, 0);
    dJointAttach(cross, i == 0 ? body : 0, i == 0 ? 0 : body);
    dJointSetUniversalAnchor(cross, 5 * i, 0, 1);
    dJointSetUniversalAxis1(cross, 0, i == 0, i != 0);
    dJointSetUniversalAxis2(cross, 0, i != 0, i == 0);
    dJointSetUniversalParam(cross, dParamVel, i == 2 ? -100 : 100);
    dJointSetUniversalParam(cross, dParamFMax, 0.3);
    if (i == 2) soften(cross, dJointSetUniversalParam, 1);
  }
  /* Motors on both axes, which both are always at their limits. */
  dJointID both = dJointCreateUniversal(world, 0);
  dJointAttach(both, float_at(15.5, 0, 1), 0);
  dJointSetUniversalAnchor(both, 15, 0, 1);
  dJointSetUniversalAxis1(both, 0, 1, 0);
  dJointSetUniversalAxis2(both, 0, 0, 1);
  dJointSetUniversalParam(both, dParamVel, 100);
  dJointSetUniversalParam(both, dParamFMax, 0.01);
  dJointSetUniversalParam(both, dParamVel2, 100);
  dJointSetUniversalParam(both, dParamFMax2, 0.01);
}

/* Every kind of joint with stops, soft ones, each with a weight of its own that gets to them. */
static void soft_stops(void) {
  dWorldSetERP(world, erp());
  dWorldSetCFM(world, cfm());
  for (int i = 0; i < 8; ++i) make_box(add(5 * i + 0.5, 0, 1), 1, 0.1, 0.2, 0.3);
  dJointID hinge = dJointCreateHinge(world, 0);
  dJointAttach(hinge, bodies[0], 0);
  dJointSetHingeAnchor(hinge, 0, 0, 1);
  dJointSetHingeAxis(hinge, 0, 1, 0);
  soften(hinge, dJointSetHingeParam, 1);
  for (int i = 1; i < 3; ++i) { /* on the first axis, and on the second */
    dJointID cross = dJointCreateUniversal(world, 0);
    dJointAttach(cross, bodies[i], 0);
    dJointSetUniversalAnchor(cross, 5 * i, 0, 1);
    dJointSetUniversalAxis2(cross, 0, i == 2, i == 1);
    dJointSetUniversalAxis1(cross, 0, i == 1, i == 2);
    soften(cross, dJointSetUniversalParam, 2);
  }
  dJointID pr = dJointCreatePR(world, 0);
  dJointAttach(pr, bodies[3], 0);
  dJointSetPRAnchor(pr, 15, 0, 1);
  dJointSetPRAxis1(pr, 0, 0, 1);
  dJointSetPRAxis2(pr, 0, 1, 0);
  dBodySetAngularVel(bodies[3], 0, 3, 0);
  soften(pr, dJointSetPRParam, 2);
  dJointID pu = dJointCreatePU(world, 0);
  dJointAttach(pu, bodies[4], 0);
  dJointSetPUAnchor(pu, 20, 0, 1);
  dJointSetPUAxis1(pu, 1, 0, 0);
  dJointSetPUAxis2(pu, 0, 1, 0);
  dJointSetPUAxis3(pu, 0, 0, 1);
  dBodySetAngularVel(bodies[4], 3, 0, 0);
  soften(pu, dJointSetPUParam, 3);
  dJointID piston = dJointCreatePiston(world, 0);
  dJointAttach(piston, bodies[5], 0);
  dJointSetPistonAnchor(piston, 25.5, 0, 1);
  dJointSetPistonAxis(piston, 0, 0, 1);
  dBodySetAngularVel(bodies[5], 0, 0, 3);
  soften(piston, dJointSetPistonParam, 2);
  dJointID turner = dJointCreateAMotor(world, 0); /* whose angles the program tells */
  dJointAttach(turner, bodies[6], 0);
  dJointSetAMotorNumAxes(turner, 3);
  for (int i = 0; i < 3; ++i) {
    dJointSetAMotorAxis(turner, i, 0, i == 0, i == 1, i == 2);
    dJointSetAMotorAngle(turner, i, -0.2);
  }
  dBodySetGravityMode(bodies[6], 0);
  soften(turner, dJointSetAMotorParam, 3);
  dBodyID chassis = dBodyCreate(world);
  dBodySetKinematic(chassis);
  dBodySetPosition(chassis, 35, 0, 1);
  dJointID fork = dJointCreateHinge2(world, 0);
  dJointAttach(fork, chassis, bodies[7]);
  dJointSetHinge2Anchor(fork, 35.5, 0, 1);
  const dVector3 up = {0, 0, 1}, along = {0, 1, 0};
  dJointSetHinge2Axes(fork, up, along);
  dBodySetAngularVel(bodies[7], 0, 0, 3);
  soften(fork, dJointSetHinge2Param, 1);
}

/* A ball on soft ground. */
static void soft_contact(void) {
  contact_is = soft;
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 0.2), 1, 0.1);
}

/* The same, where the contact has the one number and the world the other. */
static void soft_erp_contact(void) {
  soft_contact();
  contact_is = only_soft_erp;
  dWorldSetCFM(world, cfm());
}

static void soft_cfm_contact(void) {
  soft_contact();
  contact_is = only_soft_cfm;
  dWorldSetERP(world, erp());
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

/* Bodies without weight, that no ERP takes back: a hinge, a ball, a universal, a slider and a weld, all of which the
 * program opens, the slider by as much across its axis, and by more along it. Before, it turns what is welded. */
static void open_joints(void) {
  static long steps = 0;
  ++steps;
  if (steps == 3) {
    const dQuaternion quarter = {sqrt(0.5), 0, 0, sqrt(0.5)};
    dBodySetQuaternion(bodies[4], quarter);
    dBodySetQuaternion(bodies[5], quarter);
    dBodySetPosition(bodies[4], 25.5, 1, 1); /* it was 1 m beside the other */
  }
  if (steps != 5) return;
  for (int i = 0; i < 5; ++i) {
    const dReal* at = dBodyGetPosition(bodies[i]);
    dBodySetPosition(bodies[i], at[0] + (i == 3 ? 0.3 : 0), at[1], at[2] + 0.1 + 0.01 * i);
  }
}
static void apart(void) {
  dWorldSetERP(world, 0);
  for (int i = 0; i < 4; ++i) float_at(5 * i + 0.5, 0, 1);
  float_at(26.5, 0, 1);
  float_at(25.5, 0, 1);
  dJointID hinge = dJointCreateHinge(world, 0);
  dJointAttach(hinge, bodies[0], 0);
  dJointSetHingeAnchor(hinge, 0, 0, 1);
  dJointSetHingeAxis(hinge, 0, 1, 0);
  dJointID ball = dJointCreateBall(world, 0);
  dJointAttach(ball, bodies[1], 0);
  dJointSetBallAnchor(ball, 5, 0, 1);
  dJointID cross = dJointCreateUniversal(world, 0);
  dJointAttach(cross, bodies[2], 0);
  dJointSetUniversalAnchor(cross, 10, 0, 1);
  dJointSetUniversalAxis1(cross, 0, 1, 0);
  dJointSetUniversalAxis2(cross, 0, 0, 1);
  dJointID slider = dJointCreateSlider(world, 0);
  dJointAttach(slider, bodies[3], float_at(20.5, 0, 1));
  dJointSetSliderAxis(slider, 1, 0, 0);
  dJointID weld = dJointCreateFixed(world, 0);
  dJointAttach(weld, bodies[4], bodies[5]);
  dJointSetFixed(weld);
  control = open_joints;
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

static dJointFeedback touched[8];
static int touches;
static void push_as_touched(void) {
  double sum = 0;
  for (int i = 0; i < touches; ++i) sum += touched[i].f1[2];
  dBodyAddForce(bodies[0], 0.05 * sum, 0, 0);
  touches = 0;
}

/* A ball that falls on the ground and stays there, pushed along by a part of what its contacts, one after the other,
 * were felt to do in the step before. */
static void touchy(void) {
  bouncing_ball();
  bounce = 0;
  control = push_as_touched;
}

/* A box that rests on four contacts, all of which are felt at one place, pushed by a part of that. */
static void push_as_touched_last(void) {
  dBodyAddForce(bodies[0], 0.2 * touched[0].f1[2], 0, 0);
  touches = 0;
}
static void shared(void) {
  dCreatePlane(space, 0, 0, 1, 0);
  make_box(add(0, 0, 0.05), 1, 0.4, 0.4, 0.1);
  control = push_as_touched_last;
}

/* Of a heavy plate and a ball on it, that floats but for the force that presses it down, what the second of the two
 * feels: it is pushed along by a part of it, and of the torque that it feels another way. */
static void push_as_the_second_touched(void) {
  double force = 0, torque = 0;
  for (int i = 0; i < touches; ++i) force += touched[i].f2[2], torque += touched[i].t2[1];
  dBodyAddForce(bodies[0], 0.05 * force, 0.5 * torque, -9.81);
  touches = 0;
}
static void second_touch(void) {
  friction = 0.1;
  dBodyID plate = dBodyCreate(world); /* in the space before the ball */
  dBodySetGravityMode(plate, 0);
  make_box(plate, 1000, 4, 4, 0.1);
  make_ball(add(0, 0, 0.15), 1, 0.1);
  dBodySetGravityMode(bodies[0], 0);
  control = push_as_the_second_touched;
}

/* A ball that rests, pushed as ODE's random numbers say, of which its callback draws as well. */
static void push_at_random(void) { dBodyAddForce(bodies[0], 10 * dRandReal() - 5, 0, 0); }
static void drawn(void) {
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 0.1), 1, 0.1);
  control = push_at_random;
}

/* A ball that slides, on one contact. */
static void skid(void) {
  friction = 0.3;
  dCreatePlane(space, 0, 0, 1, 0);
  make_ball(add(0, 0, 0.1), 1, 0.1);
  dBodySetLinearVel(bodies[0], 5, 0, 0);
}

/* A body that floats, on which 2 N act, and a weight that is welded to a lift, 0.3 m beside it, which the program moves
 * and pushes in vain. */
static dBodyID lift;
static void pull(void) {
  dBodyAddForce(bodies[0], 2, 0, 0);
  dBodyAddForce(lift, 0, 0, 100);
}
static void lifted(void) {
  float_at(5, 0, 0);
  lift = dBodyCreate(world);
  dBodySetKinematic(lift);
  dBodySetLinearVel(lift, 0, 0, 0.5);
  dBodyID weight = add(0.3, 0, 0);
  dBodySetLinearVel(weight, 0, 0, 0.5);
  dJointID weld = dJointCreateFixed(world, 0);
  dJointAttach(weld, lift, weight);
  dJointSetFixed(weld);
  control = pull;
}

/* Sliders at their soft stops, with motors of 5 N: one that would leave the low one with a fifth of it, and two that
 * are to stand still, at the low stop and, without weight, at the high one. */
static void at_stops(void) {
  for (int i = 0; i < 3; ++i) {
    dBodyID body = float_at(2 * i, 0, 0);
    dBodySetGravityMode(body, i < 2);
    dJointID slider = dJointCreateSlider(world, 0);
    dJointAttach(slider, body, 0);
    dJointSetSliderAxis(slider, 0, 0, 1);
    soften(slider, dJointSetSliderParam, 1);
    dJointSetSliderParam(slider, i < 2 ? dParamLoStop : dParamHiStop, 0);
    dJointSetSliderParam(slider, dParamVel, i == 0);
    dJointSetSliderParam(slider, dParamFMax, 5);
    dJointSetSliderParam(slider, dParamFudgeFactor, 0.2);
  }
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

static void near(void* data, dGeomID one, dGeomID other) {
  (void)data;
  dContact contact[8];
  memset(contact, 0, sizeof contact);
  int found = dCollide(one, other, 8, &contact[0].geom, sizeof(dContact));
  for (int i = 0; i < found; ++i) {
    contact[i].surface.mode = dContactBounce | dContactApprox1;
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
    if (control == push_at_random) dRand();
    dJointID touch = dJointCreateContact(world, contacts, &contact[i]);
    dJointAttach(touch, dGeomGetBody(one), dGeomGetBody(other));
    if (control == push_as_touched_last) dJointSetFeedback(touch, &touched[0]);
    if ((control == push_as_touched || control == push_as_the_second_touched) && touches < 8)
      dJointSetFeedback(touch, &touched[touches++]);
  }
}

static const struct {
  const char* name;
  void (*make)(void);
  int touches;
} scenarios[] = {
    {"double_pendulum", double_pendulum, 0},
    {"chain", chain, 0},
    {"free_box", free_box, 0},
    {"bouncing_ball", bouncing_ball, 1},
    {"friction_slide", friction_slide, 1},
    {"two_frictions", two_frictions, 1},
    {"directed_frictions", directed_frictions, 1},
    {"wall_pendulum", wall_pendulum, 1},
    {"motor", motor, 0},
    {"arm", arm, 0},
    {"spring", spring, 0},
    {"soft_stop", soft_stop, 0},
    {"soft_contact", soft_contact, 1},
    {"damped", damped, 0},
    {"sleeper", sleeper, 0},
    {"born_sleeper", born_sleeper, 0},
    {"soft_weld", soft_weld, 0},
    {"suspension", suspension, 0},
    {"crane", crane, 0},
    {"pressed", pressed, 0},
    {"soft_stops", soft_stops, 0},
    {"feeling", feeling, 0},
    {"touchy", touchy, 1},
    {"weighing", weighing, 0},
    {"apart", apart, 0},
    {"too_slow", too_slow, 0},
    {"shared", shared, 1},
    {"second_touch", second_touch, 1},
    {"soft_erp_contact", soft_erp_contact, 1},
    {"soft_cfm_contact", soft_cfm_contact, 1},
    {"drawn", drawn, 1},
    {"skid", skid, 1},
    {"lifted", lifted, 0},
    {"at_stops", at_stops, 0},
    {"crossed", crossed, 0},
    {"second_only", second_only, 0},
    {"by_hand", by_hand, 0},
    {"two_worlds", two_worlds, 0},
};

static void write_poses(FILE* poses) {
  for (int i = 0; i < count; ++i) {
    const dReal* p = dBodyGetPosition(bodies[i]);
    const dReal* q = dBodyGetQuaternion(bodies[i]);
    fprintf(poses, "%a %a %a %a %a %a %a\n", p[0], p[1], p[2], q[0], q[1], q[2], q[3]);
  }
}

int main(int argc, char** argv) {
  const unsigned known = sizeof scenarios / sizeof scenarios[0];
  unsigned which = 0;
  while (argc >= 4 && which < known && strcmp(scenarios[which].name, argv[1]) != 0) ++which;
  if (argc < 4 || which == known) {
    fprintf(stderr, "usage: plain SCENARIO H SECONDS [POSES]\n");
    return 2;
  }
  h = atof(argv[2]);
  dInitODE2(0);
  world = dWorldCreate();
  space = dHashSpaceCreate(0);
  contacts = dJointGroupCreate(0);
  dWorldSetGravity(world, 0, 0, -9.81);
  scenarios[which].make();
  FILE* poses = argc > 4 ? fopen(argv[4], "w") : 0;
  const long steps = lround(atof(argv[3]) / h);
  for (long i = 0; i < steps; ++i) {
    if (control) control();
    if (scenarios[which].touches) dSpaceCollide(space, 0, near);
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
