// What QuickStep loses on a long chain, over its iterations and over-relaxation, and what they cost: claim C2.
#include <fmt/format.h>

#include <cmath>

#include "catalogue/timing.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Panel;

constexpr std::size_t links = 32;
constexpr int iterations[] = {1, 3, 10, 20, 50, 200};
constexpr double over_relaxations[] = {1.0, 1.3, 1.6};
constexpr double until_s = 1;
constexpr std::string_view big_matrix = "ode-step-double";
constexpr std::string_view iterative = "ode-quickstep-double";

Scenario long_chain(const Scenario& file) {
  Scenario scenario = file;
  scenario.n = static_cast<int>(links);
  scenario.links.resize(links, file.links.front());
  scenario.q0.resize(links, 0.0);
  scenario.qd0.resize(links, 0.0);
  scenario.duration_s = until_s;
  scenario.sample_s = 0.02;
  return scenario;
}

double cost_a_step(const Evaluation& run) { return run.cpu_s / static_cast<double>(run.outcome.steps); }

Cell finite(double number) {
  if (std::isfinite(number)) return number;
  return report::Missing{"the run blew up"};
}

}  // namespace

Section quickstep_chain(Laboratory& laboratory, Findings& findings) {
  const Scenario scenario = long_chain(laboratory.scenario("chain"));
  Evaluator evaluator(scenario);
  const Evaluation step = evaluator.evaluate(*available(big_matrix));
  const Metrics of_step = evaluator.measure(step, until_s);
  const double error = error_until(evaluator, step, until_s);
  const double doubt = uncertainty_until(evaluator, step, until_s);
  report::Table table{
      "quickstep-chain",
      fmt::format("QuickStep beside dWorldStep on {} links until {} s, h = {} s", links, until_s, scenario.step_s),
      {"method", "iterations", "over-relaxation", "angle error, rad", "error over dWorldStep's", "largest gap, m",
       "CPU time a step, s"},
      {{std::string(big_matrix), std::string("direct"), std::string("-"), error, 1.0, *of_step.max_gap,
        cost_a_step(step)}},
      fmt::format("Errors and gaps are the largest at rows {} s apart, and a gap may be wider between them. The "
                  "reference knows the angles to {} rad. Times are of this machine, one run each.",
                  *scenario.sample_s, shown(doubt))};
  Panel errors{.x_label = "iterations", .y_label = "angle error, rad", .log_x = true, .log_y = true};
  Panel costs{.x_label = "CPU time a step, s", .y_label = "angle error, rad", .log_x = true, .log_y = true};
  for (const double over_relaxation : over_relaxations) {
    report::Series of_error{fmt::format("over-relaxation {}", over_relaxation), {}, {}, report::Mark::line_and_points};
    report::Series of_cost = of_error;
    for (const int count : iterations) {
      OdeSettings settings = scenario.ode;
      settings.iterations = count;
      settings.sor_w = over_relaxation;
      const Evaluation run = evaluator.evaluate(*available(iterative), settings);
      const Metrics metrics = evaluator.measure(run, until_s);
      const double run_error = metrics.max_error_q.value_or(NAN);
      table.rows.push_back({std::string(iterative), static_cast<double>(count), over_relaxation, finite(run_error),
                            finite(run_error / error), finite(metrics.max_gap.value_or(NAN)), cost_a_step(run)});
      of_error.x.push_back(count);
      of_error.y.push_back(run_error);
      of_cost.x.push_back(cost_a_step(run));
      of_cost.y.push_back(run_error);
      if (count == scenario.ode.iterations && over_relaxation == scenario.ode.sor_w) {
        findings.add("C2.chain_error_ratio",
                     measured_ratio(fmt::format("the same on a chain of {} links until {} s", links, until_s),
                                    run_error, error, doubt, doubt));
      }
    }
    errors.series.push_back(std::move(of_error));
    costs.series.push_back(std::move(of_cost));
  }
  const Column ends{static_cast<double>(iterations[0]), static_cast<double>(std::end(iterations)[-1])};
  errors.series.push_back(curve("dWorldStep", ends, {error, error}, guide_colour, true));
  costs.series.push_back({"dWorldStep", {cost_a_step(step)}, {error}, report::Mark::points, colour_of(big_matrix)});

  Section section{"quickstep-chain", "QuickStep on a long chain", {}};
  section.blocks.emplace_back(report::Text{fmt::format(
      "An iteration passes what one joint knows on to its neighbours, so a chain of {} links needs more of them than "
      "two links do. Where the curve of an over-relaxation ends on the dashed line, more iterations no longer help.",
      links)});
  report::Figure figure{"quickstep-chain-figure", "Error over iterations, and over what they cost", {}, {}, 2};
  figure.caption =
      "Right of and below a point is dearer and better. The point of dWorldStep is what QuickStep has to "
      "stay left of.";
  figure.panels = {std::move(errors), std::move(costs)};
  section.blocks.emplace_back(std::move(figure));
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
