#pragma once
// Gragg's midpoint rule with polynomial extrapolation: a one-step method of any even order, for any scalar.
//
// The midpoint rule over one step H with n = 2, 4, .., 2k substeps has an error in even powers of H / n; the polynomial
// through the k results, taken at 0 (Aitken-Neville), leaves an error of order H^(2k+1) a step
// (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.9).
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace odeval::reference {

template <class Real, std::size_t Size>
class Extrapolation {
 public:
  using State = std::array<Real, Size>;

  /// `order` is even, >= 2.
  explicit Extrapolation(int order) : columns_(static_cast<std::size_t>(order) / 2), table_(columns_) {}

  /// Moves y on by `step`. `right_side(y, dydt)` as in ChainEquations.
  template <class RightSide>
  void advance(const RightSide& right_side, State& y, const Real& step) {
    State slope_begin;
    right_side(y, slope_begin);
    for (std::size_t j = 0; j < columns_; ++j) {
      State fine = midpoint(right_side, y, slope_begin, step, 2 * (j + 1));
      // table_[m]: extrapolated from the m + 1 results before; becomes the one with this result added.
      for (std::size_t m = 0; m < j; ++m) {
        const Real ratio = Real(j + 1) / Real(j - m);
        const Real weight = 1 / (ratio * ratio - 1);
        State next;
        for (std::size_t i = 0; i < Size; ++i) next[i] = fine[i] + (fine[i] - table_[m][i]) * weight;
        table_[m] = std::exchange(fine, next);
      }
      table_[j] = fine;
    }
    y = table_[columns_ - 1];
  }

  /// Evaluations of the right side in one step.
  long evaluations() const { return static_cast<long>(columns_ * columns_ + 1); }

 private:
  template <class RightSide>
  static State midpoint(const RightSide& right_side, const State& y, const State& slope_begin, const Real& step,
                        std::size_t substeps) {
    const Real h = step / Real(substeps);
    State before = y;
    State now;
    State slope;
    for (std::size_t i = 0; i < Size; ++i) now[i] = y[i] + h * slope_begin[i];
    for (std::size_t k = 1; k < substeps; ++k) {
      right_side(now, slope);
      for (std::size_t i = 0; i < Size; ++i) before[i] += 2 * h * slope[i];
      std::swap(before, now);
    }
    return now;
  }

  std::size_t columns_;
  std::vector<State> table_;
};

}  // namespace odeval::reference
