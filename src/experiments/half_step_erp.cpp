// Which ERP is best when the half-step start has taken the first-order error away: claim O2.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Panel;
using report::Series;

constexpr double coarse_step_s = 1e-3;
constexpr double fine_step_s = 1e-4;
constexpr double times_s[] = {1, 3};
constexpr double erps[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
struct Case {
  const char* scenario;
  double step_s;
};
constexpr Case cases[] = {{"double_pendulum", coarse_step_s},
                          {"double_pendulum", fine_step_s},
                          {"single_pendulum", coarse_step_s},
                          {"single_pendulum", fine_step_s},
                          {"chain", coarse_step_s}};  // the fine step takes ODE a second a run

struct Point {
  std::string scenario;
  double step_s;
  double erp;
  double error[2];  // rad, until times_s, with the half-step start
  double doubt[2];  // rad, of the reference
  double as_given;  // rad, until the last of the times, without it
};

Point measure_one(Evaluator& evaluator, double erp) {
  OdeSettings settings = evaluator.scenario().ode;
  settings.erp = erp;
  const Evaluation usual = evaluator.evaluate(*available("ode-step-double"), settings);
  settings.start = Start::half_step;
  const Evaluation started = evaluator.evaluate(*available("ode-step-double"), settings);
  Point point{evaluator.scenario().name, evaluator.scenario().step_s, erp, {}, {}, 0};
  for (std::size_t i = 0; i < std::size(times_s); ++i) {
    point.error[i] = error_until(evaluator, started, times_s[i]);
    point.doubt[i] = uncertainty_until(evaluator, started, times_s[i]);
  }
  point.as_given = error_until(evaluator, usual, times_s[1]);
  return point;
}

Panel panel(const std::vector<Point>& points, const std::string& scenario, double step_s) {
  Panel panel{
      .x_label = fmt::format("ERP ({}, h = {} s)", scenario, step_s), .y_label = "angle error, rad", .log_y = true};
  Series series[] = {{"half-step start, until 1 s", {}, {}, report::Mark::line_and_points, 0},
                     {"half-step start, until 3 s", {}, {}, report::Mark::line_and_points, 1},
                     {"as given, until 3 s", {}, {}, report::Mark::line_and_points, 2, true}};
  for (const Point& point : points) {
    if (point.scenario != scenario || point.step_s != step_s) continue;
    for (Series& one : series) one.x.push_back(point.erp);
    series[0].y.push_back(point.error[0]);
    series[1].y.push_back(point.error[1]);
    series[2].y.push_back(point.as_given);
  }
  panel.series.assign(std::begin(series), std::end(series));
  return panel;
}

}  // namespace

Section half_step_erp(Laboratory& laboratory, Findings& findings) {
  std::vector<Point> points;
  report::Figure figure{"half-step-erp-figure", "Angle error over ERP, with the half-step start", {}, {}, 2};
  report::Table table{
      "half-step-erp",
      "ERP with the half-step start",
      {"scenario", "h, s", "ERP", "error until 1 s, rad", "uncertainty of the reference at 1 s, rad",
       "error until 3 s, rad", "error until 3 s as given, rad", "uncertainty of the reference at 3 s, rad"},
      {},
      "dWorldStep, CFM of the file. 'As given' is without the half-step start."};
  for (const Case& which : cases) {
    Scenario scenario = laboratory.scenario(which.scenario);
    scenario.step_s = which.step_s;
    scenario.duration_s = times_s[1];
    Evaluator evaluator(scenario);
    for (const double erp : erps) {
      points.push_back(measure_one(evaluator, erp));
      const Point& point = points.back();
      table.rows.push_back({point.scenario, point.step_s, point.erp, point.error[0], point.doubt[0], point.error[1],
                            point.as_given, point.doubt[1]});
    }
    figure.panels.push_back(panel(points, which.scenario, which.step_s));
  }
  const auto gain = [&](const char* finding, const Case& which, std::size_t until) {
    const auto find = [&](double erp) {
      return *std::ranges::find_if(points, [&](const Point& point) {
        return point.scenario == which.scenario && point.step_s == which.step_s && point.erp == erp;
      });
    };
    const Point usual = find(0.2);
    const Point stiff = find(0.8);
    findings.add(finding,
                 measured_ratio(fmt::format("angle error until {} s with ERP 0.2 over that with ERP 0.8, half-step "
                                            "start, {}, h = {} s",
                                            times_s[until], which.scenario, which.step_s),
                                usual.error[until], stiff.error[until], usual.doubt[until], stiff.doubt[until]));
  };
  gain("O2.gain", {"double_pendulum", fine_step_s}, 1);
  gain("O2.gain_chain", {"chain", coarse_step_s}, 0);
  figure.caption =
      "The dashed curve is ODE as it is usually started: there the first-order error hides what ERP does, and one "
      "value "
      "of ERP looks like another.";

  Section section{"half-step-erp", "The best ERP", {}};
  section.blocks.emplace_back(report::Text{
      "ERP is the part of a joint's error that a step takes back; 0.2 is ODE's default. With the half-step start the "
      "error that is left is of second order, and what the joints do shows. The double and the single pendulum and a "
      "chain are run for 3 s with ERP from 0 to 1; look for the lowest point, and for how flat the curve is around it. "
      "On the chain ERP counts for more than the start, and 1 is best."});
  section.blocks.emplace_back(std::move(figure));
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
