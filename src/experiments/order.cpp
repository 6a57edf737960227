// The observed order of every method with a fixed step: claim C1.
#include "measure/order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

constexpr double until_s = 1;
constexpr double steps_s[] = {2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4};
constexpr double lost_rad = 0.1;

}  // namespace

Section order(Laboratory& laboratory, Findings& findings) {
  report::Table table{
      "order",
      "Observed order on the double pendulum, until 1 s",
      {"method", "order by design", "observed", "± (95 %)", "least h, s", "largest h, s", "points"},
      {},
      "Slope of log error over log h. Points count whose error is at least ten times what the reference "
      "and rounding leave open, and below 0.1 rad."};
  report::Panel panel{.x_label = "h, s", .y_label = "largest angle error until 1 s, rad", .log_x = true, .log_y = true};
  const Scenario& file = laboratory.scenario("double_pendulum");
  double worst = 0;
  double worst_doubt = 0;
  std::string missing;
  for (const catalogue::Method& method : catalogue::methods()) {
    if (method.order == 0 || !method.claims(*file.problem)) continue;
    const std::string name(method.name);
    if (method.make == nullptr) {
      table.rows.push_back({name, static_cast<double>(method.order),
                            report::Missing{std::string(catalogue::why_missing)}, report::Missing{"-"},
                            report::Missing{"-"}, report::Missing{"-"}, report::Missing{"-"}});
      continue;
    }
    const double epsilon = name.ends_with("-single") ? 6e-8 : 1.1e-16;
    std::vector<ErrorPoint> points;
    report::Series series{name, {}, {}, report::Mark::line_and_points, colour_of(name), false};
    for (const double h : steps_s) {
      Scenario scenario = file;
      scenario.step_s = h;
      scenario.duration_s = until_s;
      catalogue::Evaluator evaluator(scenario);
      const catalogue::Evaluation run = evaluator.evaluate(method);
      const double error = error_until(evaluator, run, until_s);
      const double doubt = uncertainty_until(evaluator, run, until_s) + rounding_doubt(epsilon, run.outcome.steps);
      points.push_back({h, error, doubt});
      series.x.push_back(h);
      series.y.push_back(error);
    }
    panel.series.push_back(std::move(series));
    const auto observed = observed_order(points, lost_rad);
    const std::string meaning = "observed order of " + name;
    if (!observed) {
      const char* const why = "fewer than three points stand clear of the reference and of rounding";
      findings.add("order." + name, unavailable(meaning, "", why));
      table.rows.push_back({name, static_cast<double>(method.order), report::Missing{why}, report::Missing{"-"},
                            report::Missing{"-"}, report::Missing{"-"}, report::Missing{"-"}});
      continue;
    }
    findings.add("order." + name, measured(meaning, "", observed->order, observed->half_width));
    table.rows.push_back({name, static_cast<double>(method.order), observed->order, observed->half_width,
                          observed->from, observed->to, static_cast<double>(observed->points)});
    if ((name == "ode-step-double" || name == "ode-quickstep-double") && std::fabs(observed->order - 1) >= worst) {
      worst = std::fabs(observed->order - 1);
      worst_doubt = observed->half_width;
    }
  }
  findings.add("C1.order_off", measured("distance of ODE's observed order from 1, the larger of both steppers", "",
                                        worst, worst_doubt));

  Section section{"order", "Observed order of every method", {}};
  section.blocks.emplace_back(report::Text{
      "Each method with a fixed step runs the first second of the double pendulum at five steps, each half the one "
      "before. A method of order p divides its error by 2 to the p whenever the step is halved."});
  section.blocks.emplace_back(
      report::Figure{"order-lines", "Error over step", "The steeper, the higher the order.", {std::move(panel)}, 1});
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
