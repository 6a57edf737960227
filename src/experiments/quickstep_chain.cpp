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

Content quickstep_chain(Laboratory& laboratory, Findings& findings) {
  const Scenario scenario = chain_of(laboratory.scenario("chain"), links, until_s);
  catalogue::Evaluator evaluator(scenario);
  const QuickRuns runs = quickstep_runs(evaluator, iterations, until_s);
  findings.add("C2.chain_error_ratio",
               runs.error_ratio(fmt::format("the same on a chain of {} links until {} s", links, until_s)));
  findings.add("C2.chain_links", measured("links of the chain of C2", "", static_cast<double>(links)));
  findings.add("C2.iterations", measured("iterations of QuickStep in C2", "", scenario.ode.iterations));
  report::Table table = runs.table("quickstep-chain");
  const auto error = [](const QuickRun& run) { return run.error; };
  Panel errors = runs.panel(
      "iterations", [](const QuickRun& run) { return static_cast<double>(run.settings.iterations); },
      "angle error, rad", error);
  Panel costs = runs.panel(
      "CPU time a step, s", [](const QuickRun& run) { return run.a_step_s; }, "angle error, rad", error);
  errors.series.push_back(direct_level(runs, runs.direct.error));
  costs.series.push_back(
      {"dWorldStep", {runs.direct.a_step_s}, {runs.direct.error}, report::Mark::points, colour_of("ode-step-double")});

  report::Figure figure{.name = "quickstep-chain-figure", .columns = 2};
  figure.panels = {std::move(errors), std::move(costs)};
  Content content;
  content.values = {{"links", links},
                    {"step", scenario.step_s},
                    {"until", until_s},
                    {"rows_apart", *scenario.sample_s},
                    {"known", reference_known(evaluator, {until_s})}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
