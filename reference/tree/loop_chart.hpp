#pragma once
// As few numbers for a state as it has freedoms, where joints close loops.
#include <Eigen/Core>
#include <vector>

#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {

/// Directions at right angles, fixed where the chart was made, along which loops let coordinates and speeds go there.
/// The small state is how far coordinates and speeds go along them, and what stands after the speeds, as it is: a state
/// whose loops are closed is known by it as long as its own free directions lean not too far from the chart's.
///
/// Without loops the small state is the state.
class LoopChart {
 public:
  using State = std::vector<double>;

  /// Around a state. The tree must outlive it.
  LoopChart(SimbodyTree& tree, bool loops, const State& around);

  bool trivial() const { return !loops_; }
  /// Numbers in a small state.
  std::size_t size() const;

  /// Of a state.
  State small(const State& state) const;
  /// Likewise of its slope, or anything that adds to it.
  void small(const double* state, double* small) const;
  /// The state, loops closed and speeds as they let it. Looks for it near the last that was found, or where the chart
  /// was made. False: there is none near.
  [[nodiscard]] bool find(const double* small, State& state) const;
  /// Likewise near another state, of which `state` has the numbers.
  [[nodiscard]] bool find_near(const double* small, State& state) const;
  /// Whether a chart around a state would be much the better one there.
  bool is_left_by(const State& state) const;
  /// Where there are loops; stays until the next call.
  const Closure& closure(const State& state) const { return tree_.closure(state.data()); }

 private:
  Eigen::Index coordinates() const { return of_coordinates_.rows(); }
  Eigen::Index speeds() const { return of_speeds_.rows(); }
  Eigen::Index freedoms() const { return of_speeds_.cols(); }
  bool close(const Eigen::VectorXd& wanted, State& state) const;
  Eigen::MatrixXd along_coordinates(const State& state, const Eigen::MatrixXd& speeds) const;

  SimbodyTree& tree_;
  bool loops_;
  std::size_t numbers_;             // in a state
  Eigen::MatrixXd of_coordinates_;  // unit columns
  Eigen::MatrixXd of_speeds_;       // likewise
  mutable State last_;
};

}  // namespace odeval::reference
