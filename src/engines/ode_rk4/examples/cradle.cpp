// Newton's cradle: five balls that touch, each on a rod of 1 m; the first is let go from 30 degrees. (dWorldStep
// complains that it does not solve their contacts, and they get faster.)
//
//   cradle | cradle accurate
#include <cmath>

#include "either_step.hpp"

int main(int argc, char** argv) {
  constexpr double radius = 0.1, length = 1, height = 2;
  odeval::AccurateStepOptions options;
  options.impact_order = odeval::ImpactOrder::in_turn;
  EitherStep step(argc, argv, {1, 0}, options);
  dJointID joints[5]{};
  for (int i = 0; i < 5; ++i) {
    const double x = 2 * radius * i, angle = i == 0 ? 0.5236 : 0;
    const dBodyID body = ball(step, 1, x - length * std::sin(angle), 0, height - length * std::cos(angle), radius);
    joints[i] = hinge(step, body, nullptr, x, 0, height);
  }
  double swing[5]{};  // largest to the right so far
  for (int k = 0; k < 1100; ++k) {
    step(1e-3);
    for (int i = 0; i < 5; ++i) {
      const dReal* at = dBodyGetPosition(dJointGetBody(joints[i], 0));
      swing[i] = std::fmax(swing[i], std::atan2(at[0] - 2 * radius * i, height - at[2]));
    }
  }
  std::printf("cradle, %s: balls swing out by %.4f %.4f %.4f %.4f %.4f rad\n", step.name(), swing[0], swing[1],
              swing[2], swing[3], swing[4]);
}
