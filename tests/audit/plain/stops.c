/* Stops, soft ones, and motors that press on them. */
#include "plain.h"

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

void soften(dJointID joint, void (*set)(dJointID, int, dReal), int groups) {
  for (int i = 0; i < groups; ++i) {
    set(joint, i * dParamGroup + dParamLoStop, -0.1);
    set(joint, i * dParamGroup + dParamHiStop, 0.1);
    set(joint, i * dParamGroup + dParamStopERP, erp());
    set(joint, i * dParamGroup + dParamStopCFM, cfm());
  }
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

/* A box that a motor presses on a stop of a lift, with which it goes up. */
static void pressed_on_a_lift(void) {
  dBodyID lift = dBodyCreate(world);
  dBodySetKinematic(lift);
  dBodySetLinearVel(lift, 0, 0, 0.5);
  dBodySetLinearVel(float_at(0, 0, 1), 0, 0, 0.5);
  dJointID slider = dJointCreateSlider(world, 0);
  dJointAttach(slider, bodies[0], lift);
  dJointSetSliderAxis(slider, 0, 0, 1);
  dJointSetSliderParam(slider, dParamLoStop, -1);
  dJointSetSliderParam(slider, dParamHiStop, 0);
  dJointSetSliderParam(slider, dParamVel, 1);
  dJointSetSliderParam(slider, dParamFMax, 5);
}

/* Boxes that motors turn about hinges, where the angle is told from -pi to pi: to stops within that, past stops beyond
 * it, and to one of each. */
static void far_stops(void) {
  static const double stops[4][2] = {{-3.1, 3.1}, {-3.2, 3.2}, {-4, 3}, {-3, 4}};
  for (int i = 0; i < 4; ++i) {
    dJointID hinge = dJointCreateHinge(world, 0);
    dJointAttach(hinge, float_at(3 * i + 0.5, 0, 1), 0);
    dJointSetHingeAnchor(hinge, 3 * i, 0, 1);
    dJointSetHingeAxis(hinge, 0, 1, 0);
    dJointSetHingeParam(hinge, dParamLoStop, stops[i][0]);
    dJointSetHingeParam(hinge, dParamHiStop, stops[i][1]);
    dJointSetHingeParam(hinge, dParamVel, i < 3 ? 5 : -5);
    dJointSetHingeParam(hinge, dParamFMax, 5);
  }
}

const Scenario of_stops[] = {
    {"soft_stop", soft_stop, 0},
    {"pressed", pressed, 0},
    {"soft_stops", soft_stops, 0},
    {"at_stops", at_stops, 0},
    {"far_stops", far_stops, 0},
    {"pressed_on_a_lift", pressed_on_a_lift, 0},
    {0, 0, 0},
};
