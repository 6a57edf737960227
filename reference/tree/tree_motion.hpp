#pragma once
// A tree of bodies integrated by CVODE, step by step.
#include "reference/cvode_solver.hpp"
#include "reference/tree/tree_equations.hpp"

namespace odeval::reference {

class TreeMotion {
 public:
  using State = std::vector<double>;

  /// The equations must outlive it.
  TreeMotion(const TreeEquations& equations, const Scenario& scenario, Tolerances tolerances)
      : solver_(
            equations.size(), [&equations](const double* y, double* dydt) { equations(y, dydt); }, tolerances,
            scenario.name, scenario.duration_s),
        state_(equations.start()) {
    solver_.start(0, state_.data());
  }

  /// One of CVODE's own steps; `end` is how far they have come.
  void advance() { solver_.step(); }
  double end() const { return solver_.end(); }

  /// The state at a time of the last step; stays until the next call.
  const State& at(double t) {
    if (t > 0) solver_.interpolate(t, state_.data());
    return state_;
  }

  long steps() const { return solver_.steps(); }
  long evaluations() const { return solver_.evaluations(); }

 private:
  CvodeSolver solver_;
  State state_;
};

}  // namespace odeval::reference
