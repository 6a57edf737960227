#pragma once
// A chain of any number of links moved by CVODE, step after step, as CvodeMotion does it with one or two.
#include <algorithm>
#include <vector>

#include "odeval/engine.hpp"
#include "odeval/scenario.hpp"
#include "reference/cvode_solver.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/long_chain.hpp"

namespace odeval::reference {

class LongChainMotion {
 public:
  using State = LongChain<double>::State;

  LongChainMotion(const Scenario& scenario, Tolerances tolerances)
      : equations_(scenario),
        state_(start_state<State>(*scenario.planar)),
        slope_(state_.size()),
        solver_(
            state_.size(), [this](double, const double* y, double* dydt) { evaluate(y, dydt); }, tolerances,
            scenario.name, scenario.duration_s),
        start_(state_) {
    solver_.start(0, start_.data());
  }
  LongChainMotion(const LongChainMotion&) = delete;
  LongChainMotion& operator=(const LongChainMotion&) = delete;

  void advance() { solver_.step(); }
  double end() const { return solver_.end(); }

  /// The state at a time of the last step.
  State at(double t) const {
    if (t <= 0) return start_;
    State y(start_.size());
    solver_.interpolate(t, y.data());
    return y;
  }

  const LongChain<double>& equations() const { return equations_; }
  long steps() const { return solver_.steps(); }
  long evaluations() const { return solver_.evaluations(); }
  /// Nothing touches anything.
  const std::vector<Impact>& impacts() const { return impacts_; }
  double at_rest_from() const { return -1; }

 private:
  void evaluate(const double* y, double* dydt) {
    std::copy_n(y, state_.size(), state_.begin());
    equations_(state_, slope_);
    std::ranges::copy(slope_, dydt);
  }

  LongChain<double> equations_;
  State state_, slope_;  // what CVODE asks about
  CvodeSolver solver_;
  State start_;
  std::vector<Impact> impacts_;
};

}  // namespace odeval::reference
