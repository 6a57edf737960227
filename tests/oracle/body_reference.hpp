#pragma once
// How far the reference of bodies says it may be off, beside how far it is off.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "reference/bodies/motion.hpp"
#include "reference/bodies/solution.hpp"
#include "tests/check.hpp"

namespace odeval::test {

/// What every error of bodies is measured against: row 1 stands at t.
inline Reference reference_at(const Scenario& scenario, double t) {
  return reference::solve_body_reference(scenario, {t, 1, 2});
}

/// The largest part of a stated uncertainty that a true error took. Above 1 the statement is wrong. A bound on a sum of
/// roundings leaves room, since they seldom all go one way: how much, is measured, and more or less of it by a factor
/// of three says that error or statement have changed.
class Coverage {
 public:
  explicit Coverage(const char* what) : what_(what) {}

  void add(long double error, double stated) {
    const auto size = static_cast<double>(std::fabs(error));
    CHECK_BETWEEN(size, 0, stated);
    if (size > 0) largest_ = std::fmax(largest_, size / stated);
  }

  /// Against the part that was measured when the test was written.
  void check(double measured) const {
    std::printf("%s: errors take up to %.3g of the stated uncertainty\n", what_, largest_);
    CHECK_BETWEEN(largest_, measured / 3, std::fmin(3 * measured, 1));
  }

 private:
  const char* what_;
  double largest_ = 0;
};

/// The position of body i at t against a truth that knows more digits.
inline void add_position(Coverage& coverage, const Scenario& scenario, double t, std::size_t body,
                         const std::array<long double, 3>& wanted) {
  const Reference reference = reference_at(scenario, t);
  long double squares = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const long double off = reference.trace.bodies[body].position[k][1] - wanted[k];
    squares += off * off;
  }
  coverage.add(std::sqrt(squares), reference.uncertainty_position[1]);
}

}  // namespace odeval::test
