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
constexpr double default_erp = 0.2;  // ode-0.16, ode/src/objects.h
constexpr double stiff_erp = 0.8;
constexpr double times_s[] = {1, 3};
constexpr double erps[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
struct Case {
  const char* scenario;
  double step_s;
  std::size_t times = std::size(times_s);  // how many of them
  std::size_t stride = 1;                  // every so many-th of erps
};
constexpr Case cases[] = {
    {"double_pendulum", coarse_step_s}, {"double_pendulum", fine_step_s},
    {"single_pendulum", coarse_step_s}, {"single_pendulum", fine_step_s},
    {"chain", coarse_step_s},           {"chain", fine_step_s, 1, 2}};  // takes ODE 0.3 s a run and second

struct Point {
  std::string scenario;
  double step_s;
  double erp;
  std::vector<double> error{};        // rad, until each of the times, with the half-step start
  std::vector<double> as_given{};     // rad, likewise, without it
  std::vector<double> uncertainty{};  // rad, of the reference
};

Point measure_one(Evaluator& evaluator, const Case& which, double erp) {
  OdeSettings settings = evaluator.scenario().ode;
  settings.erp = erp;
  const Evaluation usual = evaluator.evaluate(*available("ode-step-double"), settings);
  settings.start = Start::half_step;
  const Evaluation started = evaluator.evaluate(*available("ode-step-double"), settings);
  Point point{which.scenario, which.step_s, erp};
  for (std::size_t i = 0; i < which.times; ++i) {
    point.error.push_back(error_until(evaluator, started, times_s[i]));
    point.as_given.push_back(error_until(evaluator, usual, times_s[i]));
    point.uncertainty.push_back(uncertainty_until(evaluator, started, times_s[i]));
  }
  return point;
}

Panel panel(const std::vector<Point>& points, const Case& which) {
  Panel panel{.title = fmt::format("{}, h = {} s", which.scenario, which.step_s),
              .x_label = "ERP",
              .y_label = "angle error, rad",
              .log_y = true};
  for (std::size_t i = 0; i < which.times; ++i) {
    for (const bool started : {true, false}) {
      Series series{fmt::format("{}, until {} s", started ? "half-step start" : "as given", times_s[i]),
                    {},
                    {},
                    report::Mark::line_and_points,
                    variant(i),
                    !started};
      for (const Point& point : points) {
        if (point.scenario != which.scenario || point.step_s != which.step_s) continue;
        series.x.push_back(point.erp);
        series.y.push_back((started ? point.error : point.as_given)[i]);
      }
      panel.series.push_back(std::move(series));
    }
  }
  return panel;
}

/// The same gain on the double pendulum when its motion is nearly lost.
void add_late_gain(Laboratory& laboratory, Findings& findings) {
  constexpr double late_s = 5;
  Scenario scenario = laboratory.scenario("double_pendulum");
  scenario.step_s = fine_step_s;
  scenario.duration_s = late_s;
  Evaluator evaluator(scenario);
  const auto error = [&](double erp) {
    OdeSettings settings = half_step_started(scenario.ode);
    settings.erp = erp;
    return error_until(evaluator, evaluator.evaluate(*available("ode-step-double"), settings), late_s);
  };
  const double known = evaluator.reference().uncertainty_q.back();
  findings.add("O2.late_until", measured("end of a longer motion of O2", "s", late_s));
  findings.add("O2.late_gain",
               measured_ratio(fmt::format("angle error until {} s with ERP {} over that with ERP {}, half-step start, "
                                          "double_pendulum, h = {} s",
                                          late_s, default_erp, stiff_erp, fine_step_s),
                              error(default_erp), error(stiff_erp), known, known));
}

}  // namespace

Content half_step_erp(Laboratory& laboratory, Findings& findings) {
  std::vector<Point> points;
  report::Figure figure{.name = "half-step-erp-figure", .columns = 2};
  report::Table table{.name = "half-step-erp",
                      .columns = {"scenario", "h, s", "ERP", "error until 1 s, rad", "error until 1 s as given, rad",
                                  "uncertainty of the reference at 1 s, rad", "error until 3 s, rad",
                                  "error until 3 s as given, rad", "uncertainty of the reference at 3 s, rad"}};
  for (const Case& which : cases) {
    Scenario scenario = laboratory.scenario(which.scenario);
    scenario.step_s = which.step_s;
    scenario.duration_s = times_s[which.times - 1];
    Evaluator evaluator(scenario);
    for (std::size_t i = 0; i < std::size(erps); i += which.stride) {
      points.push_back(measure_one(evaluator, which, erps[i]));
      const Point& point = points.back();
      std::vector<report::Cell> row{point.scenario, point.step_s, point.erp};
      for (std::size_t time = 0; time < std::size(times_s); ++time) {
        for (const auto& values : {point.error, point.as_given, point.uncertainty}) {
          row.push_back(time < values.size() ? report::Cell(values[time])
                                             : report::Missing{"not run so far: it would take ODE some seconds"});
        }
      }
      table.rows.push_back(std::move(row));
    }
    figure.panels.push_back(panel(points, which));
  }
  const auto gain = [&](const char* finding, const Case& which, std::size_t until) {
    const auto find = [&](double erp) {
      return *std::ranges::find_if(points, [&](const Point& point) {
        return point.scenario == which.scenario && point.step_s == which.step_s && point.erp == erp;
      });
    };
    const Point usual = find(default_erp);
    const Point stiff = find(stiff_erp);
    findings.add(
        finding,
        measured_ratio(fmt::format("angle error until {} s with ERP {} over that with ERP {}, half-step "
                                   "start, {}, h = {} s",
                                   times_s[until], default_erp, stiff_erp, which.scenario, which.step_s),
                       usual.error[until], stiff.error[until], usual.uncertainty[until], stiff.uncertainty[until]));
  };
  gain("O2.gain", {"double_pendulum", fine_step_s}, 1);
  gain("O2.gain_chain", {"chain", coarse_step_s}, 0);
  gain("O2.gain_chain_fine", {"chain", fine_step_s}, 0);

  double best_on_chain = NAN;
  double least_error = INFINITY;
  for (const Point& point : points) {
    if (point.scenario != "chain" || point.step_s != coarse_step_s || point.error[0] >= least_error) continue;
    best_on_chain = point.erp;
    least_error = point.error[0];
  }
  add_late_gain(laboratory, findings);
  findings.add("O2.step", measured("step of O2", "ms", 1e3 * fine_step_s));
  findings.add("O2.until", measured("end of O2's motion", "s", times_s[1]));
  findings.add("O2.erp", measured("ERP of O2", "", stiff_erp));
  findings.add("O2.default_erp", measured("ODE's default ERP", "", default_erp));
  Content content;
  content.values = {{"default_erp", default_erp},
                    {"until", times_s[std::size(times_s) - 1]},
                    {"least_erp", erps[0]},
                    {"most_erp", erps[std::size(erps) - 1]},
                    {"best_on_chain", best_on_chain}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
