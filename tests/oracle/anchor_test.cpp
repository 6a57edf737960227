// Positions that a stepper written from ODE's mathematics alone and ODE 0.16.2 itself agree on to 1e-12: the double
// pendulum of the report after 1 and after 1000 steps. They pin the world this project builds (masses, inertias,
// anchors, start, gravity, ERP, CFM), independent of the reference.
#include <cmath>

#include "tests/check.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

struct Pose {
  double y1, z1, y2, z2, spin1, spin2;
};

Pose pose_after(long steps) {
  const Scenario scenario = test::report_scenario("double_pendulum", 1.0, 1e-3);
  const SampleGrid grid{1e-3, 1, 1001};
  const Motion motion = test::recorded(catalogue::find_method("ode-step-double").make, scenario, grid).motion;
  const auto links = motion[static_cast<std::size_t>(steps)].bodies;
  const auto [x1, y1, z1] = links[0].position;
  const auto [x2, y2, z2] = links[1].position;
  return {y1, z1, y2, z2, links[0].spin[0], links[1].spin[0]};
}

void check(const Pose& pose, const Pose& wanted, double tolerance) {
  CHECK_NEAR(pose.y1, wanted.y1, tolerance);
  CHECK_NEAR(pose.z1, wanted.z1, tolerance);
  CHECK_NEAR(pose.y2, wanted.y2, tolerance);
  CHECK_NEAR(pose.z2, wanted.z2, tolerance);
  CHECK_NEAR(pose.spin1, wanted.spin1, tolerance);
  CHECK_NEAR(pose.spin2, wanted.spin2, tolerance);
}

}  // namespace

int main() {
  // One step: rounding of a few operations on numbers near 1.
  check(pose_after(1),
        {0.353555267496459, 2.45355136465561, 1.20711055376195, 2.80709844109302, -0.00546847526325371,
         -0.00873211766441993},
        1e-13);
  // 1000 steps: the values were measured with hinge 2 attached as (2, 1), the report attaches (1, 2), which changes
  // rounding; 5e-13 was the largest difference ever seen between the two. Twenty times that.
  check(
      pose_after(1000),
      {-0.308372401120502, 1.70637889577541, -1.11351129733278, 1.25587361856731, -4.87650954382064, -3.02760287632269},
      1e-11);
  return test::verdict();
}
