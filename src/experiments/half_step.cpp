// The first-order part of ODE's error is a clock half a step off: claim O1.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/order.hpp"
#include "measure/spread.hpp"
#include "measure/time_shift.hpp"
#include "model/generate.hpp"

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
constexpr int impact_steps = 11;
constexpr double impact_step(int i) { return 0.8 + 0.04 * i; }  // of the file's
constexpr std::string_view method = "ode-step-double";
constexpr const char* few_points = "too few errors are clear of the reference's uncertainty";

struct Case {
  const char* scenario;
  std::vector<double> qd0;  // rad/s; empty: as the file has it
  std::string label;
  const char* findings;  // what their names end in; null: it leaves none
};

Case case_of(const char* scenario, const std::string& what, std::vector<double> qd0, const char* findings) {
  const std::string from = qd0.empty() ? "rest" : fmt::format("{} rad/s", fmt::join(qd0, " and "));
  return {scenario, std::move(qd0), what + " from " + from, findings};
}

struct Run {
  double step_s;
  double error;         // rad, as given
  double half_started;  // rad, with the half-step start
  double uncertainty;   // rad, of the reference
  TimeShift shift;
};

Scenario short_run(const Scenario& file, const Case& which, double step_s) {
  Scenario scenario = file;
  scenario.step_s = step_s;
  scenario.duration_s = until_s + 5 * step_s;  // room for shifts at the end
  if (!which.qd0.empty()) change_planar(scenario, [&](PlanarView& view) { view.qd0 = which.qd0; });
  return scenario;
}

Run measure_one(const Scenario& file, const Case& which, double step_s) {
  Evaluator evaluator(short_run(file, which, step_s));
  const Evaluation usual = evaluator.evaluate(*available(method));
  const Evaluation started = evaluator.evaluate(*available(method), half_step_started(file.ode));
  return {step_s, error_until(evaluator, usual, until_s), error_until(evaluator, started, until_s),
          uncertainty_until(evaluator, usual, until_s),
          best_time_shift(usual.trace, evaluator.reference().trace, until_s, 2 * step_s).value()};
}

/// Nothing when too few errors are clear of uncertainty.
std::optional<ObservedOrder> order_of(const std::vector<Run>& runs, double (*error)(const Run&)) {
  std::vector<ErrorPoint> points;
  for (const Run& run : runs) points.push_back({run.step_s, error(run), run.uncertainty});
  return observed_order(points, divergence_rad);
}

double as_given(const Run& run) { return run.error; }
double half_started(const Run& run) { return run.half_started; }
double after_shift(const Run& run) { return run.shift.max_left; }

void add_rows(report::Table& table, const Case& which, const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    table.rows.push_back({which.label, run.step_s, run.error, run.shift.shift_s / run.step_s, run.shift.max_left,
                          run.half_started, run.error / run.half_started, run.uncertainty});
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
  Panel panel{.title = which.label,
              .x_label = "h, s",
              .y_label = fmt::format("angle error until {} s, rad", until_s),
              .log_x = true,
              .log_y = true};
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
  findings.add(
      "O1.shift" + end,
      measured(fmt::format("how far ODE runs ahead of the reference, {}, h = {} s", settings, fine_step_s), "steps",
               fine.shift.shift_s / fine.step_s, fine.uncertainty / fine.shift.sensitivity / fine.step_s));
  findings.add("O1.gain" + end, measured_ratio(fmt::format("angle error as given over that with the half-step start, "
                                                           "{}, h = {} s",
                                                           settings, fine_step_s),
                                               fine.error, fine.half_started, fine.uncertainty, fine.uncertainty));
  const std::string meaning = "observed order with the half-step start, " + settings;
  const auto order = order_of(runs, half_started);
  findings.add("O1.order" + end,
               order ? known_by(report::Source::fit, measured(meaning, "", order->order, order->half_width))
                     : unavailable(meaning, "", few_points));
}

/// The best shift of every method's trace, at the settings of the files.
report::Table every_trace(Laboratory& laboratory) {
  report::Table table{.name = "half-step-every",
                      .columns = {"scenario", "method", "best shift, steps", "± (shift)", "error as it is, rad",
                                  "error after the shift, rad", "uncertainty of the reference, rad"}};
  for (const char* name : {"double_pendulum", "single_pendulum", "chain"}) {
    Evaluator& evaluator = laboratory.evaluator(name);
    for (const std::string& of : evaluator.scenario().methods) {
      const Evaluation* const run = laboratory.run(name, of);
      if (run == nullptr || of == catalogue::reference_method) continue;
      const Metrics metrics = evaluator.measure(*run, until_s);
      if (!metrics[quantity::time_shift]) continue;
      const double step_s = evaluator.grid().step_s;
      table.rows.push_back({std::string(name), of, *metrics[quantity::time_shift] / step_s,
                            *metrics[quantity::time_shift_uncertainty] / step_s, *metrics[quantity::max_error_q],
                            *metrics[quantity::error_q_after_shift], *metrics[quantity::reference_uncertainty]});
    }
  }
  return table;
}

