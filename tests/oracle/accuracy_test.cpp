// The cheapest setting that keeps an error: it keeps it, the next coarser does not, and what cannot be kept is said.
#include "catalogue/accuracy.hpp"

#include "catalogue/table_5_2.hpp"
#include "catalogue/timing.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using catalogue::Accuracy;
using catalogue::find_method;
using catalogue::Knob;
using catalogue::Search;

constexpr long plenty = 1'000'000;

Scenario report_pendulum() { return test::report_scenario("double_pendulum", 10, 1e-3); }

void errors_are_those_of_a_run_of_its_own() {
  const Accuracy accuracy(report_pendulum(), 1);
  CHECK_EQUAL(accuracy.row_spacing_s(), 0.05);
  const catalogue::Trial trial = accuracy.try_setting(find_method("ode-step-double"), 1e-3);
  CHECK_EQUAL(trial.steps, 1000L);
  Scenario alone = test::report_scenario("double_pendulum", 1, 1e-3);
  alone.sample_s = 0.05;
  catalogue::Evaluator evaluator(alone);
  const auto metrics = evaluator.measure(evaluator.evaluate(find_method("ode-step-double")), 1);
  CHECK_NEAR(trial.error, *metrics.max_error_q, 1e-13);  // h = 0.05 / 50 is 0.001 but for a rounding
  CHECK_EQUAL(trial.doubt, *metrics.reference_uncertainty);
  CHECK_NEAR(Accuracy(report_pendulum(), 0.99).row_spacing_s(), 0.0495, 1e-15);
  CHECK_NEAR(accuracy.fitting_step(4e-3), 0.05 / 13, 1e-15);  // 12.5 steps a row, rounded away from zero
  CHECK_EQUAL(accuracy.fitting_step(1), 0.05);
}

// First order: the step for half the error is about half. The search stops at 2 %, so do not ask for more than 5 %.
void steps_are_the_largest() {
  const Accuracy accuracy(report_pendulum(), 1);
  for (const char* name : {"ode-step-double", "lagrange-symplectic-euler", "lagrange-rk4"}) {
    const auto& method = find_method(name);
    for (const double wanted : {1e-3, 5e-4}) {
      const Search search = accuracy.cheapest(method, wanted, plenty);
      std::printf("%s: h = %g, %g rad, %ld steps\n", name, search.trial.setting, search.trial.error,
                  search.trial.steps);
      CHECK(search.reached);
      CHECK(search.trial.keeps(wanted));
      const double a_row = std::round(0.05 / search.trial.setting);
      CHECK_NEAR(search.trial.setting, 0.05 / a_row, 1e-15);
      const double coarser = std::floor(a_row - std::max(1.0, 0.04 * a_row));
      if (coarser >= 1) CHECK(!accuracy.try_setting(method, 0.05 / coarser).keeps(wanted));
    }
  }
  const auto step = [&](double error) {
    return accuracy.cheapest(find_method("ode-step-double"), error, plenty).trial.setting;
  };
  CHECK_BETWEEN(step(1e-3) / step(5e-4), 1.9, 2.1);
}

void tolerances_are_the_loosest() {
  const Accuracy accuracy(report_pendulum(), 1);
  for (const char* name : {"lagrange-ode45", "lagrange-cvode"}) {
    const auto& method = find_method(name);
    CHECK(catalogue::knob_of(method) == Knob::rtol);
    const Search search = accuracy.cheapest(method, 1e-6, plenty);
    std::printf("%s: rtol = %g, %g rad\n", name, search.trial.setting, search.trial.error);
    CHECK(search.reached && search.trial.keeps(1e-6));
    CHECK(search.trial.evaluations > 0);
    // One rung of the ladder is 15 %. CVODE's error does not fall evenly: a decade is sure.
    const double looser = name == std::string("lagrange-ode45") ? 1.156 : 10;
    CHECK(!accuracy.try_setting(method, search.trial.setting * looser).keeps(1e-6));
    const Scenario scenario = accuracy.at(method, 1e-5).scenario();
    CHECK_EQUAL(*scenario.rtol, 1e-5);
    CHECK_NEAR(*scenario.atol, 1e-8, 1e-20);
  }
}

