// "Should I switch?" where something hits something: the step that it tells of a way keeps the error at other steps
// nearby, of which it tried none, and what keeps it by luck is not told.
#include <algorithm>
#include <cmath>

#include "catalogue/evaluation.hpp"
#include "catalogue/keeping.hpp"
#include "catalogue/paths.hpp"
#include "experiments/experiment.hpp"
#include "experiments/should_i_switch.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"

using namespace odeval;
using namespace odeval::experiments::engines;

namespace {

constexpr double rows_s = 0.02;

const Stage& ball() {
  for (const Task& task : tasks()) {
    if (task.name == "impacts") return task.stages.front();
  }
  throw MachineError("no task with impacts");
}

/// The error at a step, in rows that it fits and with their own reference.
double error_of(const Stage& stage, const Scenario& file, const Way& way, double step_s, double part) {
  Scenario scenario = file;
  scenario.step_s = part * step_s;
  scenario.sample_s = part * rows_s;
  way.set(scenario);
  catalogue::Evaluator evaluator(scenario);
  return *evaluator.measure(evaluator.evaluate(*way.method), scenario.duration_s)[stage.quantity];
}

/// Of steps within 3 % of one, evenly spaced, how many break the budget.
int breaking(const Stage& stage, const Scenario& file, const Way& way, double step_s) {
  constexpr int steps = 30;
  int broken = 0;
  for (int k = 0; k < steps; ++k) {
    const double percent = catalogue::farthest_percent * (2 * (k + 0.5) / steps - 1);
    if (!(error_of(stage, file, way, step_s, catalogue::moved(1, percent)) <= stage.budget)) ++broken;
  }
  return broken;
}

std::size_t half_step_of(const Result& result) {
  const auto found =
      std::ranges::find_if(result.ways, [](const Way& way) { return way.settings.starts_with("half-step"); });
  return static_cast<std::size_t>(found - result.ways.begin());
}

}  // namespace

int main() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  experiments::Laboratory laboratory([&](const std::string& name) {
    return read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names);
  });
  const Stage& stage = ball();
  const Scenario file = stage.of(laboratory);
  const Result result = result_of(stage, laboratory);
  int held = 0;
  for (std::size_t i = 0; i < result.ways.size(); ++i) {
    const Way& way = result.ways[i];
    if (!result.tried[i].keeps || way.method->order == 0) continue;
    CHECK_EQUAL(breaking(stage, file, way, result.tried[i].setting), 0);
    ++held;
  }
  CHECK(held >= 3);  // ODE with each stepper and the accurate step at least
  // The ball's impacts at 5 ms: the run itself keeps 0.02 m, half of the steps nearby do not.
  const Way& plain = result.ways.front();
  const double lucky_s = 5e-3;
  CHECK(error_of(stage, file, plain, lucky_s, 1) <= stage.budget);
  CHECK(breaking(stage, file, plain, lucky_s) > 0);
  CHECK(result.tried.front().setting < lucky_s);
  // At equal step the largest error of the steps nearby is told: ERP 0.8 and the half-step start do well at 1 ms
  // itself.
  for (const std::size_t i : {std::size_t{0}, half_step_of(result)}) {
    double largest = error_of(stage, file, result.ways[i], equal_step_s, 1);
    for (const double percent : catalogue::nearby_percents) {
      largest = std::fmax(largest, error_of(stage, file, result.ways[i], equal_step_s, catalogue::moved(1, percent)));
    }
    CHECK_NEAR(result.tried[i].error_at_ms.error, largest, 1e-12);
    CHECK(largest > 1.05 * error_of(stage, file, result.ways[i], equal_step_s, 1));
  }
  return test::verdict();
}
