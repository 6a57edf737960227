// An arm of two links that a controller (proportional, derivative, weight fed forward) brings to where it should be.
//
//   arm | arm accurate
#include <cmath>

#include "either_step.hpp"

int main(int argc, char** argv) {
  dJointID joints[2]{};
  const double wanted[2] = {0.8, -0.5}, kp[2] = {60, 20}, kd[2] = {12, 3};
  odeval::AccurateStepOptions options;
  // At each stage of a step, with joints as they are then; dWorldStep has them once a step.
  options.forces = [&](double) {
    const double q1 = dJointGetHingeAngle(joints[0]), q2 = dJointGetHingeAngle(joints[1]);
    const double weight2 = -9.81 * 0.25 * std::cos(q1 + q2);
    const double weight[2] = {-9.81 * (0.25 * std::cos(q1) + 0.5 * std::cos(q1)) + weight2, weight2};
    for (int i = 0; i < 2; ++i) {
      const double off = wanted[i] - dJointGetHingeAngle(joints[i]);
      dJointAddHingeTorque(joints[i], kp[i] * off - kd[i] * dJointGetHingeAngleRate(joints[i]) + weight[i]);
    }
  };
  EitherStep step(argc, argv, {}, options);
  const dBodyID upper = box(step, 1, 0.25, 0, 2, 0.5, 0.05, 0.05);
  const dBodyID lower = box(step, 1, 0.75, 0, 2, 0.5, 0.05, 0.05);
  joints[0] = hinge(step, upper, nullptr, 0, 0, 2);
  joints[1] = hinge(step, lower, upper, 0.5, 0, 2);

  for (int k = 0; k < 3000; ++k) step(1e-3);
  const double off = std::hypot(dJointGetHingeAngle(joints[0]) - wanted[0], dJointGetHingeAngle(joints[1]) - wanted[1]);
  std::printf("arm, %s: %.3g rad from where it should be after 3 s\n", step.name(), off);
  return off < 1e-3 ? 0 : 1;
}
