// Cartesian coordinates with feedback beside generalized ones, and why they win: claim C3.
#include <fmt/format.h>

#include <cmath>

#include "catalogue/accuracy.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/order.hpp"
#include "measure/spread.hpp"
#include "reference/planar/projected_step.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using catalogue::Method;
using report::Cell;
using report::Missing;
using report::Panel;

constexpr double until_s = 3;
constexpr double order_until_s = 1;
constexpr const char* compared[] = {"ode-step-double", "maximal-ode-step", "lagrange-symplectic-euler",
                                    "lagrange-euler", "maximal-euler"};
constexpr double erps[] = {0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1};
constexpr double steps_s[] = {2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4};
constexpr double laddered_erps[] = {0, 0.2, 1};

/// ODE's scheme where no joint can open: there is nothing to feed back.
Method projected_step() {
  Method method = *available("lagrange-symplectic-euler");
  method.name = "ODE's scheme, generalized";
  method.make = reference::make_projected_step;
  method.settings = catalogue::rebuilt_step_settings();  // it steps as ODE does, so that the half-step start is for it
  return method;
}

OdeSettings with_erp(OdeSettings settings, double erp) {
  settings.erp = erp;
  return settings;
}

/// One way to step, at the steps of the ladder.
struct Ladder {
  std::string label;
  std::vector<double> error;         // rad
  std::vector<double> half_started;  // rad, with the half-step start
  std::vector<double> gap;           // m
};

Ladder ladder(const Scenario& file, const Method& method, const OdeSettings& settings, std::string label) {
  Ladder ladder{std::move(label), {}, {}, {}};
  for (const double h : steps_s) {
    Scenario scenario = file;
    scenario.step_s = h;
    scenario.duration_s = 1;
    scenario.sample_s = 0.01;
    Evaluator evaluator(scenario);
    const Evaluation usual = evaluator.evaluate(method, settings);
    ladder.error.push_back(error_until(evaluator, usual, order_until_s));
    ladder.gap.push_back(evaluator.measure(usual, order_until_s)[quantity::max_gap].value_or(NAN));
    ladder.half_started.push_back(
        error_until(evaluator, evaluator.evaluate(method, half_step_started(settings)), order_until_s));
  }
  return ladder;
}

Cell order_cell(const std::vector<double>& values) {
  std::vector<ErrorPoint> points;
  for (std::size_t i = 0; i < values.size(); ++i) points.push_back({steps_s[i], values[i], 0});
  const auto order = observed_order(points, INFINITY);
  if (!order) return Missing{"generalized coordinates have no gap"};
  return shown(known_by(report::Source::fit, measured("", "", order->order, order->half_width)));
}

/// The error over ERP, beside the methods that have none.
report::Figure erp_figure(Evaluator& evaluator, const Scenario& file, const Method& projected, double symplectic,
                          double projected_error) {
  Panel error{.x_label = "ERP", .y_label = "angle error until 3 s, rad", .log_y = true};
  Panel gap{.x_label = "ERP", .y_label = "widest gap of a joint until 3 s, m", .log_y = true};
  report::Series of_ode{"ode-step-double", {}, {}, report::Mark::line_and_points, colour_of("ode-step-double")};
  report::Series gap_of_ode = of_ode;
  for (const double erp : erps) {
    const Evaluation run = evaluator.evaluate(*available("ode-step-double"), with_erp(file.ode, erp));
    of_ode.x.push_back(erp);
    of_ode.y.push_back(error_until(evaluator, run, until_s));
    gap_of_ode.x.push_back(erp);
    gap_of_ode.y.push_back(evaluator.measure(run, until_s)[quantity::max_gap].value_or(NAN));
  }
  error.series = {std::move(of_ode),
                  curve("lagrange-symplectic-euler", {0, 1}, {symplectic, symplectic},
                        colour_of("lagrange-symplectic-euler"), true),
                  curve(std::string(projected.name), {0, 1}, {projected_error, projected_error}, -1, true)};
  gap.series = {std::move(gap_of_ode)};
  return {.name = "coordinates-erp", .panels = {std::move(error), std::move(gap)}, .columns = 2};
}

report::Figure order_figure(const std::vector<Ladder>& ladders) {
  Panel gap{.x_label = "h, s", .y_label = "widest gap until 1 s, m", .log_x = true, .log_y = true};
  Panel error{
      .x_label = "h, s", .y_label = "angle error until 1 s, half-step start, rad", .log_x = true, .log_y = true};
  const Column steps(std::begin(steps_s), std::end(steps_s));
  for (std::size_t i = 0; i < ladders.size(); ++i) {
    const Ladder& one = ladders[i];
    const int colour = variant(i);
    error.series.push_back({one.label, steps, one.half_started, report::Mark::line_and_points, colour});
    if (one.gap.back() > 0) gap.series.push_back({one.label, steps, one.gap, report::Mark::line_and_points, colour});
  }
  return {.name = "coordinates-order", .panels = {std::move(gap), std::move(error)}, .columns = 2};
}

