// What QuickStep loses beside dWorldStep, and by which of its settings: claim C2.
#include <fmt/format.h>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "experiments/quickstep_runs.hpp"

namespace odeval::experiments {
namespace {

using report::Panel;

constexpr int iterations[] = {1, 2, 3, 5, 10, 20, 50, 100, 200};
constexpr double until_s = 3;

}  // namespace

Section quickstep(Laboratory& laboratory, Findings& findings) {
  Scenario scenario = laboratory.scenario("double_pendulum");
  scenario.duration_s = until_s;
  catalogue::Evaluator evaluator(scenario);
  const QuickRuns runs = quickstep_runs(evaluator, iterations, until_s);
  findings.add("C2.error_ratio",
               runs.error_ratio(fmt::format("angle error of QuickStep over dWorldStep's until {} s, {} iterations",
                                            until_s, scenario.ode.iterations)));
  report::Table table =
      runs.table("quickstep", fmt::format("QuickStep beside dWorldStep on two links until {} s", until_s),
                 "Times are of this machine, medians of runs in turn. Few iterations at 1.6 come out better than "
                 "dWorldStep by chance of this motion: what they leave unsolved works against the error of the step "
                 "where that is largest." +
                     reference_known(evaluator, {until_s}));
  const auto count = [](const QuickRun& run) { return static_cast<double>(run.settings.iterations); };
  Panel errors = runs.panel("iterations", count, "angle error, rad", [](const QuickRun& run) { return run.error; });
  Panel gaps = runs.panel("iterations", count, "largest gap, m", [](const QuickRun& run) { return run.gap; });
  errors.series.push_back(direct_level(runs, runs.direct.error));
  gaps.series.push_back(direct_level(runs, runs.direct.gap));

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
