// What QuickStep loses beside dWorldStep, and by which of its settings: claim C2.
#include <fmt/format.h>

#include <algorithm>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "experiments/quickstep_runs.hpp"

namespace odeval::experiments {
namespace {

using report::Panel;

constexpr int iterations[] = {1, 2, 3, 5, 10, 20, 50, 100, 200};
constexpr double until_s = 3;
constexpr int much_better_percent = 10;

}  // namespace

Content quickstep(Laboratory& laboratory, Findings& findings) {
  Scenario scenario = laboratory.scenario("double_pendulum");
  scenario.duration_s = until_s;
  catalogue::Evaluator evaluator(scenario);
  const QuickRuns runs = quickstep_runs(evaluator, iterations, until_s);
  findings.add("C2.error_ratio",
               runs.error_ratio(fmt::format("angle error of QuickStep over dWorldStep's until {} s, {} iterations",
                                            until_s, scenario.ode.iterations)));
  report::Table table = runs.table("quickstep");
  const auto count = [](const QuickRun& run) { return static_cast<double>(run.settings.iterations); };
  Panel errors = runs.panel("iterations", count, "angle error, rad", [](const QuickRun& run) { return run.error; });
  Panel gaps = runs.panel("iterations", count, "largest gap, m", [](const QuickRun& run) { return run.gap; });
  errors.series.push_back(direct_level(runs, runs.direct.error));
  gaps.series.push_back(direct_level(runs, runs.direct.gap));

  report::Figure figure{.name = "quickstep-figure", .columns = 2};
  figure.panels = {std::move(errors), std::move(gaps)};
  const auto better = std::ranges::count_if(runs.iterative, [&](const QuickRun& run) {
    return run.error < (1 - much_better_percent / 100.0) * runs.direct.error;
  });
  Content content;
  content.values = {{"step", scenario.step_s},
                    {"until", until_s},
                    {"default_iterations", OdeSettings{}.iterations},
                    {"default_sor_w", OdeSettings{}.sor_w},
                    {"runs", runs.iterative.size()},
                    {"better", better > 0 ? std::to_string(better) : ""},
                    {"much_better", much_better_percent},
                    {"known", reference_known(evaluator, {until_s})}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
