#include "reference/tree/loop_chart.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace odeval::reference {
namespace {

/// The error that is left after a step of Newton's method is about the square of what the step was.
constexpr double squared_is_nothing = 1e-9;
constexpr int most_steps = 12;

/// Beyond, loops hold what they can not: constraints that were implied by others are so no more.
constexpr double closed = 1e-10;

/// Cosine of the angle by which free directions lean away from a chart that is left.
constexpr double too_far = 0.6;

Eigen::Map<const Eigen::VectorXd> part(const double* numbers, Eigen::Index from, Eigen::Index count) {
  return {numbers + from, count};
}

/// Columns at right angles that span the same.
Eigen::MatrixXd upright(const Eigen::MatrixXd& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> factors(columns);
  return factors.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

}  // namespace

LoopChart::LoopChart(SimbodyTree& tree, bool loops, const State& around)
    : tree_(tree), loops_(loops), numbers_(around.size()), last_(around) {
  if (!loops) return;
  of_speeds_ = tree.closure(around.data()).free;
  of_coordinates_.resize(static_cast<Eigen::Index>(tree.first_speed()), of_speeds_.cols());
  if (freedoms() > 0) of_coordinates_ = upright(along_coordinates(around, of_speeds_));
}

std::size_t LoopChart::size() const {
  if (trivial()) return numbers_;
  return numbers_ - static_cast<std::size_t>(coordinates() + speeds() - 2 * freedoms());
}

/// What speeds do to coordinates, column by column.
Eigen::MatrixXd LoopChart::along_coordinates(const State& state, const Eigen::MatrixXd& speeds) const {
  Eigen::MatrixXd rates(static_cast<Eigen::Index>(tree_.first_speed()), speeds.cols());
  for (Eigen::Index j = 0; j < speeds.cols(); ++j) rates.col(j) = tree_.rates(state.data(), speeds.col(j));
  return rates;
}

LoopChart::State LoopChart::small(const State& state) const {
  State small(size());
  this->small(state.data(), small.data());
  return small;
}

void LoopChart::small(const double* state, double* small) const {
  if (trivial()) {
    std::copy_n(state, numbers_, small);
    return;
  }
  const Eigen::Index count = freedoms();
  Eigen::Map<Eigen::VectorXd>(small, count) = of_coordinates_.transpose() * part(state, 0, coordinates());
  Eigen::Map<Eigen::VectorXd>(small + count, count) = of_speeds_.transpose() * part(state, coordinates(), speeds());
  std::copy(state + coordinates() + speeds(), state + numbers_, small + 2 * count);
}

bool LoopChart::find(const double* small, State& state) const {
  if (trivial()) {
    state.assign(small, small + numbers_);
    return true;
  }
  state = last_;
  if (!close(part(small, 0, freedoms()), state)) return false;
  const Closure& closure = tree_.closure(state.data());
  if (!(closure.error < closed)) return false;
  const Eigen::MatrixXd seen = of_speeds_.transpose() * closure.free;
  Eigen::Map<Eigen::VectorXd>(state.data() + coordinates(), speeds()) =
      closure.free * seen.partialPivLu().solve(part(small, freedoms(), freedoms()));
  std::copy(small + 2 * freedoms(), small + size(), state.begin() + coordinates() + speeds());
  last_ = state;
  return true;
}

bool LoopChart::find_near(const double* small, State& state) const {
  last_ = state;
  return find(small, state);
}

/// Newton's method for coordinates that close the loops and go as far along the chart's directions as wanted.
bool LoopChart::close(const Eigen::VectorXd& wanted, State& state) const {
  Eigen::Map<Eigen::VectorXd> found(state.data(), coordinates());
  for (int step = 0; step < most_steps; ++step) {
    const Closure& closure = tree_.closure(state.data());
    const Eigen::VectorXd mend = along_coordinates(state, closure.mend);
    const Eigen::MatrixXd free = along_coordinates(state, closure.free);
    const Eigen::VectorXd missing = wanted - of_coordinates_.transpose() * (found + mend);
    const Eigen::VectorXd change = mend + free * (of_coordinates_.transpose() * free).partialPivLu().solve(missing);
    if (!change.allFinite()) return false;
    found += change;
    tree_.normalize(state.data());  // else what is found hangs on the way there, by the square of each step
    if (change.cwiseAbs().maxCoeff() < squared_is_nothing) return true;
  }
  return false;
}

bool LoopChart::is_left_by(const State& state) const {
  if (trivial() || freedoms() == 0) return false;
  const Closure& closure = tree_.closure(state.data());
  const auto leans = [](const Eigen::MatrixXd& seen) {
    return Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(seen).matrixR().diagonal().cwiseAbs().minCoeff() < too_far;
  };
  return leans(of_speeds_.transpose() * closure.free) ||
         leans(of_coordinates_.transpose() * upright(along_coordinates(state, closure.free)));
}

}  // namespace odeval::reference