void what_is_not_reached_is_said() {
  const Accuracy accuracy(report_pendulum(), 1);
  const Search short_of_steps = accuracy.cheapest(find_method("lagrange-euler"), 1e-6, 10000);
  CHECK(!short_of_steps.reached);
  CHECK_EQUAL(short_of_steps.why_not, "it would take more than 10000 steps");
  CHECK_EQUAL(short_of_steps.trial.steps, 5120L);  // 20 rows of 256: the next doubling is 10240
  CHECK(short_of_steps.trial.error < 0.1);
  if (test::in_this_build("ode-step-single")) {
    const Search rounded = accuracy.cheapest(find_method("ode-step-single"), 1e-6, plenty);
    CHECK(!rounded.reached);
    CHECK_EQUAL(rounded.why_not, "the error no longer falls");
    CHECK(rounded.trial.steps < plenty / 4);
  }
  const Search below_reference = accuracy.cheapest(find_method("lagrange-ode45"), accuracy.doubt() / 2, plenty);
  CHECK(!below_reference.reached && !below_reference.why_not.empty());
  const Accuracy single(test::report_scenario("single_pendulum", 2, 1e-3), 1);
  CHECK(single.cheapest(find_method("analytic"), 1e-6, plenty).reached);
}

void timing_takes_turns() {
  const catalogue::Evaluator evaluator(test::report_scenario("double_pendulum", 0.1, 1e-3));
  std::vector<catalogue::TimedRun> runs;
  for (const char* name : {"lagrange-euler", "ode-step-double"}) {
    runs.push_back({&evaluator, &find_method(name), 0, 0, {}});
  }
  std::vector<int> begun;
  catalogue::time_in_turns(runs, 3, [&](int round) { begun.push_back(round); });
  CHECK(begun == (std::vector{0, 1, 2, 3}));
  for (const auto& run : runs) {
    CHECK_EQUAL(run.seconds.size(), std::size_t{3});
    CHECK_EQUAL(run.steps, 100L);
    CHECK(run.batch >= 1 && run.median_s() > 0 && run.mad_s() >= 0);
  }
  CHECK_EQUAL(runs[0].evaluations, 100L);
}

void the_reports_pendulum_is_known() {
  CHECK(catalogue::is_of_table_5_2(report_pendulum()));
  CHECK(!catalogue::is_of_table_5_2(test::report_scenario("double_pendulum", 5, 1e-3)));
  CHECK(!catalogue::is_of_table_5_2(test::report_scenario("single_pendulum", 10, 1e-3)));
  Scenario finer = report_pendulum();
  finer.step_s = 1e-4;  // a setting, not another motion
  CHECK(catalogue::is_of_table_5_2(finer));
  Scenario other = report_pendulum();
  other.q0[1] += 0.006;
  CHECK(!catalogue::is_of_table_5_2(other));
  other = report_pendulum();
  other.gravity = 9.8;
  CHECK(!catalogue::is_of_table_5_2(other));
  other = report_pendulum();
  other.links[1].width_m = 0.2;
  CHECK(!catalogue::is_of_table_5_2(other));
}

/// What stands for a case of Table 5.2 takes its steps; ode45 as many as make the points of 2010.
void table_5_2_has_the_steps_of_today() {
  catalogue::Evaluator evaluator(report_pendulum());
  for (const catalogue::Case2010& then : catalogue::table_5_2) {
    const long steps = evaluator.evaluate(find_method(then.method)).outcome.steps;
    CHECK_EQUAL(then.solver == "ode45" ? catalogue::ode45_refine * steps : steps, long{then.steps});
  }
}

}  // namespace

int main() {
  errors_are_those_of_a_run_of_its_own();
  steps_are_the_largest();
  tolerances_are_the_loosest();
  what_is_not_reached_is_said();
  timing_takes_turns();
  the_reports_pendulum_is_known();
  table_5_2_has_the_steps_of_today();
  return test::verdict();
}