report::Table order_table(const std::vector<Ladder>& ladders) {
  report::Table table{.name = "coordinates-order",
                      .columns = {"scheme", "order of the error", "order with the half-step start", "order of the gap",
                                  "error at 1 ms, rad", "with the half-step start, rad"}};
  for (const Ladder& one : ladders) {
    table.rows.push_back({one.label, order_cell(one.error), order_cell(one.half_started), order_cell(one.gap),
                          one.error[1], one.half_started[1]});
  }
  return table;
}

/// The compared methods' errors until 3 s and their medians of the condition number.
struct Compared {
  double error[std::size(compared)];
  double uncertainty[std::size(compared)];
  double condition[std::size(compared)];
  report::Table table{.name = "coordinates",
                      .columns = {"method", "error until 3 s, rad", "the reference's uncertainty, rad",
                                  "condition number, median over the run"}};
  Panel panel{.x_label = "t, s", .y_label = "condition number", .log_y = true};
};

Compared measure_compared(Laboratory& laboratory, Evaluator& evaluator) {
  Compared all;
  for (std::size_t i = 0; i < std::size(compared); ++i) {
    const Evaluation& run = *laboratory.run("double_pendulum", compared[i]);
    all.error[i] = error_until(evaluator, run, until_s);
    all.uncertainty[i] = uncertainty_until(evaluator, run, until_s);
    all.condition[i] = median(run.trace.condition);
    all.table.rows.push_back({std::string(compared[i]), all.error[i], all.uncertainty[i], all.condition[i]});
    all.panel.series.push_back(curve(compared[i], run.trace.t, run.trace.condition, colour_of(compared[i])));
  }
  all.panel.shade = lost_shade(evaluator, *laboratory.run("double_pendulum", compared[0]));
  return all;
}

std::vector<Ladder> measure_ladders(const Scenario& file, const Method& step, const Method& projected) {
  std::vector<Ladder> ladders;
  for (const double erp : laddered_erps) {
    ladders.push_back(ladder(file, step, with_erp(file.ode, erp), fmt::format("dWorldStep, ERP {}", erp)));
  }
  ladders.push_back(ladder(file, projected, file.ode, std::string(projected.name)));
  Method symplectic = *available("lagrange-symplectic-euler");
  symplectic.settings = catalogue::rebuilt_step_settings();  // to be given the half-step start as well
  ladders.push_back(ladder(file, symplectic, file.ode, "symplectic Euler, generalized"));
  return ladders;
}

void add_findings(Findings& findings, const Compared& all, double unfed_error, double control_error) {
  findings.add("C3.error_ratio",
               measured_ratio("error of dWorldStep over that of symplectic Euler in generalized coordinates, until 3 s",
                              all.error[0], all.error[2], all.uncertainty[0], all.uncertainty[2]));
  findings.add("C3.condition_ratio",
               measured_ratio("median condition number of ODE's system matrix over that of the generalized mass matrix",
                              all.condition[0], all.condition[2]));
  findings.add("coordinates.feedback_gain",
               measured_ratio("error of dWorldStep without feedback (ERP 0) over that with it, until 3 s", unfed_error,
                              all.error[0], all.uncertainty[0], all.uncertainty[0]));
  findings.add("coordinates.scheme_ratio",
               measured_ratio("error of dWorldStep over that of its own scheme in generalized coordinates, until 3 s",
                              all.error[0], control_error, all.uncertainty[0], all.uncertainty[0]));
}

}  // namespace

Content coordinates(Laboratory& laboratory, Findings& findings) {
  Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  const Scenario& file = evaluator.scenario();
  Compared all = measure_compared(laboratory, evaluator);
  const Method step = *available("ode-step-double");
  const Method projected = projected_step();
  const Evaluation unfed = evaluator.evaluate(step, with_erp(file.ode, 0));
  const Evaluation control = evaluator.evaluate(projected);
  const double unfed_error = error_until(evaluator, unfed, until_s);
  const double control_error = error_until(evaluator, control, until_s);
  all.table.rows.push_back(
      {std::string("ode-step-double, ERP 0"), unfed_error, all.uncertainty[0], median(unfed.trace.condition)});
  all.table.rows.push_back(
      {std::string(projected.name), control_error, all.uncertainty[0], median(control.trace.condition)});
  add_findings(findings, all, unfed_error, control_error);
  const std::vector<Ladder> ladders = measure_ladders(file, step, projected);

  Content content;
  content.values = {{"step", file.step_s},
                    {"order_until", order_until_s},
                    {"largest_step", steps_s[0]},
                    {"least_step", steps_s[std::size(steps_s) - 1]},
                    {"worse_conditioned", shown(all.condition[0] / all.condition[2])},
                    {"smaller_error", shown(all.error[2] / all.error[0])},
                    {"unfed_error", shown(unfed_error)},
                    {"error", shown(all.error[0])},
                    {"known", reference_known(evaluator, {1})},
                    {"generalized_error", shown(control_error)}};
  content.exhibits.emplace_back(std::move(all.table));
  content.exhibits.emplace_back(erp_figure(evaluator, file, projected, all.error[2], control_error));
  content.exhibits.emplace_back(order_figure(ladders));
  content.exhibits.emplace_back(order_table(ladders));
  content.exhibits.emplace_back(
      report::Figure{.name = "coordinates-condition", .panels = {told_apart(std::move(all.panel))}});
  return content;
}

}  // namespace odeval::experiments
