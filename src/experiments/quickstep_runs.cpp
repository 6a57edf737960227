#include "experiments/quickstep_runs.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "catalogue/timing.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;

constexpr double over_relaxations[] = {1.0, 1.3, 1.6};
constexpr long timed_steps = 100;
constexpr int timed_rounds = 5;
constexpr std::string_view big_matrix = "ode-step-double";
constexpr std::string_view iterative_method = "ode-quickstep-double";

QuickRun quick_run(Evaluator& evaluator, std::string_view method, const OdeSettings& settings, double until_s) {
  const Metrics metrics = evaluator.measure(evaluator.evaluate(*available(method), settings), until_s);
  return {settings, metrics[quantity::max_error_q].value_or(NAN), metrics[quantity::max_gap].value_or(NAN),
          metrics[quantity::reference_uncertainty].value_or(NAN)};
}

/// All of them in turn, so that what else the machine does falls on all alike.
void time_them(QuickRuns& runs, Scenario scenario) {
  scenario.sample_s.reset();
  scenario.duration_s = static_cast<double>(timed_steps) * scenario.step_s;
  std::vector<QuickRun*> which{&runs.direct, &runs.as_set};
  for (QuickRun& run : runs.iterative) which.push_back(&run);
  std::vector<std::unique_ptr<const Evaluator>> evaluators;
  std::vector<catalogue::TimedRun> timed;
  for (const QuickRun* run : which) {
    scenario.ode = run->settings;
    evaluators.push_back(std::make_unique<const Evaluator>(scenario));
    const std::string_view method = run == &runs.direct ? big_matrix : iterative_method;
    timed.push_back({evaluators.back().get(), available(method), 0, 0, {}});
  }
  catalogue::time_in_turns(timed, timed_rounds);
  for (std::size_t i = 0; i < which.size(); ++i) which[i]->a_step_s = timed[i].median_s() / timed_steps;
}

}  // namespace

QuickRuns quickstep_runs(Evaluator& evaluator, std::span<const int> iterations, double until_s) {
  OdeSettings settings = evaluator.scenario().ode;
  QuickRuns runs{quick_run(evaluator, big_matrix, settings, until_s),
                 quick_run(evaluator, iterative_method, settings, until_s),
                 {}};
  for (const double over_relaxation : over_relaxations) {
    for (const int count : iterations) {
      settings.iterations = count;
      settings.sor_w = over_relaxation;
      runs.iterative.push_back(quick_run(evaluator, iterative_method, settings, until_s));
    }
  }
  time_them(runs, evaluator.scenario());
  return runs;
}

report::Finding QuickRuns::error_ratio(std::string meaning) const {
  return measured_ratio(std::move(meaning), as_set.error, direct.error, as_set.uncertainty, direct.uncertainty);
}

report::Table QuickRuns::table(std::string name) const {
  report::Table table{.name = std::move(name),
                      .columns = {"method", "iterations", "over-relaxation", "angle error, rad",
                                  "error over dWorldStep's", "largest gap, m", "CPU time a step, s"},
                      .rows = {{std::string(big_matrix), std::string("direct"), std::string("-"), direct.error, 1.0,
                                direct.gap, direct.a_step_s}}};
  for (const QuickRun& run : iterative) {
    table.rows.push_back({std::string(iterative_method), static_cast<double>(run.settings.iterations),
                          run.settings.sor_w, finite_cell(run.error), finite_cell(run.error / direct.error),
                          finite_cell(run.gap), run.a_step_s});
  }
  return table;
}

report::Panel QuickRuns::panel(std::string x_label, const std::function<double(const QuickRun&)>& x,
                               std::string y_label, const std::function<double(const QuickRun&)>& y) const {
  report::Panel panel{.x_label = std::move(x_label), .y_label = std::move(y_label), .log_x = true, .log_y = true};
  std::size_t number = 0;
  for (const double over_relaxation : over_relaxations) {
    report::Series series{
        fmt::format("over-relaxation {}", over_relaxation), {}, {}, report::Mark::line_and_points, variant(number++)};
    for (const QuickRun& run : iterative) {
      if (run.settings.sor_w != over_relaxation) continue;
      series.x.push_back(x(run));
      series.y.push_back(y(run));
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

report::Series direct_level(const QuickRuns& runs, double level) {
  const Column ends{static_cast<double>(runs.iterative.front().settings.iterations),
                    static_cast<double>(runs.iterative.back().settings.iterations)};
  return curve("dWorldStep", ends, {level, level}, colour_of("ode-step-double"), true);
}

}  // namespace odeval::experiments
