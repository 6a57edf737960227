// A link against a wall, in all methods: traces and every impact.
#include <fmt/format.h>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Missing;
using report::Panel;

constexpr const char* scenario_name = "wall_pendulum";

/// From the first method that is lost on, named.
std::optional<report::Shade> first_lost(Evaluator& evaluator, const std::vector<const Evaluation*>& runs) {
  std::optional<report::Shade> first;
  for (const Evaluation* run : runs) {
    std::optional<report::Shade> shade = lost_shade(evaluator, *run);
    if (!shade || (first && first->from <= shade->from)) continue;
    shade->why = std::string(run->method->name) + ": " + shade->why;
    first = std::move(shade);
  }
  return first;
}

report::Figure traces(Evaluator& evaluator, const std::vector<const Evaluation*>& runs) {
  const auto shade = first_lost(evaluator, runs);
  Panel angle{.x_label = "t, s", .y_label = "q, rad", .shade = shade};
  Panel rate{.x_label = "t, s", .y_label = "rate of q, rad/s", .shade = shade};
  Panel energy{.x_label = "t, s", .y_label = "energy drift, J", .shade = shade};
  Panel error{.x_label = "t, s", .y_label = "angle error, rad", .log_y = true, .shade = shade};
  for (const Evaluation* run : runs) {
    const std::string name(run->method->name);
    const Trace& trace = run->trace;
    const int colour = colour_beside_ode(name);
    if (name == "ode-step-double" || name == catalogue::reference_method) {  // angles of the others look the same
      angle.series.push_back(curve(name, trace.t, trace.q.front(), colour_of(name)));
      rate.series.push_back(curve(name, trace.t, trace.qd.front(), colour_of(name)));
    }
    energy.series.push_back(curve(name, trace.t, energy_drift(trace), colour));
    if (name != catalogue::reference_method) {
      error.series.push_back(curve(name, trace.t, above_zero(largest_error(trace)), colour));
    }
  }
  const Reference& reference = evaluator.reference();
  error.series.push_back(uncertainty_curve(reference.trace.t, reference.uncertainty_q));
  report::Figure figure{.name = "wall-pendulum-figure", .columns = 2};
  figure.panels = {told_apart(std::move(angle)), told_apart(std::move(rate)), told_apart(std::move(energy)),
                   told_apart(std::move(error))};
  return figure;
}

report::Table impacts(Evaluator& evaluator, const std::vector<const Evaluation*>& runs) {
  const Reference& reference = evaluator.reference();
  report::Table table{
      .name = "wall-pendulum-impacts",
      .columns = {"method", "impact", "t, s", "later than the reference, s", "the reference knows its own to, s",
                  "q, rad", "rate before, rad/s", "rate after, rad/s", "deepest overlap, m"}};
  for (const Evaluation* run : runs) {
    for (std::size_t i = 0; i < run->outcome.impacts.size(); ++i) {
      const Impact& impact = run->outcome.impacts[i];
      Cell late = Missing{"the reference has no such impact"};
      Cell known = late;
      if (i < reference.impacts.size()) {
        late = impact.t - reference.impacts[i].t;
        known = reference.impact_uncertainty_s[i];
      }
      table.rows.push_back({std::string(run->method->name), static_cast<double>(i + 1), fmt::format("{:.6f}", impact.t),
                            late, known, impact.q1, impact.qd_before, impact.qd_after, impact.depth});
    }
  }
  return table;
}

}  // namespace

Content wall_pendulum(Laboratory& laboratory, Findings&) {
  Evaluator& evaluator = laboratory.evaluator(scenario_name);
  const Scenario& scenario = evaluator.scenario();
  std::vector<const Evaluation*> runs;
  for (const std::string& name : scenario.methods) {
    if (const Evaluation* const run = laboratory.run(scenario_name, name)) runs.push_back(run);
  }
  Content content;
  content.values = {{"length", scenario.planar->links.front().length_m},
                    {"hinge", scenario.planar->frame.hinge_m[0]},
                    {"face", scenario.planar->wall->face_m},
                    {"restitution", scenario.planar->wall->restitution},
                    {"left_out", left_out(scenario.methods)}};
  content.exhibits.emplace_back(traces(evaluator, runs));
  content.exhibits.emplace_back(impacts(evaluator, runs));
  return content;
}

}  // namespace odeval::experiments
