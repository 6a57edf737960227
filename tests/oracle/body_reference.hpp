#pragma once
// How far the reference of bodies says it may be off, beside how far it is off.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "reference/closed_form/body_motion.hpp"
#include "reference/closed_form/body_solution.hpp"
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

/// Of a rotation vector, by rows, as Rodrigues' formula reads.
inline std::array<long double, 9> long_rotation(const std::array<long double, 3>& turn) {
  const auto [x, y, z] = turn;
  const long double angle = std::sqrt(x * x + y * y + z * z);
  const long double c = std::cos(angle);
  const long double s = angle == 0 ? 1 : std::sin(angle) / angle;
  const long double r = angle == 0 ? 0.5L : 2 * std::pow(std::sin(angle / 2) / angle, 2);
  return {c + r * x * x,     r * x * y - s * z, r * x * z + s * y, r * x * y + s * z, c + r * y * y,
          r * y * z - s * x, r * x * z - s * y, r * y * z + s * x, c + r * z * z};
}

/// The attitude of body i at t against that of a body that keeps its spin.
inline void add_turn(Coverage& coverage, const Scenario& scenario, double t, std::size_t body) {
  const Reference reference = reference_at(scenario, t);
  const Body& start_of = scenario.mechanism.bodies[body];
  const Vec3 turn = rotation_vector(start_of.attitude);
  const Vec3& spin = start_of.spin_rad_s;
  const long double time = t;
  const auto start = long_rotation({turn[0], turn[1], turn[2]});
  const auto since = long_rotation({spin[0] * time, spin[1] * time, spin[2] * time});
  long double off = 0;
  for (std::size_t k = 0; k < 9; ++k) {
    long double wanted = 0;
    for (std::size_t j = 0; j < 3; ++j) wanted += since[k / 3 * 3 + j] * start[3 * j + k % 3];
    off = std::fmax(off, std::fabs(reference.trace.bodies[body].rotation[k][1] - wanted));
  }
  coverage.add(off, reference.uncertainty_turn[1]);
}

}  // namespace odeval::test
