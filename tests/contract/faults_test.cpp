// What ODE would abort on ends as a diverged run with the rows so far, and the next run is as good as ever.
#include <limits>

#include "odeval/error.hpp"
#include "output/trace_csv.hpp"
#include "tests/check.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

// One iteration of SOR with W near 2 amplifies its residual from step to step (QuickStep: ODE's own assert, or the
// velocities' squares). The direct solver has no such setting; a gravity that overflows stands in for one.
Scenario wild(std::string_view method) {
  Scenario scenario = test::report_scenario("double_pendulum", 10.0, 1e-3);
  scenario.ode.iterations = 1;
  scenario.ode.sor_w = 1.99;
  if (method.starts_with("ode-step")) scenario.gravity = 1e300;
  return scenario;
}

bool all_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

/// Every number of a sample of bodies.
bool is_finite(const ConstSample& sample) {
  const auto body = [](const BodyState& state) {
    return all_finite(state.position) && all_finite(state.rotation) && all_finite(state.velocity) &&
           all_finite(state.spin) && std::isfinite(state.angle);
  };
  return std::ranges::all_of(sample.bodies, body) &&
         std::ranges::all_of(sample.joints, [](const JointState& state) { return all_finite(state.force); }) &&
         std::isfinite(sample.contacts);
}

}  // namespace

int main() {
  const Scenario calm = test::report_scenario("double_pendulum", 1.0, 1e-3);
  for (const char* name : {"ode-step-double", "ode-step-single", "ode-quickstep-double", "ode-quickstep-single"}) {
    if (!test::in_this_build(name)) continue;
    const catalogue::Method& method = catalogue::find_method(name);
    const std::string before = trace_csv(catalogue::Evaluator(calm).evaluate(method).trace);

    const Scenario scenario = wild(name);
    const SampleGrid grid = sample_grid(scenario);
    const auto [outcome, motion] = test::recorded(method.make, scenario, grid);
    std::printf("%s: %ld steps, %zu rows; %s\n", name, outcome.steps, motion.size(), outcome.reason.c_str());
    CHECK(outcome.diverged);
    CHECK(!outcome.reason.empty());
    CHECK(motion.size() >= 1);
    CHECK(motion.size() < static_cast<std::size_t>(grid.rows));
    for (std::size_t k = 0; k < motion.size(); ++k) CHECK(is_finite(motion[k]));

    CHECK(trace_csv(catalogue::Evaluator(calm).evaluate(method).trace) == before);
  }

  // The accurate step refuses what it cannot do, and leaves the world as it was: a run that ended as well.
  Scenario coarse = test::report_scenario("double_pendulum", 10.2, 0.3);
  catalogue::Evaluator evaluator(coarse);
  const auto refused = evaluator.evaluate(catalogue::find_method("ode-rk4-double"));
  std::printf("ode-rk4-double: %ld steps; %s\n", refused.outcome.steps, refused.outcome.reason.c_str());
  CHECK(refused.outcome.diverged);
  CHECK(refused.outcome.reason.find("AccurateStep: the hinge") != std::string::npos);
  CHECK(refused.outcome.reason.find("take a smaller one in the step from t = ") != std::string::npos);
  CHECK_EQUAL(refused.trace.rows(), static_cast<std::size_t>(refused.outcome.steps + 1));
  CHECK(refused.trace.rows() < static_cast<std::size_t>(evaluator.grid().rows));
  CHECK_EQUAL(evaluator.measure(refused, 10)[quantity::max_error_q].value_or(0),
              std::numeric_limits<double>::infinity());

  // A body ODE would abort on is refused with a message. The reader of scenarios never lets one through.
  Scenario massless = calm;
  massless.mechanism.bodies[0].mass_kg = 0;
  CHECK_THROWS(catalogue::find_method("ode-step-double").make(massless, sample_grid(massless)), MachineError, "mass");
  return test::verdict();
}
