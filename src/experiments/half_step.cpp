// The first-order part of ODE's error is a clock half a step off: claim O1.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/order.hpp"
#include "measure/time_shift.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Figure;
using report::Missing;
using report::Panel;

constexpr double steps_s[] = {2e-3, 1e-3, 5e-4, 2e-4, 1e-4};
constexpr double fine_step_s = 1e-4;
constexpr double until_s = 1;
constexpr std::string_view method = "ode-step-double";
constexpr const char* few_points = "too few errors are clear of the reference's uncertainty";

struct Case {
  const char* scenario;
  std::vector<double> qd0;  // rad/s; empty: as the file has it
  std::string label;
  const char* findings;  // what their names end in; null: it leaves none
};

struct Run {
  double step_s;
  double error;         // rad, as given
  double half_started;  // rad, with the half-step start
  double doubt;         // rad, of the reference
  TimeShift shift;
};

Scenario short_run(const Scenario& file, const Case& which, double step_s) {
  Scenario scenario = file;
  scenario.step_s = step_s;
  scenario.duration_s = until_s + 5 * step_s;  // room for shifts at the end
  if (!which.qd0.empty()) scenario.qd0 = which.qd0;
  return scenario;
}

OdeSettings half_step(OdeSettings settings) {
  settings.start = Start::half_step;
  return settings;
}

Run measure_one(const Scenario& file, const Case& which, double step_s) {
  Evaluator evaluator(short_run(file, which, step_s));
  const Evaluation usual = evaluator.evaluate(*available(method));
  const Evaluation started = evaluator.evaluate(*available(method), half_step(file.ode));
  return {step_s, error_until(evaluator, usual, until_s), error_until(evaluator, started, until_s),
          uncertainty_until(evaluator, usual, until_s),
          best_time_shift(usual.trace, evaluator.reference().trace, until_s, 2 * step_s).value()};
}

/// Nothing when too few errors are clear of doubt.
std::optional<ObservedOrder> order_of(const std::vector<Run>& runs, double (*error)(const Run&)) {
  std::vector<ErrorPoint> points;
  for (const Run& run : runs) points.push_back({run.step_s, error(run), run.doubt});
  return observed_order(points, divergence_rad);
}

double as_given(const Run& run) { return run.error; }
double half_started(const Run& run) { return run.half_started; }
double after_shift(const Run& run) { return run.shift.max_left; }

void add_rows(report::Table& table, const Case& which, const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    table.rows.push_back({which.label, run.step_s, run.error, run.shift.shift_s / run.step_s, run.shift.max_left,
                          run.half_started, run.error / run.half_started, run.doubt});
  }
}

void add_order(report::Table& table, const Case& which, const std::vector<Run>& runs) {
  std::vector<Cell> row{which.label};
  for (const auto& error : {as_given, after_shift, half_started}) {
    if (const auto order = order_of(runs, error)) {
      row.insert(row.end(), {order->order, order->half_width});
    } else {
      row.insert(row.end(), {Missing{few_points}, Missing{few_points}});
    }
  }
  table.rows.push_back(std::move(row));
}

