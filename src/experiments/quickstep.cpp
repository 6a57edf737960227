// What QuickStep loses beside dWorldStep, and by which of its settings: claim C2.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Panel;

constexpr int iterations[] = {1, 2, 3, 5, 10, 20, 50, 100, 200};
constexpr double over_relaxations[] = {1.0, 1.3, 1.6};
constexpr double until_s = 3;
constexpr std::string_view big_matrix = "ode-step-double";
constexpr std::string_view iterative = "ode-quickstep-double";

Cell finite(double number) {
  if (std::isfinite(number)) return number;
  return report::Missing{"the run blew up"};
}

}  // namespace

Section quickstep(Laboratory& laboratory, Findings& findings) {
  Evaluator& file = laboratory.evaluator("double_pendulum");
  const Evaluation& step = *laboratory.run("double_pendulum", big_matrix);
  const Evaluation& quick = *laboratory.run("double_pendulum", iterative);
  const double error = error_until(file, step, until_s);
  const double doubt = uncertainty_until(file, step, until_s);
  findings.add("C2.error_ratio",
               measured_ratio(fmt::format("angle error of QuickStep over dWorldStep's until {} s, {} iterations",
                                          until_s, file.scenario().ode.iterations),
                              error_until(file, quick, until_s), error, doubt, doubt));

  Scenario scenario = file.scenario();
  scenario.duration_s = until_s;
  Evaluator evaluator(scenario);
  const Metrics of_step = file.measure(step, until_s);
  report::Table table{
      "quickstep",
      "QuickStep beside dWorldStep on two links",
      {"method", "iterations", "over-relaxation", fmt::format("angle error until {} s, rad", until_s),
       "error over dWorldStep's", fmt::format("largest gap until {} s, m", until_s)},
      {{std::string(big_matrix), std::string("direct"), std::string("-"), error, 1.0, *of_step.max_gap}},
      "The cost of a step grows with the iterations; what it is on this machine stands in the timings." +
          reference_known(evaluator, {until_s})};
  Panel errors{.x_label = "iterations", .y_label = "angle error, rad", .log_x = true, .log_y = true};
  Panel gaps{.x_label = "iterations", .y_label = "largest gap, m", .log_x = true, .log_y = true};
  for (const double over_relaxation : over_relaxations) {
    report::Series of_error{fmt::format("over-relaxation {}", over_relaxation), {}, {}, report::Mark::line_and_points};
    report::Series of_gap = of_error;
    for (const int count : iterations) {
      OdeSettings settings = scenario.ode;
      settings.iterations = count;
      settings.sor_w = over_relaxation;
      const Evaluation run = evaluator.evaluate(*available(iterative), settings);
      const Metrics metrics = evaluator.measure(run, until_s);
      const double run_error = metrics.max_error_q.value_or(NAN);
      table.rows.push_back({std::string(iterative), static_cast<double>(count), over_relaxation, finite(run_error),
                            finite(run_error / error), finite(metrics.max_gap.value_or(NAN))});
      of_error.x.push_back(count);
      of_error.y.push_back(run_error);
      of_gap.x.push_back(count);
      of_gap.y.push_back(metrics.max_gap.value_or(NAN));
    }
    errors.series.push_back(std::move(of_error));
    gaps.series.push_back(std::move(of_gap));
  }
  const Column ends{static_cast<double>(iterations[0]), static_cast<double>(std::end(iterations)[-1])};
  errors.series.push_back(curve("dWorldStep", ends, {error, error}, guide_colour, true));
  gaps.series.push_back(curve("dWorldStep", ends, {*of_step.max_gap, *of_step.max_gap}, guide_colour, true));

  report::Figure figure{"quickstep-figure", "Error and gap over the iterations", {}, {}, 2};
  figure.panels = {std::move(errors), std::move(gaps)};
  figure.caption =
      "Where a curve lies on the dashed line, the joints are solved well enough and the step size alone makes the "
      "error.";
  Section section{"quickstep", "What QuickStep loses", {}};
  section.blocks.emplace_back(report::Text{fmt::format(
      "QuickStep solves the joints by iteration where dWorldStep factorises a matrix; the rest of the step is the "
      "same. "
      "The report calls it a lot less accurate. Measured on the double pendulum at h = {} s, over the number of "
      "iterations (ODE's default is 20) and the over-relaxation (default 1.3). This is two links: iterations "
      "spread along a chain, so a longer one needs more of them.",
      scenario.step_s)});
  section.blocks.emplace_back(std::move(figure));
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
