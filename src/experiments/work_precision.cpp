// Error against CPU time, for every method at many settings: the work-precision diagram of ODE-solver benchmarks.
#include <fmt/format.h>

#include <cmath>

#include "catalogue/accuracy.hpp"
#include "catalogue/timing.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Accuracy;
using catalogue::Knob;
using catalogue::Method;
using catalogue::TimedRun;
using catalogue::Trial;
using report::Cell;
using report::Missing;

constexpr double untils_s[] = {1, 3};
constexpr int rounds = 3;
constexpr long steps_a_row[] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};
constexpr long most_steps = 30'000;  // of one run: what the slowest engine does in a tenth of a second
constexpr double loosest_rtol = 1e-2;
constexpr double tightest_rtol = 1e-13;

struct Point {
  const Method* method;
  Trial trial;
  std::optional<std::size_t> run;  // of the timed runs; none where the run failed
};

/// From coarse to fine.
std::vector<double> settings_of(const Method& method, const Accuracy& accuracy, double until_s) {
  std::vector<double> settings;
  switch (catalogue::knob_of(method)) {
    case Knob::step:
      for (const long n : steps_a_row) {
        const double step_s = accuracy.row_spacing_s() / static_cast<double>(n);
        if (std::lround(until_s / step_s) <= most_steps) settings.push_back(step_s);
      }
      break;
    case Knob::rtol:
      for (double rtol = loosest_rtol; rtol > tightest_rtol / 2; rtol /= 10) settings.push_back(rtol);
      break;
    case Knob::none:
      settings.push_back(0);
      break;
  }
  return settings;
}

std::string setting_text(const Point& point) {
  const std::string_view name = catalogue::knob_name(catalogue::knob_of(*point.method));
  return name.empty() ? "-" : fmt::format("{} = {:.3g}", name, point.trial.setting);
}

struct Diagram {
  std::vector<Point> points;  // method after method, each from coarse to fine
  std::vector<TimedRun> runs;
  double uncertainty;
};

/// A method is followed until its error is lost in the reference's uncertainty.
Diagram measure(const Scenario& file, const std::vector<const Method*>& methods, double until_s) {
  const Accuracy accuracy(file, until_s);
  Diagram diagram{{}, {}, accuracy.uncertainty()};
  std::vector<catalogue::Evaluator> evaluators;
  evaluators.reserve(methods.size() * 16);  // timed runs point at them
  for (const Method* method : methods) {
    for (const double setting : settings_of(*method, accuracy, until_s)) {
      Point point{method, accuracy.try_setting(*method, setting), std::nullopt};
      if (std::isfinite(point.trial.error)) {
        evaluators.push_back(accuracy.at(*method, setting));
        point.run = diagram.runs.size();
        diagram.runs.push_back({&evaluators.back(), method, 0, 0, {}});
      }
      diagram.points.push_back(point);
      if (point.trial.error <= diagram.uncertainty) break;
    }
  }
  time_in_turns(diagram.runs, rounds);
  return diagram;
}

report::Panel panel_of(const Diagram& diagram, double until_s) {
  report::Panel panel{.x_label = fmt::format("CPU time until {} s, s", until_s),
                      .y_label = fmt::format("largest angle error until {} s, rad", until_s),
                      .log_x = true,
                      .log_y = true};
  double least = INFINITY;
  double most = 0;
  for (const Point& point : diagram.points) {
    if (!point.run) continue;
    const std::string name(point.method->name);
    if (panel.series.empty() || panel.series.back().label != name) {
      panel.series.push_back({name, {}, {}, report::Mark::line_and_points, colour_of(name)});
    }
    const double seconds = diagram.runs[*point.run].median_s();
    panel.series.back().x.push_back(seconds);
    panel.series.back().y.push_back(point.trial.error);
    least = std::min(least, seconds);
    most = std::max(most, seconds);
  }
  panel.series.push_back({"uncertainty of the reference",
                          {least, most},
                          {diagram.uncertainty, diagram.uncertainty},
                          report::Mark::line,
                          guide_colour,
                          true});
  return panel;
}

void add_rows(report::Table& table, const Diagram& diagram, double until_s) {
  for (const Point& point : diagram.points) {
    std::vector<Cell> row{until_s, std::string(point.method->name), setting_text(point)};
    if (point.run) {
      const TimedRun& run = diagram.runs[*point.run];
      row.insert(row.end(), {point.trial.error, point.trial.uncertainty, static_cast<double>(point.trial.steps),
                             point.trial.evaluations > 0 ? Cell(static_cast<double>(point.trial.evaluations))
                                                         : Cell(Missing{"ODE does not evaluate equations of motion"}),
                             1e3 * run.median_s(), 1e3 * run.mad_s()});
    } else {
      const Missing failed{"the run did not stay finite, or its solver gave up"};
      row.insert(row.end(), {failed, point.trial.uncertainty, failed, failed, failed, failed});
    }
    table.rows.push_back(std::move(row));
  }
}

}  // namespace

Content work_precision(Laboratory& laboratory, Findings&) {
  const Scenario& file = laboratory.scenario("double_pendulum");
  std::vector<const Method*> methods;
  std::vector<std::string> claiming;
  for (const Method& method : catalogue::methods()) {
    if (!catalogue::does(method, file)) continue;
    claiming.emplace_back(method.name);
    if (method.make != nullptr) methods.push_back(&method);
  }
  report::Table table{.name = "work-precision",
                      .columns = {"until, s", "method", "setting", "error, rad", "the reference's uncertainty, rad",
                                  "steps", "evaluations", "CPU time, ms", "± ms"}};
  report::Figure figure{.name = "work-precision-figure", .columns = 2};
  for (const double until_s : untils_s) {
    const Diagram diagram = measure(file, methods, until_s);
    figure.panels.push_back(panel_of(diagram, until_s));
    add_rows(table, diagram, until_s);
  }
  Content content;
  content.values = {{"rounds", rounds},
                    {"rows_apart", shown(0.05)},
                    {"most_steps", most_steps},
                    {"tightest_rtol", tightest_rtol},
                    {"left_out", left_out(claiming)}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