Panel convergence(const Case& which, const std::vector<Run>& runs) {
  Panel panel{
      .x_label = "h, s (" + which.label + ")", .y_label = "angle error until 1 s, rad", .log_x = true, .log_y = true};
  struct Row {
    const char* label;
    double (*error)(const Run&);
  };
  for (const Row& row : {Row{"as given", as_given}, Row{"against the reference at the best shift", after_shift},
                         Row{"half-step start", half_started}}) {
    report::Series series{row.label, {}, {}, report::Mark::line_and_points};
    for (const Run& run : runs) {
      series.x.push_back(run.step_s);
      series.y.push_back(row.error(run));
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

void add_findings(Findings& findings, const Case& which, const std::vector<Run>& runs) {
  const Run& fine = *std::ranges::find(runs, fine_step_s, &Run::step_s);
  const std::string settings = fmt::format("{}, until {} s", which.label, until_s);
  const std::string end = which.findings;
  findings.add("O1.shift" + end,
               measured(fmt::format("how far ODE runs ahead of the reference, {}, h = {} s", settings, fine_step_s),
                        "steps", fine.shift.shift_s / fine.step_s, fine.doubt / fine.shift.sensitivity / fine.step_s));
  findings.add("O1.gain" + end, measured_ratio(fmt::format("angle error as given over that with the half-step start, "
                                                           "{}, h = {} s",
                                                           settings, fine_step_s),
                                               fine.error, fine.half_started, fine.doubt, fine.doubt));
  const std::string meaning = "observed order with the half-step start, " + settings;
  const auto order = order_of(runs, half_started);
  findings.add("O1.order" + end,
               order ? measured(meaning, "", order->order, order->half_width) : unavailable(meaning, "", few_points));
}

/// The best shift of every method's trace, at the settings of the files.
report::Table every_trace(Laboratory& laboratory) {
  report::Table table{
      "half-step-every",
      "The best shift of every trace",
      {"scenario", "method", "best shift, steps", "± (shift)", "error as it is, rad", "error after the shift, rad",
       "uncertainty of the reference, rad"},
      {},
      fmt::format("Until {} s, at the settings of the files. Only methods that step as ODE does are half "
                  "a step ahead; Euler's errors are no shift, and where an error is as small as what the "
                  "reference may be off by, the shift is noise.",
                  until_s)};
  for (const char* name : {"double_pendulum", "single_pendulum"}) {
    Evaluator& evaluator = laboratory.evaluator(name);
    for (const std::string& of : evaluator.scenario().methods) {
      const Evaluation* const run = laboratory.run(name, of);
      if (run == nullptr || of == catalogue::reference_method) continue;
      const Metrics metrics = evaluator.measure(*run, until_s);
      if (!metrics.time_shift) continue;
      const double step_s = evaluator.grid().step_s;
      table.rows.push_back({std::string(name), of, *metrics.time_shift / step_s,
                            *metrics.time_shift_uncertainty / step_s, *metrics.max_error_q,
                            *metrics.error_q_after_shift, *metrics.reference_uncertainty});
    }
  }
  return table;
}

/// The wall pendulum, whose first impact ends what the half-step start gains.
report::Table after_impact(Evaluator& wall, const Evaluation& usual) {
  const Evaluation started = wall.evaluate(*available(method), half_step(wall.scenario().ode));
  report::Table table{"half-step-impact",
                      "The half-step start and an impact",
                      {"span", "angle error as given, rad", "angle error with the half-step start, rad", "gain"},
                      {},
                      "Wall pendulum at the settings of its file, largest error in each span."};
  const std::vector<Impact>& impacts = wall.reference().impacts;
  if (impacts.size() < 2) return table;
  const double first = impacts[0].t;
  const double second = impacts[1].t;
  const double margin = 2 * wall.grid().step_s;  // the samples next to an impact differ by when it happened
  const auto row = [&](const char* span, double from_s, double to_s) {
    const Span rows = rows_between(usual.trace.t, from_s, to_s);
    const double before = std::ranges::max(part(largest_error(usual.trace), rows));
    const double after = std::ranges::max(part(largest_error(started.trace), rows));
    table.rows.push_back({std::string(span), before, after, before / after});
  };
  row("until the first impact", 0, first - margin);
  row("between the first and the second", first + margin, second - margin);
  row("after the second", second + margin, wall.scenario().duration_s);
  return table;
}

}  // namespace

Section half_step(Laboratory& laboratory, Findings& findings) {
  const std::vector<Case> cases{
      {"double_pendulum", {}, "double pendulum from rest", ""},
      {"single_pendulum", {}, "single pendulum from rest", nullptr},
      {"double_pendulum", {2, -1}, "double pendulum from 2 and -1 rad/s", "_at_speed"},
      {"single_pendulum", {2}, "single pendulum from 2 rad/s", nullptr},
  };
  report::Table errors{
      "half-step",
      "ODE's error as a shift of time",
      {"motion", "h, s", "error as given, rad", "best shift, steps", "error after the shift, rad",
       "error with the half-step start, rad", "gain of the half-step start", "uncertainty of the reference, rad"},
      {},
      fmt::format("Until {} s. A shift of +0.5 means that ODE's angles at t are the reference's at "
                  "t + h/2: ODE is ahead.",
                  until_s)};
  report::Table orders{
      "half-step-order",
      "Observed order in the step size",
      {"motion", "as given", "± (as given)", "after the best shift", "± (after the shift)", "half-step start",
       "± (half-step start)"},
      {},
      fmt::format("Slope of the error until {} s over the step sizes above, with its 95 % interval.", until_s)};
  Figure figure{"half-step-figure", "Angle error over the step size", {}, {}, 2};
  std::string found;
  for (const Case& which : cases) {
    std::vector<Run> runs;
    for (const double step_s : steps_s) {
      runs.push_back(measure_one(laboratory.scenario(which.scenario), which, step_s));
    }
    add_rows(errors, which, runs);
    add_order(orders, which, runs);
    figure.panels.push_back(convergence(which, runs));
    if (which.findings != nullptr) add_findings(findings, which, runs);
    const Run& fine = *std::ranges::find(runs, fine_step_s, &Run::step_s);
    found += fmt::format("{}{}: {} times smaller", found.empty() ? "" : "; ", which.label,
                         shown(fine.error / fine.half_started));
  }
  figure.caption =
      "First order falls by one decade a decade, second order by two. Where the lower curves fall as slowly as the "
      "upper one, a first-order part is left that is no shift of time.";

  Section section{"half-step", "Half a step: what ODE's first-order error is", {}};
  section.blocks.emplace_back(report::Text{
      "ODE computes new velocities from the forces at t and moves the bodies with them. So a stored velocity belongs "
      "to "
      "the middle of the step before, t - h/2, though ODE is started with that of t = 0. From rest, a first velocity "
      "half a step too fresh makes all that follows come half a step early: ODE's angles at t are those of t + h/2."});
  section.blocks.emplace_back(report::Text{fmt::format(
      "To measure it, the reference is shifted in time until it fits ODE best. The half-step start (--start half-step) "
      "takes from the rates that ODE is started with what the weights add in half a step, which costs one evaluation "
      "of "
      "the accelerations before the run. At h = {} s it makes the error until {} s: {}.",
      fine_step_s, until_s, found)});
  section.blocks.emplace_back(report::Text{
      "Only the weights: it is not the joint rates of t = -h/2 that ODE has to be given. Those differ from the rates "
      "of "
      "t = 0 by the Coriolis terms too, but these are there because the links turn, and ODE turns them itself when it "
      "takes old velocities through the hinges of a new pose. Two links that start at speed tell the difference: with "
      "the joint rates of t = -h/2 they keep an error of first order (1.05 ± 0.03 was measured), with the weights "
      "alone "
      "they do not. A start at speed as given is off by more than a shift of time, for the same reason."});
  section.blocks.emplace_back(std::move(figure));
  section.blocks.emplace_back(std::move(errors));
  section.blocks.emplace_back(std::move(orders));
  section.blocks.emplace_back(every_trace(laboratory));
  section.blocks.emplace_back(
      report::Text{"An impact starts a new motion, with a velocity of the step that found it. What the start has "
                   "gained would have to "
                   "be gained again there, and ODE offers no way to do so; the last table shows what remains."});
  section.blocks.emplace_back(
      after_impact(laboratory.evaluator("wall_pendulum"), *laboratory.run("wall_pendulum", method)));
  return section;
}

}  // namespace odeval::experiments
