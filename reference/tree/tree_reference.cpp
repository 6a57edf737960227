#include "reference/tree/tree_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "odeval/error.hpp"
#include "reference/closed_form/body_solution.hpp"
#include "reference/planar/cvode.hpp"
#include "reference/planar/reference_solution.hpp"
#include "reference/tree/simbody_tree.hpp"
#include "reference/tree/spanning_tree.hpp"
#include "reference/tree/tree_ledger.hpp"
#include "reference/tree/tree_motion.hpp"
#include "reference/tree/tree_uncertainty.hpp"

namespace odeval::reference {
namespace {

/// By how much joints correct the velocities at t = 0.
double start_error(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  double most = 0;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Misfit misfit = misfit_of(mechanism, mechanism.joints[j]);
    most = std::max({most, misfit.speed_m_s, misfit.spin_rad_s});
    if (most <= allowed_misfit(mechanism)) continue;
    throw UserError(
        fmt::format("{}: joint {} does not allow the velocities of its bodies at t = 0: they part by {:.3g} "
                    "m/s and {:.3g} rad/s",
                    scenario.name, j + 1, misfit.speed_m_s, misfit.spin_rad_s));
  }
  return most;
}

class TreeSimulation final : public Simulation {
 public:
  TreeSimulation(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid),
        shape_{.bodies = scenario.mechanism.bodies.size(),
               .joints = scenario.mechanism.joints.size(),
               .works = scenario.named ? work_names.size() : 0},
        mechanism_(scenario.mechanism),
        equations_(scenario),
        motion_(equations_, scenario,
                {scenario.rtol.value_or(tight_tolerances.rtol), scenario.atol.value_or(tight_tolerances.atol), true}) {
    start_error(scenario);
  }

  SampleShape shape() const override { return shape_; }

  Outcome run(Recorder recorder) override {
    std::optional<TreeLedger> ledger;
    if (recorder && shape_.works > 0) ledger.emplace(equations_, mechanism_);
    for (long row = 0; row < grid_.rows; ++row) {
      const double t = grid_.time(row);
      advance_to(t, ledger);
      if (!recorder) continue;
      const double* const y = motion_.at(t).data();
      const Sample sample = recorder.next();
      equations_.show(y, sample.bodies);
      equations_.forces(t, y, motion_.grips(), sample.joints);
      if (ledger) ledger->record(t, y, motion_.grips(), sample);
    }
    Outcome outcome;
    if (ledger) {
      outcome.strikes = ledger->strikes();
      outcome.motors = ledger->motors(grid_.time(grid_.rows - 1));
    }
    outcome.steps = motion_.steps();
    outcome.evaluations = motion_.evaluations();
    return outcome;
  }

 private:
  void advance_to(double t, std::optional<TreeLedger>& ledger) {
    while (motion_.end() < t) {
      if (ledger) {
        ledger->follow(motion_, motion_.end());
        if (motion_.change()) ledger->pass(*motion_.change());
      }
      motion_.advance();
    }
    if (ledger) ledger->follow(motion_, t);
  }

  SampleGrid grid_;
  SampleShape shape_;
  Mechanism mechanism_;
  TreeEquations equations_;
  TreeMotion motion_;
};

}  // namespace

bool is_tree(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  return !scenario.planar && (features_of(scenario) - known_of_trees).empty() && !mechanism.bodies.empty() &&
         contact_points(mechanism).has_value();
}

Reference solve_tree(const Scenario& scenario, const SampleGrid& grid) {
  return solve_tree(scenario, grid, tight_tolerances, loose_tolerances);
}

Reference solve_tree(const Scenario& scenario, const SampleGrid& grid, Tolerances tight_run, Tolerances loose_run) {
  const Mechanism& mechanism = scenario.mechanism;
  const double off = start_error(scenario);
  const TreeEquations equations(scenario);
  TreeMotion tight(equations, scenario, tight_run);
  TreeMotion loose(equations, scenario, loose_run);
  TreeUncertainty uncertainty(equations, mechanism, tight_run, off);
  Motion now({.bodies = mechanism.bodies.size(), .joints = mechanism.joints.size()}, 1);
  Reference reference;
  const double end = grid.time(grid.rows - 1);
  for (long row = 0; row < grid.rows; ++row) {
    const double t = grid.time(row);
    while (tight.end() < t) {
      tight.advance();
      uncertainty.follow(tight, loose);
      if (!tight.change() || tight.change()->t > end) continue;
      const std::vector<StopStrike> strikes = strikes_at(equations, *tight.change());
      reference.strikes.insert(reference.strikes.end(), strikes.begin(), strikes.end());
    }
    const double* const y = tight.at(t).data();
    equations.show(y, now[0].bodies);
    equations.forces(t, y, tight.grips(), now[0].joints);
    append_row(reference, mechanism, t, now[0]);
  }
  uncertainty.finish(tight, loose);
  for (const double t : reference.trace.t) append_uncertainty(reference, uncertainty.at(t));
  if (equations.forces_are_known()) tell_joint_forces(reference, mechanism);
  const std::string loops =
      equations.loops() > 0 ? fmt::format(" with {} loop{}", equations.loops(), equations.loops() == 1 ? "" : "s") : "";
  reference.origin =
      fmt::format("equations of a tree{} by {}, {}", loops, equations.version(), origin_of(tight_run, loose_run));
  return reference;
}

std::unique_ptr<Simulation> make_mechanism_cvode(const Scenario& scenario, const SampleGrid& grid) {
  return std::make_unique<TreeSimulation>(scenario, grid);
}

// As catalogue/evaluation.cpp has it for chains in a plane: what the joints' own turning adds is left out, since a step
// that takes old velocities through the joints of a new pose does that itself.
Scenario tree_half_a_step_earlier(const Scenario& scenario) {
  const TreeEquations equations(scenario);
  const std::vector<Placed>& then = equations.pushed(-scenario.step_s / 2);
  Scenario earlier = scenario;
  for (std::size_t i = 0; i < then.size(); ++i) {
    earlier.mechanism.bodies[i].velocity_m_s = then[i].velocity_m_s;
    earlier.mechanism.bodies[i].spin_rad_s = then[i].spin_rad_s;
  }
  return earlier;
}

}  // namespace odeval::reference
