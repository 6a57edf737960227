#pragma once
// The same value at several steps, taken to the step of 0.
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "odeval/audit.hpp"

namespace odeval::audit {

/// The quaternion of the two that mean the same attitude, that is nearer to `to`.
std::array<double, 4> nearer(const double* quaternion, const double* to);

/// Values of each run, with several components each, at a step of 0: the polynomial of that degree through the finest
/// runs.
std::vector<double> extrapolated(const std::vector<double>& values, const std::vector<int>& refinements,
                                 std::size_t degree);

/// How far values at different steps, and their extrapolations, are apart: the largest so far.
///
/// Values at h/k of k in `refinements` are taken to lie on a polynomial in h, whatever its leading power: T(i, 0) is
/// the value of run i, and T(i, j) the polynomial of degree j through the runs i-j to i, at 0 (Neville). The limit is
/// the T(last, j) with that j whose successive values T(i, j) are closest together; that closeness is its uncertainty.
/// One that is smooth in h settles on a high j, one that is not (impacts that fall anywhere in a step) on a low one.
class Spread {
 public:
  /// Besides the refined runs there may be others, whose distance from the limit is asked as well.
  explicit Spread(const std::vector<int>& refinements, std::size_t others = 0);

  std::size_t runs() const { return steps_.size(); }
  /// j of the limit.
  std::size_t best_degree() const;

  /// Of one quantity at one time, with a component for each of its coordinates. `values` holds them for each run in
  /// turn, the others last (NaN: one has ended); `metric` is what a unit of their distance means.
  void add(const double* values, std::size_t components, double metric);
  /// The larger of both.
  void add(const Spread& other);

  struct Limit {
    std::size_t degree;
    double uncertainty;
  };
  Limit limit() const;
  /// How far a run, or one of the others, is from it.
  double off(std::size_t run, const Limit& limit) const { return std::sqrt(off_[run * runs() + limit.degree]); }

  /// Of a run, or of one of the others, that and what it is worth. `unseen` is what no run sees of bends and jumps
  /// (the judge's to know), and more of what the limit may be off by, as `rounding` is.
  Estimate error(std::size_t run, double unseen = 0, double rounding = 0) const;
  Convergence convergence(const Estimate& error, double unseen) const;
  /// The two finest runs.
  double last_apart() const { return apart(runs() - 1, 0); }
  /// Of the last three runs; nothing where they do not differ.
  std::optional<double> order() const;

 private:
  double apart(std::size_t run, std::size_t degree) const { return std::sqrt(apart_[run * runs() + degree]); }
  /// By the distances of run `first` and run `last` from those before them.
  std::optional<double> order_of(std::size_t first, std::size_t last) const;
  double uncertainty(std::size_t degree) const;
  double uncertainty_of_values() const;

  std::vector<double> steps_;  // in units of h
  std::vector<double> apart_;  // the square, T(i, j) from T(i-1, j), [i][j]
  std::vector<double> off_;    // likewise, run i from T(last, j), [i][j]
  std::vector<double> table_;  // T, of one time
};

/// A run at a step, and what its error may be at most.
struct StepError {
  double step = 0;
  double most = 0;
};

/// The largest step that keeps an error, none larger than that of the first run. Between two of the runs, which get
/// finer, along the line of logarithms, past the finest by the order seen there; where they are not settled, a run's.
std::optional<double> step_that_keeps(double wanted, const std::vector<StepError>& runs, std::optional<double> order,
                                      bool settled);

}  // namespace odeval::audit
