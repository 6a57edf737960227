/* Joints that are springs, or open, or borne by what moves by itself. */
#include "plain.h"

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

/* A soft rod of a metre that holds a weight, one that is hinged at both its ends, and a gear that a weight beside its
 * axle turns, of which it turns another, half as fast, that has a weight as well. */
static void make_soft(dJointID joint, void (*set)(dJointID, int, dReal)) {
  set(joint, dParamERP, erp());
  set(joint, dParamCFM, cfm());
}
static void soft_rods(void) {
  dWorldSetERP(world, erp());
  dWorldSetCFM(world, cfm());
  for (int i = 0; i < 4; ++i) make_box(add(i < 2 ? 5 * i : 5 * i + 0.5, 0, 1), 4, 0.1, 0.2, 0.3);
  dJointID rod = dJointCreateDBall(world, 0);
  dJointAttach(rod, bodies[0], 0);
  dJointSetDBallAnchor1(rod, 0, 0, 1);
  dJointSetDBallAnchor2(rod, 0, 0.6, 1.8);
  make_soft(rod, dJointSetDBallParam);
  dJointID hinged = dJointCreateDHinge(world, 0);
  dJointAttach(hinged, bodies[1], 0);
  dJointSetDHingeAxis(hinged, 1, 0, 0);
  dJointSetDHingeAnchor1(hinged, 5, 0, 1);
  dJointSetDHingeAnchor2(hinged, 5, 0.6, 1.8);
  make_soft(hinged, dJointSetDHingeParam);
  for (int i = 2; i < 4; ++i) {
    dJointID axle = dJointCreateHinge(world, 0);
    dJointAttach(axle, bodies[i], 0);
    dJointSetHingeAnchor(axle, 5 * i, 0, 1);
    dJointSetHingeAxis(axle, 0, 1, 0);
  }
  dJointID gear = dJointCreateTransmission(world, 0);
  dJointAttach(gear, bodies[2], bodies[3]);
  dJointSetTransmissionMode(gear, dTransmissionParallelAxes);
  dJointSetTransmissionRatio(gear, 0.5);
  dJointSetTransmissionAnchor1(gear, 10, 0, 1);
  dJointSetTransmissionAnchor2(gear, 15, 0, 1);
  dJointSetTransmissionAxis(gear, 0, 1, 0);
  make_soft(gear, dJointSetTransmissionParam);
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

const Scenario of_joints[] = {
    {"spring", spring, 0},
    {"soft_weld", soft_weld, 0},
    {"soft_rods", soft_rods, 0},
    {"suspension", suspension, 0},
    {"apart", apart, 0},
    {"lifted", lifted, 0},
    {0, 0, 0},
};
