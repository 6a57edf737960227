#pragma once
// What refined runs do not see of their own error.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace odeval::audit {

/// What rounding has come to: the motion makes it grow as it makes grow what starts were moved by.
struct Chaos {
  double moved_by_m = 0;
  double apart_m = 0;       // the largest so far
  double extent_m = 0;      // of coordinates
  std::uint64_t steps = 0;  // of the finest run

  double growth() const { return moved_by_m > 0 ? std::max(1.0, apart_m / moved_by_m) : 1; }
  /// Half a unit of the last place a step, all one way.
  double rounding_m() const { return 1.1e-16 * static_cast<double>(steps) * std::max(1.0, extent_m) * growth(); }
};

/// What no refinement sees: where a velocity bends or jumps (an impact, a motor that reaches its speed) within the
/// first part of a step, all runs have it between the same two grid points, and agree on a limit that is off by up to
/// what the bend comes to in the finest part of a step. Bends fall anywhere, so their squares add.
class Bends {
 public:
  void add(const double* velocity, double h) {
    constexpr long first = 2;  // what begins with the run begins on everybody's grid
    double square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double change = velocity[i] - before_[i];
      if (steps_ > first) square += (change - change_[i]) * (change - change_[i]);
      change_[i] = change;
      before_[i] = velocity[i];
    }
    ++steps_;
    sum_ += square * h * h;
  }
  double unseen(int refinement) const { return std::sqrt(sum_) / refinement; }

 private:
  std::array<double, 3> before_{};
  std::array<double, 3> change_{};
  long steps_ = 0;
  double sum_ = 0;
};

}  // namespace odeval::audit
