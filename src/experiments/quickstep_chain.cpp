// What QuickStep loses on a long chain, over its iterations and over-relaxation, and what they cost: claim C2.
#include <fmt/format.h>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "experiments/quickstep_runs.hpp"

namespace odeval::experiments {
namespace {

using report::Panel;

constexpr std::size_t links = 32;
constexpr int iterations[] = {1, 3, 10, 20, 50, 200};
constexpr double until_s = 1;

}  // namespace

Section quickstep_chain(Laboratory& laboratory, Findings& findings) {
  const Scenario scenario = chain_of(laboratory.scenario("chain"), links, until_s);
  catalogue::Evaluator evaluator(scenario);
  const QuickRuns runs = quickstep_runs(evaluator, iterations, until_s);
  findings.add("C2.chain_error_ratio",
               runs.error_ratio(fmt::format("the same on a chain of {} links until {} s", links, until_s)));
  report::Table table = runs.table(
      "quickstep-chain",
      fmt::format("QuickStep beside dWorldStep on {} links until {} s, h = {} s", links, until_s, scenario.step_s),
      fmt::format("Errors and gaps are the largest at rows {} s apart, and a gap may be wider between them. Times are "
                  "of this machine, medians of runs in turn.",
                  *scenario.sample_s) +
          reference_known(evaluator, {until_s}));
  const auto error = [](const QuickRun& run) { return run.error; };
  Panel errors = runs.panel(
      "iterations", [](const QuickRun& run) { return static_cast<double>(run.settings.iterations); },
      "angle error, rad", error);
  Panel costs = runs.panel(
      "CPU time a step, s", [](const QuickRun& run) { return run.a_step_s; }, "angle error, rad", error);
  errors.series.push_back(direct_level(runs, runs.direct.error));
  costs.series.push_back(
      {"dWorldStep", {runs.direct.a_step_s}, {runs.direct.error}, report::Mark::points, guide_colour});

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
