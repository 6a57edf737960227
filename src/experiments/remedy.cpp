// The fourth-order step beside ODE's collision detection: claim C12.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "odeval/error.hpp"

namespace odeval::experiments {
namespace {

constexpr const char* now = "ode-step-double";
constexpr const char* cure = "ode-rk4-double";

/// How much more accurate the fourth-order step is, at the same step: at least, where the reference knows no better.
double add_row(Laboratory& laboratory, const std::string& scenario, double until, report::Table& table) {
  catalogue::Evaluator& evaluator = laboratory.evaluator(scenario);
  const catalogue::Evaluation& plain = *laboratory.run(scenario, now);
  const catalogue::Evaluation& better = *laboratory.run(scenario, cure);
  const double a = error_until(evaluator, plain, until);
  const double b = error_until(evaluator, better, until);
  const double known = uncertainty_until(evaluator, better, until);
  const double bound = b + known;
  table.rows.push_back({scenario, until, a, b, known, a / bound,
                        *evaluator.measure(plain, until)[quantity::max_energy_drift],
                        *evaluator.measure(better, until)[quantity::max_energy_drift]});
  return a / bound;
}

/// The same of bodies, by the largest distance from the reference, over the whole run.
double add_body_row(Laboratory& laboratory, const std::string& scenario, const char* acts, report::Table& table) {
  catalogue::Evaluator& evaluator = laboratory.evaluator(scenario);
  const double until = laboratory.scenario(scenario).duration_s;
  const Metrics plain = evaluator.measure(*laboratory.run(scenario, now), until);
  const Metrics better = evaluator.measure(*laboratory.run(scenario, cure), until);
  const double a = plain[quantity::max_error_position].value_or(NAN);
  const double b = better[quantity::max_error_position].value_or(NAN);
  const double known = better[quantity::position_uncertainty].value_or(NAN);
  table.rows.push_back({scenario, std::string(acts), until, a, b, known, a / (b + known)});
  return a / (b + known);
}

report::Table robots(Laboratory& laboratory, Findings& findings) {
  report::Table table{
      .name = "remedy-robots",
      .columns = {"scenario", "what acts", "until, s", "error of dWorldStep, m", "of the fourth-order step, m",
                  "the reference's uncertainty, m", "at least more accurate, times"}};
  const auto add = [&](const char* finding, const char* scenario, const char* acts) {
    const std::string meaning =
        fmt::format("at least this much more accurate than dWorldStep is ode-rk4-double, {}: {}", scenario, acts);
    try {
      findings.add(finding, measured(meaning, "", add_body_row(laboratory, scenario, acts, table)));
    } catch (const UserError& error) {  // the build lacks the reference of trees
      std::vector<report::Cell> row{std::string(scenario), std::string(acts)};
      row.resize(table.columns.size(), report::Missing{error.what()});
      table.rows.push_back(std::move(row));
      findings.add(finding, unavailable(meaning, "", error.what()));
    }
  };
  add("C12.friction_gain", "friction_slide", "friction, until it holds the box");
  add("C12.motor_gain", "motor_lift", "a motor, at its limit of force and at its speed");
  add("C12.stop_gain", "cart_pole", "a stop, dry friction, a damper, a force over time");
  return table;
}

}  // namespace

Content remedy(Laboratory& laboratory, Findings& findings) {
  report::Table table{.name = "remedy",
                      .columns = {"scenario", "until, s", "error of dWorldStep, rad", "of the fourth-order step, rad",
                                  "the reference's uncertainty, rad", "at least more accurate, times",
                                  "drift of dWorldStep, J", "of the fourth-order step, J"}};
  const double smooth = add_row(laboratory, "double_pendulum", 3, table);
  const double impact = add_row(laboratory, "wall_pendulum", 5, table);
  add_row(laboratory, "single_pendulum", 10, table);
  findings.add("C12.smooth_gain",
               measured("at least this much more accurate than dWorldStep is ode-rk4-double, double pendulum until 3 s",
                        "", smooth));
  findings.add("C12.impact_gain", measured("the same through the wall pendulum's impacts, until 5 s", "", impact));
  std::vector<report::Panel> panels;
  for (const char* scenario : {"double_pendulum", "wall_pendulum"}) {
    report::Panel panel{.title = scenario, .x_label = "t, s", .y_label = "error, rad", .log_y = true};
    for (const char* method : {now, cure}) {
      const Trace& trace = laboratory.run(scenario, method)->trace;
      panel.series.push_back(curve(method, trace.t, above_zero(largest_error(trace)), colour_of(method)));
    }
    const Reference& reference = laboratory.evaluator(scenario).reference();
    panel.series.push_back(uncertainty_curve(reference.trace.t, reference.uncertainty_q));
    panel.shade = lost_shade(laboratory.evaluator(scenario), *laboratory.run(scenario, now));
    if (panel.shade) panel.shade->why = std::string(now) + ": " + panel.shade->why;
    panels.push_back(std::move(panel));
  }
  Content content;
  content.exhibits.emplace_back(report::Figure{.name = "remedy-errors", .panels = std::move(panels), .columns = 2});
  content.exhibits.emplace_back(std::move(table));
  content.exhibits.emplace_back(robots(laboratory, findings));
  return content;
}

}  // namespace odeval::experiments
