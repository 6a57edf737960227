// QuickStep over its iterations and over-relaxation: each number is that of the settings it stands beside.
#include "experiments/quickstep_runs.hpp"

#include <set>

#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using catalogue::Evaluator;
using experiments::QuickRun;
using experiments::QuickRuns;

constexpr int iterations[] = {1, 3, 20};
constexpr double until_s = 0.2;

// Runs are deterministic, so the same run once more gives the same bits.
void check_run(Evaluator& evaluator, const QuickRun& run, std::string_view method, const OdeSettings& settings) {
  CHECK_EQUAL(run.settings.iterations, settings.iterations);
  CHECK_EQUAL(run.settings.sor_w, settings.sor_w);
  const Metrics metrics = evaluator.measure(evaluator.evaluate(catalogue::find_method(method), settings), until_s);
  CHECK_EQUAL(run.error, metrics[quantity::max_error_q].value());
  CHECK_EQUAL(run.gap, metrics[quantity::max_gap].value());
  CHECK_EQUAL(run.uncertainty, metrics[quantity::reference_uncertainty].value());
  CHECK(run.a_step_s > 0 && run.a_step_s < 0.1);  // some microseconds, not those of all 100 steps that are timed
}

double number(const report::Cell& cell) { return std::get<double>(cell); }

}  // namespace

int main() {
  Evaluator evaluator(test::report_scenario("double_pendulum", until_s, 1e-3));
  const OdeSettings as_set = evaluator.scenario().ode;
  const QuickRuns runs = experiments::quickstep_runs(evaluator, iterations, until_s);
  check_run(evaluator, runs.direct, "ode-step-double", as_set);
  check_run(evaluator, runs.as_set, "ode-quickstep-double", as_set);

  // Every pair of settings once, and none without effect.
  CHECK_EQUAL(runs.iterative.size(), 9u);
  std::set<double> errors;
  std::size_t next = 0;
  for (const double over_relaxation : {1.0, 1.3, 1.6}) {
    for (const int count : iterations) {
      OdeSettings settings = as_set;
      settings.iterations = count;
      settings.sor_w = over_relaxation;
      check_run(evaluator, runs.iterative.at(next), "ode-quickstep-double", settings);
      errors.insert(runs.iterative.at(next++).error);
    }
  }
  CHECK_EQUAL(errors.size(), 9u);

  const report::Table table = runs.table("name");
  CHECK_EQUAL(table.rows.size(), 10u);
  CHECK_EQUAL(number(table.rows[0][3]), runs.direct.error);
  CHECK_EQUAL(number(table.rows[0][5]), runs.direct.gap);
  const QuickRun& second = runs.iterative[1];
  CHECK_EQUAL(number(table.rows[2][1]), 3.0);
  CHECK_EQUAL(number(table.rows[2][2]), 1.0);
  CHECK_EQUAL(number(table.rows[2][3]), second.error);
  CHECK_EQUAL(number(table.rows[2][4]), second.error / runs.direct.error);
  CHECK_EQUAL(number(table.rows[2][5]), second.gap);
  CHECK_EQUAL(number(table.rows[2][6]), second.a_step_s);

  const auto count = [](const QuickRun& run) { return static_cast<double>(run.settings.iterations); };
  const report::Panel panel = runs.panel("x", count, "y", [](const QuickRun& run) { return run.gap; });
  CHECK_EQUAL(panel.series.size(), 3u);
  CHECK_EQUAL(panel.series[2].label, "over-relaxation 1.6");
  CHECK_EQUAL(panel.series[2].x.at(1), 3.0);
  CHECK_EQUAL(panel.series[2].y.at(1), runs.iterative[7].gap);
  return test::verdict();
}
