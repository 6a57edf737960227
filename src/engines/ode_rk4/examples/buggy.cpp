// A buggy on four hinge2 wheels with suspension; the hind ones drive.
//
//   buggy | buggy accurate
#include "either_step.hpp"

int main(int argc, char** argv) {
  constexpr double h = 5e-3, radius = 0.18;
  EitherStep step(argc, argv, {0, 0.9});
  dCreatePlane(step.space, 0, 0, 1, 0);
  const dBodyID chassis = box(step, 10, 0, 0, 0.3, 1, 0.5, 0.15);
  for (const double x : {-0.4, 0.4}) {
    for (const double y : {-0.32, 0.32}) {
      const dJointID joint = dJointCreateHinge2(step.world, nullptr);
      const dVector3 up = {0, 0, 1}, across = {0, 1, 0};
      dJointAttach(joint, chassis, ball(step, 0.5, x, y, radius, radius));
      dJointSetHinge2Anchor(joint, x, y, radius);
      dJointSetHinge2Axes(joint, up, across);
      dJointSetHinge2Param(joint, dParamLoStop, 0);  // no steering
      dJointSetHinge2Param(joint, dParamHiStop, 0);
      dJointSetHinge2Param(joint, dParamSuspensionERP, 0.4);
      dJointSetHinge2Param(joint, dParamSuspensionCFM, 6e-3);  // 13 kN/m, 100 N s/m at this step
      if (x > 0) continue;
      dJointSetHinge2Param(joint, dParamVel2, -10);
      dJointSetHinge2Param(joint, dParamFMax2, 2);
    }
  }
  for (double t = 0; t < 3; t += h) step(h);
  std::printf("buggy, %s: %.3f m in 3 s\n", step.name(), dBodyGetPosition(chassis)[0]);
}
