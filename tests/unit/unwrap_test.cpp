// Angles without a cut: the right branch, far branches, what is not finite.
#include "measure/unwrap.hpp"

#include <cmath>
#include <limits>

#include "tests/check.hpp"

namespace {

constexpr double pi = 3.14159265358979323846;

// The rounding of a few multiples of 2 pi.
constexpr double rounding = 1e-12;

void nearest_branch() {
  CHECK_EQUAL(odeval::unwrap(0.5, 0.4), 0.5);
  CHECK_NEAR(odeval::unwrap(-3.1, 3.1), -3.1 + 2 * pi, rounding);
  CHECK_NEAR(odeval::unwrap(3.1, -3.1), 3.1 - 2 * pi, rounding);
  CHECK_NEAR(odeval::unwrap(0.25, 1000.0), 0.25 + 159 * 2 * pi, rounding);
}

void a_turning_angle_grows_without_a_cut() {
  double before = 0;
  for (int k = 1; k <= 1000; ++k) {
    const double angle = -0.1 * k;
    before = odeval::unwrap(std::atan2(std::sin(angle), std::cos(angle)), before);
    CHECK_NEAR(before, angle, rounding);
  }
}

void what_is_not_finite_stays_so() {
  CHECK(!std::isfinite(odeval::unwrap(std::nan(""), 0)));
  CHECK(!std::isfinite(odeval::unwrap(0, std::nan(""))));
  CHECK(!std::isfinite(odeval::unwrap(0, std::numeric_limits<double>::infinity())));
}

}  // namespace

int main() {
  nearest_branch();
  a_turning_angle_grows_without_a_cut();
  what_is_not_finite_stays_so();
  return odeval::test::verdict();
}
