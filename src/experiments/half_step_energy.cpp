// How much of ODE's energy drift is only where the velocities are looked at: claim O3.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/centred_energy.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Panel;

constexpr double until_s = 3;
constexpr const char* method = "ode-step-double";

double largest_until(const Column& t, const Column& drift, double time_s) {
  const Span rows = rows_between(t, 0, time_s);
  const Column part_of = part(drift, {0, std::min(rows.end, drift.size())});
  return std::ranges::max(sizes(part_of));
}

}  // namespace

Content half_step_energy(Laboratory& laboratory, Findings& findings) {
  report::Figure figure{.name = "half-step-energy-figure"};
  report::Table table{.name = "half-step-energy",
                      .columns = {"scenario", "until, s", "from stored velocities, J", "from centred velocities, J",
                                  "ratio", "angle error, rad", "uncertainty of the reference, rad"}};
  for (const char* name : {"double_pendulum", "single_pendulum", "chain"}) {
    Evaluator& evaluator = laboratory.evaluator(name);
    const Evaluation& run = *laboratory.run(name, method);
    const Column stored = energy_drift(run.trace);
    const Column centred = centred_energy_drift(evaluator.scenario(), run.trace);
    std::set<double> times{1.0, until_s, evaluator.scenario().duration_s};
    times.erase(times.upper_bound(evaluator.scenario().duration_s), times.end());
    for (const double time_s : times) {
      const double usual = largest_until(run.trace.t, stored, time_s);
      const double half = largest_until(run.trace.t, centred, time_s);
      table.rows.push_back({std::string(name), time_s, usual, half, usual / half, error_until(evaluator, run, time_s),
                            uncertainty_until(evaluator, run, time_s)});
      if (time_s == until_s && name == std::string_view("double_pendulum")) {
        findings.add("O3.drift_ratio",
                     measured_ratio(fmt::format("largest energy drift until {} s from stored over that from centred "
                                                "velocities, double pendulum, h = {} s",
                                                until_s, evaluator.grid().step_s),
                                    usual, half));
      }
    }
    const Span rows = rows_between(run.trace.t, 0, until_s);
    const Span shown_rows{0, std::min(rows.end, centred.size())};
    const Column t = part(run.trace.t, shown_rows);
    Panel panel{.title = name, .x_label = "t, s", .y_label = "energy drift, J"};
    panel.series.push_back(curve("stored velocities", t, part(stored, shown_rows)));
    panel.series.push_back(curve("centred velocities", t, part(centred, shown_rows)));
    panel.shade = lost_shade(evaluator, run);
    figure.panels.push_back(std::move(panel));
  }

  Content content;
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
