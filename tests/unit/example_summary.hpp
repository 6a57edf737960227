#pragma once
// A run's summary for tests, filled by hand.
#include <limits>

#include "output/summary.hpp"

namespace odeval::test {

inline RunSummary example() {
  RunSummary run;
  run.scenario.name = "wall_pendulum";
  run.scenario.file = "/some/where/wall_pendulum.toml";
  run.scenario.duration_s = 2.5;
  run.scenario.mechanism.contacts = {{.restitution = 0.75}};
  run.scenario.impact_views.resize(1);
  run.grid = {1e-3, 1, 2501};
  run.method = "ode-step-double";
  run.uses_ode = true;
  run.outcome.steps = 2500;
  run.outcome.impacts = {{0.5, -1.62, -5.0, 4.0, 1e-3}, {1.5, -1.62, 0.0, 4.0, 0}};
  run.metrics[quantity::max_error_q] = 0.25;
  run.metrics[quantity::rms_error_q] = std::numeric_limits<double>::infinity();
  run.metrics[quantity::reference_uncertainty] = 6e-12;
  run.metrics[quantity::max_energy_drift] = 1e-4;
  run.error_at.resize(2);
  run.error_at[0].until_s = 1;
  run.error_at[0][quantity::max_error_q] = 0.0089;
  run.error_at[0][quantity::reference_uncertainty] = 6e-12;
  run.error_at[1].until_s = 2;
  run.versions = {{"odeval", "1"}, {"ode", "0.16.2"}};
  return run;
}

}  // namespace odeval::test