/// Angle errors, or of bodies distances, over all samples in a span of time.
double largest_between(const Trace& trace, double from_s, double to_s) {
  const Span rows = rows_between(trace.t, from_s, to_s);
  double largest = 0;
  for (const Column& error : trace.error_q.empty() ? trace.error_position : trace.error_q) {
    for (std::size_t k = rows.first; k < rows.end; ++k) largest = std::max(largest, std::fabs(error[k]));
  }
  return largest;
}

/// Of the same span at several steps.
struct Gains {
  std::vector<double> as_given;
  std::vector<double> started;
  std::vector<double> gain;
  double uncertainty = 0;  // of the reference, the largest
};

/// How the half-step start fares from impact to impact. What an impact is off by depends on where in a step it falls,
/// so that one step size would tell of luck: each span is measured at several.
void add_impacts(report::Table& table, const Scenario& file, const char* unit) {
  constexpr std::size_t spans = 3;
  std::array<Gains, spans> gains;
  for (int i = 0; i < impact_steps; ++i) {
    Scenario scenario = file;
    scenario.step_s = file.step_s * impact_step(i);  // no multiple of another, as the times of impacts are not
    scenario.sample_s.reset();
    Evaluator evaluator(scenario);
    const std::vector<Impact>& impacts = evaluator.reference().impacts;
    const Trace usual = evaluator.evaluate(*available(method)).trace;
    const Trace started = evaluator.evaluate(*available(method), half_step_started(file.ode)).trace;
    const Reference& reference = evaluator.reference();
    const Column& uncertainties =
        reference.uncertainty_q.empty() ? reference.uncertainty_position : reference.uncertainty_q;
    const double uncertainty = std::ranges::max(uncertainties);
    const double margin = 2 * scenario.step_s;  // the samples next to an impact differ by when it happened
    for (std::size_t s = 0; s < spans; ++s) {
      const double from_s = s == 0 ? 0 : impacts.at(s - 1).t + margin;
      const double to_s = impacts.at(s).t - margin;
      gains[s].as_given.push_back(largest_between(usual, from_s, to_s));
      gains[s].started.push_back(largest_between(started, from_s, to_s));
      gains[s].gain.push_back(gains[s].as_given.back() / gains[s].started.back());
      gains[s].uncertainty = std::max(gains[s].uncertainty, uncertainty);
    }
  }
  const char* names[spans] = {"until the first impact", "from the first to the second", "from the second to the third"};
  for (std::size_t s = 0; s < spans; ++s) {
    const auto& [as_given, started, gain, uncertainty] = gains[s];
    std::vector<Cell> row{file.name,        std::string(names[s]), std::string(unit),
                          median(as_given), median(started),       uncertainty};
    if (median(started) > uncertainty) {
      row.insert(row.end(), {median(gain), std::ranges::min(gain), std::ranges::max(gain)});
    } else {
      row.insert(row.end(), 3, Missing{"no error is left that the reference could tell"});
    }
    table.rows.push_back(std::move(row));
  }
}

report::Table after_impact(Laboratory& laboratory) {
  report::Table table{
      .name = "half-step-impact",
      .columns = {"scenario", "span", "unit", "largest error as given, median", "with the half-step start, median",
                  "uncertainty of the reference", "gain, median", "least gain", "greatest gain"}};
  add_impacts(table, laboratory.scenario("wall_pendulum"), "rad");
  add_impacts(table, laboratory.scenario("bouncing_ball"), "m");
  return table;
}

}  // namespace

Content half_step(Laboratory& laboratory, Findings& findings) {
  const std::vector<Case> cases{
      case_of("double_pendulum", "double pendulum", {}, ""),
      case_of("single_pendulum", "single pendulum", {}, nullptr),
      case_of("double_pendulum", "double pendulum", {2, -1}, "_at_speed"),
      case_of("single_pendulum", "single pendulum", {2}, nullptr),
      case_of("chain", fmt::format("chain of {} links", laboratory.scenario("chain").planar->links.size()), {},
              "_chain"),
  };
  report::Table errors{.name = "half-step",
                       .columns = {"motion", "h, s", "error as given, rad", "best shift, steps",
                                   "error after the shift, rad", "error with the half-step start, rad",
                                   "gain of the half-step start", "uncertainty of the reference, rad"}};
  report::Table orders{.name = "half-step-order",
                       .columns = {"motion", "as given", "half width (as given)", "after the best shift",
                                   "half width (after the shift)", "half-step start", "half width (half-step start)"}};
  Figure figure{.name = "half-step-figure", .columns = 2};
  std::vector<report::Values> gains;
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
    gains.push_back({{"motion", which.label}, {"times", shown(fine.error / fine.half_started)}});
  }

  Content content;
  content.values = {{"until", until_s},
                    {"step", fine_step_s},
                    {"gains", gains},
                    {"links", laboratory.scenario("chain").planar->links.size()},
                    {"impact_steps", impact_steps},
                    {"least_impact_step", shown(impact_step(0))},
                    {"largest_impact_step", shown(impact_step(impact_steps - 1))}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(errors));
  content.exhibits.emplace_back(std::move(orders));
  content.exhibits.emplace_back(every_trace(laboratory));
  content.exhibits.emplace_back(after_impact(laboratory));
  return content;
}

}  // namespace odeval::experiments
