// Energy of ODE beside ode45 and Euler: claim C8a.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;

constexpr const char* compared[] = {"ode-step-double", "lagrange-ode45", "lagrange-euler"};

constexpr double window_s = 1;

/// How restless an energy is: root mean square of what is left of it when its mean over a second about each moment is
/// taken away.
double fluctuation(const Trace& trace) {
  const Column energy = total_energy(trace);
  const auto half = static_cast<std::size_t>(std::lround(window_s / 2 / trace.t.at(1)));
  double sum = 0;
  for (std::size_t i = 0; i < 2 * half + 1; ++i) sum += energy.at(i);
  double squares = 0;
  std::size_t number = 0;
  for (std::size_t i = half; i + half < energy.size(); ++i, ++number) {
    const double mean = sum / static_cast<double>(2 * half + 1);
    squares += (energy[i] - mean) * (energy[i] - mean);
    if (i + half + 1 < energy.size()) sum += energy[i + half + 1] - energy[i - half];
  }
  return std::sqrt(squares / static_cast<double>(number));
}

}  // namespace

Content energy(Laboratory& laboratory, Findings& findings) {
  catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  const double end = evaluator.scenario().duration_s;

  report::Figure figure{.name = "energy-drift"};
  report::Panel signed_drift{.x_label = "t, s", .y_label = "energy drift, J"};
  report::Panel size{.x_label = "t, s", .y_label = "size of the drift, J", .log_y = true};
  report::Table table{.name = "energy",
                      .columns = {"method", "largest until 3 s, J", fmt::format("largest until {} s, J", end),
                                  "fluctuation, J", "rms, J", "at the end, J", "largest angle error until 3 s, rad"}};
  double largest[3] = {};
  double restless[3] = {};
  std::vector<const Evaluation*> runs;
  for (std::size_t i = 0; i < std::size(compared); ++i) {
    const Evaluation& run = *laboratory.run("double_pendulum", compared[i]);
    runs.push_back(&run);
    const Column drift = energy_drift(run.trace);
    signed_drift.series.push_back(curve(compared[i], run.trace.t, drift, colour_of(compared[i])));
    size.series.push_back(curve(compared[i], run.trace.t, above_zero(sizes(drift)), colour_of(compared[i])));
    const Metrics whole = evaluator.measure(run, end);
    const Metrics early = evaluator.measure(run, 3);
    restless[i] = fluctuation(run.trace);
    largest[i] = *whole[quantity::max_energy_drift];
    table.rows.push_back({std::string(compared[i]), *early[quantity::max_energy_drift],
                          *whole[quantity::max_energy_drift], restless[i], *whole[quantity::rms_energy_drift],
                          *whole[quantity::final_energy_drift], error_until(evaluator, run, 3)});
  }
  const std::string about = fmt::format("fluctuation of energy about its mean over {} s, ODE's over ", window_s);
  findings.add("C8a.fluctuation_over_ode45", measured_ratio(about + "ode45's", restless[0], restless[1]));
  findings.add("C8a.fluctuation_over_euler", measured_ratio(about + "Euler's", restless[0], restless[2]));
  findings.add("C8a.ode_over_ode45", measured_ratio(fmt::format("largest energy drift of ODE over ode45's, {} s", end),
                                                    largest[0], largest[1]));
  findings.add("C8a.ode_over_euler", measured_ratio(fmt::format("largest energy drift of ODE over Euler's, {} s", end),
                                                    largest[0], largest[2]));
  signed_drift.shade = size.shade = all_lost(evaluator, runs);
  figure.panels = {std::move(signed_drift), std::move(size)};

  Content content;
  content.values = {{"known", reference_known(evaluator, {3})},
                    {"until", end},
                    {"window", window_s},
                    {"ode_restless", shown(restless[0])},
                    {"ode45_restless", shown(restless[1])},
                    {"euler_restless", shown(restless[2])},
                    {"ode", shown(largest[0])},
                    {"ode45", shown(largest[1])},
                    {"euler", shown(largest[2])}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
