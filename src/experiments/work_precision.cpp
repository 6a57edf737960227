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
constexpr double best_erp = 0.8;  // claim O2

/// One line of the diagram: a method as the file has it, or ODE's direct step at other settings.
struct Line {
  const Method* method;
  std::string name;
  Start start = Start::as_given;
  double erp = 0;  // 0: the file's
};

struct Point {
  const Line* line;
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
  const std::string_view name = catalogue::knob_name(catalogue::knob_of(*point.line->method));
  return name.empty() ? "-" : fmt::format("{} = {:.3g}", name, point.trial.setting);
}

struct Diagram {
  std::vector<Point> points;  // method after method, each from coarse to fine
  std::vector<TimedRun> runs;
  double uncertainty;
};

Scenario scenario_of(const Line& line, const Scenario& file) {
  Scenario scenario = file;
  scenario.ode.start = line.start;
  if (line.erp > 0) scenario.ode.erp = line.erp;
  return scenario;
}

/// A method is followed until its error is lost in the reference's uncertainty.
Diagram measure(const Scenario& file, const std::vector<Line>& lines, double until_s) {
  Diagram diagram{{}, {}, 0};
  std::vector<catalogue::Evaluator> evaluators;
  evaluators.reserve(lines.size() * 16);  // timed runs point at them
  for (const Line& line : lines) {
    const Accuracy accuracy(scenario_of(line, file), until_s);
    diagram.uncertainty = accuracy.uncertainty();
    for (const double setting : settings_of(*line.method, accuracy, until_s)) {
      Point point{&line, accuracy.try_setting(*line.method, setting), std::nullopt};
      if (std::isfinite(point.trial.error)) {
        evaluators.push_back(accuracy.at(*line.method, setting));
        point.run = diagram.runs.size();
        diagram.runs.push_back({&evaluators.back(), line.method, 0, 0, {}});
      }
      diagram.points.push_back(point);
      if (point.trial.error <= diagram.uncertainty) break;
    }
  }
  time_in_turns(diagram.runs, rounds);
  return diagram;
}

report::Panel panel_of(const Diagram& diagram, double until_s) {
  report::Panel panel{.title = fmt::format("until {} s", until_s),
                      .x_label = fmt::format("CPU time until {} s, s", until_s),
                      .y_label = fmt::format("largest angle error until {} s, rad", until_s),
                      .log_x = true,
                      .log_y = true};
  double least = INFINITY;
  double most = 0;
  for (const Point& point : diagram.points) {
    if (!point.run) continue;
    const Line& line = *point.line;
    if (panel.series.empty() || panel.series.back().label != line.name) {
      const bool as_file = line.name == line.method->name;
      panel.series.push_back(
          {line.name, {}, {}, report::Mark::line_and_points, as_file ? colour_beside_ode(line.name) : -1});
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
                          colour_of(catalogue::reference_method),
                          true});
  return panel;
}

void add_rows(report::Table& table, const Diagram& diagram, double until_s) {
  for (const Point& point : diagram.points) {
    std::vector<Cell> row{until_s, point.line->name, setting_text(point)};
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
  std::vector<Line> lines;
  std::vector<std::string> claiming;
  for (const Method& method : catalogue::methods()) {
    if (!catalogue::does(method, file)) continue;
    claiming.emplace_back(method.name);
    if (method.make != nullptr) lines.push_back({&method, std::string(method.name)});
  }
  const Method* const direct = available("ode-step-double");
  lines.push_back({direct, "ode-step-double, half-step start", Start::half_step});
  lines.push_back(
      {direct, fmt::format("ode-step-double, half-step start, ERP {}", best_erp), Start::half_step, best_erp});
  report::Table table{.name = "work-precision",
                      .columns = {"until, s", "method", "setting", "error, rad", "the reference's uncertainty, rad",
                                  "steps", "evaluations", "CPU time, ms", "deviation, ms"}};
  report::Figure figure{.name = "work-precision-figure", .columns = 2};
  for (const double until_s : untils_s) {
    const Diagram diagram = measure(file, lines, until_s);
    figure.panels.push_back(panel_of(diagram, until_s));
    add_rows(table, diagram, until_s);
  }
  Content content;
  content.values = {{"rounds", rounds},
                    {"rows_apart", shown(0.05)},
                    {"most_steps", most_steps},
                    {"tightest_rtol", tightest_rtol},
                    {"atol_over_rtol", catalogue::atol_over_rtol},
                    {"lost", divergence_rad},
                    {"left_out", left_out(claiming)}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
