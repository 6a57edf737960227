#include "reference/tree/tree_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

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

/// Rows of a reference, from states.
class TreeRows {
 public:
  TreeRows(const TreeEquations& equations, const Mechanism& mechanism)
      : equations_(equations),
        mechanism_(mechanism),
        now_({.bodies = mechanism.bodies.size(), .joints = mechanism.joints.size()}, 1) {}

  void add(double t, const double* y, const Grips& grips) {
    equations_.show(y, now_[0].bodies);
    equations_.forces(t, y, grips, now_[0].joints);
    append_row(reference_, mechanism_, t, now_[0]);
  }

  Reference finished(const TreeUncertainty& uncertainty, std::vector<StopStrike> strikes, Tolerances tight,
                     Tolerances loose) {
    for (const double t : reference_.trace.t) append_uncertainty(reference_, uncertainty.at(t));
    reference_.strikes = std::move(strikes);
    if (equations_.forces_are_known()) tell_joint_forces(reference_, mechanism_);
    const std::size_t count = equations_.loops();
    const std::string loops = count > 0 ? fmt::format(" with {} loop{}", count, count == 1 ? "" : "s") : "";
    reference_.origin =
        fmt::format("equations of a tree{} by {}, {}", loops, equations_.version(), origin_of(tight, loose));
    return std::move(reference_);
  }

 private:
  const TreeEquations& equations_;
  const Mechanism& mechanism_;
  Motion now_;
  Reference reference_;
};

/// The two runs, and what they leave unknown.
class TreeRuns {
 public:
  TreeRuns(const Scenario& scenario, Tolerances tight_run, Tolerances loose_run)
      : off_(start_error(scenario)),
        mechanism_(scenario.mechanism),
        tolerances_{tight_run, loose_run},
        equations_(scenario),
        tight_(equations_, scenario, tight_run),
        loose_(equations_, scenario, loose_run),
        uncertainty_(equations_, mechanism_, tight_run, off_) {}

  TreeRows rows() const { return {equations_, mechanism_}; }
  TreeMotion& tight() { return tight_; }
  double end() const { return tight_.end(); }

  void advance() {
    tight_.advance();
    uncertainty_.follow(tight_, loose_);
    if (!tight_.change()) return;
    const std::vector<StopStrike> strikes = strikes_at(equations_, *tight_.change());
    strikes_.insert(strikes_.end(), strikes.begin(), strikes.end());
  }

  Reference finish(TreeRows& rows, double end_s) {
    uncertainty_.finish(tight_, loose_);
    std::vector<StopStrike> strikes = strikes_;
    std::erase_if(strikes, [&](const StopStrike& strike) { return strike.t > end_s; });
    return rows.finished(uncertainty_, std::move(strikes), tolerances_[0], tolerances_[1]);
  }

 private:
  double off_;
  Mechanism mechanism_;
  std::array<Tolerances, 2> tolerances_;
  TreeEquations equations_;
  TreeMotion tight_;
  TreeMotion loose_;
  TreeUncertainty uncertainty_;
  std::vector<StopStrike> strikes_;
};

/// All pieces of the tight run until the latest row that was asked for.
class TreeTrack {
 public:
  explicit TreeTrack(const Scenario& scenario)
      : runs_(scenario, tight_tolerances, loose_tolerances), pieces_{runs_.tight().piece()} {}

  Reference at(const SampleGrid& grid) {
    const double end = grid.time(grid.rows - 1);
    while (runs_.end() < end) {
      runs_.advance();
      pieces_.push_back(runs_.tight().piece());
    }
    TreeRows rows = runs_.rows();
    auto piece = pieces_.begin();
    for (long row = 0; row < grid.rows; ++row) {
      const double t = grid.time(row);
      while (piece->end_s < t) ++piece;
      rows.add(t, piece->at(t).data(), piece->grips);
    }
    return runs_.finish(rows, end);
  }

 private:
  TreeRuns runs_;
  std::vector<TreePiece> pieces_;
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
  TreeRuns runs(scenario, tight_run, loose_run);
  TreeRows rows = runs.rows();
  for (long row = 0; row < grid.rows; ++row) {
    const double t = grid.time(row);
    while (runs.end() < t) runs.advance();
    rows.add(t, runs.tight().at(t).data(), runs.tight().grips());
  }
  return runs.finish(rows, grid.time(grid.rows - 1));
}

std::function<Reference(const SampleGrid&)> follow_tree(const Scenario& scenario) {
  return [track = std::make_shared<TreeTrack>(scenario)](const SampleGrid& grid) { return track->at(grid); };
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
