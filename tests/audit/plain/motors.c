/* Motors. */
#include "plain.h"

/* A weight of 1 kg that a motor of at most 15 N lifts at 0.5 m/s, from rest. */
static void motor(void) {
  make_box(add(0, 0, 1), 1, 0.1, 0.1, 0.1);
  dJointID slider = dJointCreateSlider(world, 0);
  dJointAttach(slider, bodies[0], 0);
  dJointSetSliderAxis(slider, 0, 0, 1);
  dJointSetSliderParam(slider, dParamVel, 0.5);
  dJointSetSliderParam(slider, dParamFMax, 15);
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

/* Wheels without weight on something that stands still: a motor drives the first and another steers the second, neither
 * of which gets to its speed, and a third steers the last one to its stop. */
static void wheels(void) {
  dBodyID frame = dBodyCreate(world);
  dBodySetKinematic(frame);
  for (int i = 0; i < 3; ++i) {
    make_ball(add(3 * i, 0, 0), 1, 0.1);
    dBodySetGravityMode(bodies[i], 0);
    dJointID fork = dJointCreateHinge2(world, 0);
    dJointAttach(fork, frame, bodies[i]);
    dJointSetHinge2Anchor(fork, 3 * i, 0, 0);
    const dVector3 up = {0, 0, 1}, along = {0, 1, 0};
    dJointSetHinge2Axes(fork, up, along);
    dJointSetHinge2Param(fork, i == 0 ? dParamVel2 : dParamVel, 100);
    dJointSetHinge2Param(fork, i == 0 ? dParamFMax2 : dParamFMax, 0.01);
    if (i == 2) soften(fork, dJointSetHinge2Param, 1);
  }
}

const Scenario of_motors[] = {
    {"motor", motor, 0}, {"crane", crane, 0}, {"crossed", crossed, 0}, {"wheels", wheels, 0}, {0, 0, 0},
};
