// Energy of ODE beside ode45 and Euler: claim C8a.
#include <fmt/format.h>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;

constexpr const char* compared[] = {"ode-step-double", "lagrange-ode45", "lagrange-euler"};

}  // namespace

Section energy(Laboratory& laboratory, Findings& findings) {
  catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  const double end = evaluator.scenario().duration_s;

  report::Figure figure{"energy-drift", "Energy minus the energy at the start", {}, {}, 1};
  report::Panel signed_drift{.x_label = "t, s", .y_label = "energy drift, J"};
  report::Panel size{.x_label = "t, s", .y_label = "size of the drift, J", .log_y = true};
  report::Table table{"energy",
                      "Energy drift of the double pendulum",
                      {"method", "largest until 3 s, J", fmt::format("largest until {} s, J", end), "rms, J",
                       "at the end, J", "largest angle error until 3 s, rad"},
                      {},
                      "Drift is the energy minus the energy at t = 0, of a motion that loses and gains none." +
                          reference_known(evaluator, {3})};
  double largest[3] = {};
  std::vector<const Evaluation*> runs;
  for (std::size_t i = 0; i < std::size(compared); ++i) {
    const Evaluation& run = *laboratory.run("double_pendulum", compared[i]);
    runs.push_back(&run);
    const Column drift = energy_drift(run.trace);
    signed_drift.series.push_back(curve(compared[i], run.trace.t, drift, colour_of(compared[i])));
    size.series.push_back(curve(compared[i], run.trace.t, above_zero(sizes(drift)), colour_of(compared[i])));
    const Metrics whole = evaluator.measure(run, end);
    const Metrics early = evaluator.measure(run, 3);
    largest[i] = whole.max_energy_drift;
    table.rows.push_back({std::string(compared[i]), early.max_energy_drift, whole.max_energy_drift,
                          whole.rms_energy_drift, whole.final_energy_drift, error_until(evaluator, run, 3)});
  }
  findings.add("C8a.ode_over_ode45", measured_ratio(fmt::format("largest energy drift of ODE over ode45's, {} s", end),
                                                    largest[0], largest[1]));
  findings.add("C8a.ode_over_euler", measured_ratio(fmt::format("largest energy drift of ODE over Euler's, {} s", end),
                                                    largest[0], largest[2]));
  signed_drift.shade = size.shade = all_lost(evaluator, runs);
  figure.panels = {std::move(signed_drift), std::move(size)};
  figure.caption =
      "Read how far a curve gets from zero and whether it comes back, not how restless it looks. The second plot shows "
      "the same on a logarithmic axis.";

  Section section{"energy", "Energy: ODE, ode45 and Euler", {}};
  section.blocks.emplace_back(
      report::Text{fmt::format("The report saw ODE's energy fluctuate much more than ode45's and Euler's. Measured "
                               "over {} s from the same start, "
                               "ODE's energy is off by at most {} J, that of ode45 by {} J and that of Euler by {} J.",
                               end, shown(largest[0]), shown(largest[1]), shown(largest[2]))});
  section.blocks.emplace_back(std::move(figure));
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
