// A figure of eleven bodies on ball joints falls on the ground.
//
//   ragdoll | ragdoll accurate
#include "either_step.hpp"

int main(int argc, char** argv) {
  EitherStep step(argc, argv, {0, 0.5});
  dCreatePlane(step.space, 0, 0, 1, 0);
  const auto join = [&](dBodyID a, dBodyID b, double x, double y) {
    const dJointID joint = dJointCreateBall(step.world, nullptr);
    dJointAttach(joint, a, b);
    dJointSetBallAnchor(joint, x, y, 1);
  };
  const dBodyID trunk = box(step, 20, 0, 0, 1, 0.5, 0.3, 0.2);
  join(trunk, box(step, 4, 0.4, 0, 1, 0.2, 0.18, 0.2), 0.275, 0);
  const dBodyID pelvis = box(step, 10, -0.4, 0, 1, 0.2, 0.3, 0.2);
  join(trunk, pelvis, -0.275, 0);
  for (const double side : {-1.0, 1.0}) {
    const dBodyID upper = box(step, 2, 0.2, 0.32 * side, 1, 0.1, 0.28, 0.1);
    join(trunk, upper, 0.2, 0.165 * side);
    join(upper, box(step, 1.5, 0.2, 0.64 * side, 1, 0.08, 0.28, 0.08), 0.2, 0.48 * side);
    const dBodyID thigh = box(step, 7, -0.73, 0.1 * side, 1, 0.4, 0.13, 0.13);
    join(pelvis, thigh, -0.515, 0.1 * side);
    join(thigh, box(step, 4, -1.16, 0.1 * side, 1, 0.4, 0.11, 0.11), -0.945, 0.1 * side);
  }
  for (int k = 0; k < 600; ++k) step(5e-3);
  const dReal* const v = dBodyGetLinearVel(trunk);
  std::printf("ragdoll, %s: after 3 s its trunk is at z = %.4f m, at %.2g m/s\n", step.name(),
              dBodyGetPosition(trunk)[2], dCalcVectorLength3(v));
}
