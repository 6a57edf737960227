// The cheapest setting that keeps an error: it keeps it, the next coarser does not, and what cannot be kept is said.
#include "catalogue/accuracy.hpp"

#include <deque>

#include "catalogue/equal_error.hpp"
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
  CHECK_NEAR(trial.error, *metrics[quantity::max_error_q], 1e-13);  // h = 0.05 / 50 is 0.001 but for a rounding
  CHECK_EQUAL(trial.uncertainty, *metrics[quantity::reference_uncertainty]);
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
  const Search below_reference = accuracy.cheapest(find_method("lagrange-ode45"), accuracy.uncertainty() / 2, plenty);
  CHECK(!below_reference.reached && !below_reference.why_not.empty());
  const Accuracy single(test::report_scenario("single_pendulum", 2, 1e-3), 1);
  CHECK(single.cheapest(find_method("analytic"), 1e-6, plenty).reached);
}

// A clock that stands still but for a set-up, 100 s each, and for runs, which take what is next for them.
double now_s = 1000;
std::string turns;

struct Pace {
  char letter;
  std::deque<double> takes_s;
  long steps;
};
Pace quick{'q', {}, 1000};
Pace slow{'s', {}, 250};

class Paced : public Simulation {
 public:
  explicit Paced(Pace& pace) : pace_(pace) { now_s += 100; }
  SampleShape shape() const override { return {}; }
  Outcome run(Recorder recorder) override {
    CHECK(!recorder && !pace_.takes_s.empty());
    if (!pace_.takes_s.empty()) {
      now_s += pace_.takes_s.front();
      pace_.takes_s.pop_front();
    }
    turns += pace_.letter;
    Outcome outcome;
    outcome.steps = pace_.steps;
    outcome.evaluations = 4 * pace_.steps;
    return outcome;
  }

 private:
  Pace& pace_;
};

template <Pace& pace>
catalogue::Method paced(std::string_view name) {
  catalogue::Method method{};
  method.name = name;
  method.make = [](const Scenario&, const SampleGrid&) -> std::unique_ptr<Simulation> {
    return std::make_unique<Paced>(pace);
  };
  return method;
}

constexpr double clock_rounding_s = 1e-11;  // of a few differences of times up to some 1e4 s

void timing_takes_turns() {
  const catalogue::Evaluator evaluator(test::report_scenario("double_pendulum", 0.1, 1e-3));
  const catalogue::Method one = paced<quick>("quick"), other = paced<slow>("slow");
  std::vector<catalogue::TimedRun> runs{{&evaluator, &one, 0, 0, {}}, {&evaluator, &other, 0, 0, {}}};
  // 0.5 ms take 5 runs of 0.11 ms: rounds of 3, 6 and 4 ms a run in the mean. The slow one is long enough by itself.
  quick.takes_s = {1.1e-4, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 4e-3, 4e-3, 4e-3, 4e-3, 4e-3};
  slow.takes_s = {9, 7, 2, 4};
  std::vector<int> begun;
  catalogue::time_in_turns(
      runs, 3, [&](int round) { begun.push_back(round); }, [] { return now_s; });
  CHECK(begun == (std::vector{0, 1, 2, 3}));
  CHECK_EQUAL(turns, "qsqqqqqsqqqqqsqqqqqs");
  const std::vector<double> wanted[] = {{3e-3, 6e-3, 4e-3}, {7, 2, 4}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    CHECK_EQUAL(runs[i].seconds.size(), wanted[i].size());
    for (std::size_t k = 0; k < wanted[i].size(); ++k) CHECK_NEAR(runs[i].seconds[k], wanted[i][k], clock_rounding_s);
  }
  CHECK_EQUAL(runs[0].steps, 1000L);
  CHECK_EQUAL(runs[1].evaluations, 1000L);

  // One that has taken enough has no more rounds.
  slow.takes_s = {7.5, 7, 2};
  std::vector<catalogue::TimedRun> long_one{{&evaluator, &other, 0, 0, {}}};
  catalogue::time_in_turns(
      long_one, 3, {}, [] { return now_s; }, 8);
  CHECK_EQUAL(long_one[0].seconds.size(), std::size_t{2});

  // Of one that takes enough by itself that which warms up is the only one.
  slow.takes_s = {9};
  std::vector<catalogue::TimedRun> longest{{&evaluator, &other, 0, 0, {}}};
  catalogue::time_in_turns(
      longest, 3, {}, [] { return now_s; }, 8);
  CHECK_EQUAL(longest[0].seconds.size(), std::size_t{1});
  CHECK_NEAR(longest[0].median_s(), 9, clock_rounding_s);

  // A run that no clock sees is done a hundred times over.
  quick.takes_s.assign(1 + 100, 0);
  std::vector<catalogue::TimedRun> unseen{{&evaluator, &one, 0, 0, {}}};
  catalogue::time_in_turns(unseen, 1, {}, [] { return now_s; });
  CHECK_EQUAL(unseen[0].batch, 100);
  CHECK(quick.takes_s.empty());
}

/// Takes 1 s, and 100 s more where it has rows to find.
class Rows : public Simulation {
 public:
  explicit Rows(const SampleGrid& grid) : rows_(grid.rows) {}
  SampleShape shape() const override { return {.coordinates = 2}; }
  Outcome run(Recorder recorder) override {
    now_s += recorder ? 101 : 1;
    for (long row = 0; recorder && row < rows_; ++row) recorder.next();
    return {};
  }

 private:
  long rows_;
};

// What finding rows costs is not the method's where it chooses its steps, nor an engine's beside ODE.
void rows_are_no_steps() {
  catalogue::Evaluator evaluator(test::report_scenario("double_pendulum", 0.1, 1e-3));
  catalogue::Method method = find_method("lagrange-rk4");
  method.make = [](const Scenario&, const SampleGrid& grid) -> std::unique_ptr<Simulation> {
    return std::make_unique<Rows>(grid);
  };
  const auto clock = [] { return now_s; };
  catalogue::Evaluation run = evaluator.evaluate(method);
  run.cpu_s = 101;
  CHECK_EQUAL(evaluator.stepping_s(run, clock), 101.0);
  method.order = 0;
  CHECK_EQUAL(evaluator.stepping_s(run, clock), 1.0);
  method.order = 4;
  method.tells = true;
  CHECK_EQUAL(evaluator.stepping_s(run, clock), 1.0);
}

// Of the times 1, 2, 40, 3 and 8 s the middle one is 3 s; from it they are 2, 1, 37, 0 and 5 s away, in the middle 2 s.
void a_row_of_timings_says_what_was_timed() {
  const catalogue::Evaluator evaluator(test::report_scenario("double_pendulum", 6, 1e-2));
  const TimingRow row = catalogue::timing_row({&evaluator, &find_method("lagrange-rk4"), 600, 2400, {1, 2, 40, 3, 8}});
  CHECK_EQUAL(row.scenario, "double_pendulum");
  CHECK_EQUAL(row.method, "lagrange-rk4");
  CHECK_EQUAL(row.step_s, 1e-2);
  CHECK_EQUAL(row.steps, 600L);
  CHECK_EQUAL(row.simulated_s, 6.0);
  CHECK_EQUAL(row.repeats, 5);
  CHECK_EQUAL(row.median_s, 3.0);
  CHECK_EQUAL(row.mad_s, 2.0);
  CHECK_EQUAL(row.min_s, 1.0);
  CHECK_EQUAL(row.ns_per_step, 5e6);
  CHECK_EQUAL(row.realtime_factor, 2.0);
}

// The rows of an equal error are those of the search, timed where it got there.
void an_equal_error_is_the_searchs() {
  const Accuracy accuracy(report_pendulum(), 1);
  const std::vector<const catalogue::Method*> methods{&find_method("lagrange-euler"), &find_method("lagrange-ode45"),
                                                      &find_method("lagrange-rk4")};
  const auto rows = catalogue::at_equal_error(accuracy, "report", methods, {1e-5, 2, 1000});
  CHECK_EQUAL(rows.size(), methods.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const EqualErrorRow& row = rows[i];
    CHECK_EQUAL(row.scenario, "report");
    CHECK_EQUAL(row.method, std::string(methods[i]->name));
    CHECK_EQUAL(row.knob, i == 1 ? "rtol" : "h");
    const catalogue::Trial trial = accuracy.try_setting(*methods[i], row.setting.value());
    CHECK_EQUAL(row.error, trial.error);
    CHECK_EQUAL(row.uncertainty, accuracy.uncertainty());
    CHECK_EQUAL(row.steps, trial.steps);
    CHECK_EQUAL(row.evaluations, trial.evaluations);
    CHECK_EQUAL(row.why_not.empty(), row.error + row.uncertainty <= 1e-5);
    CHECK_EQUAL(row.repeats, i == 0 ? 0 : 2);  // Euler does not get there in 1000 steps
    CHECK_EQUAL(row.median_s > 0, i != 0);
  }
}

void the_reports_pendulum_is_known() {
  CHECK(catalogue::is_of_table_5_2(report_pendulum()));
  CHECK(!catalogue::is_of_table_5_2(test::report_scenario("double_pendulum", 5, 1e-3)));
  CHECK(!catalogue::is_of_table_5_2(test::report_scenario("single_pendulum", 10, 1e-3)));
  Scenario finer = report_pendulum();
  finer.step_s = 1e-4;  // a setting, not another motion
  CHECK(catalogue::is_of_table_5_2(finer));
  Scenario other = report_pendulum();
  change_planar(other, [](PlanarView& view) { view.q0[1] += 0.006; });
  CHECK(!catalogue::is_of_table_5_2(other));
  other = report_pendulum();
  other.gravity = 9.8;
  CHECK(!catalogue::is_of_table_5_2(other));
  other = report_pendulum();
  change_planar(other, [](PlanarView& view) { view.links[1].width_m = 0.2; });
  CHECK(!catalogue::is_of_table_5_2(other));
}

// A case shows what its method was timed at, whatever else was; what was not timed has no number.
void table_5_2_shows_what_was_timed() {
  std::vector<TimingRow> timed(3);
  const char* const names[] = {"lagrange-rk4", "dh-ode45", "ode-step-double"};
  for (std::size_t i = 0; i < timed.size(); ++i) {
    timed[i].method = names[i];
    timed[i].steps = 10 + static_cast<long>(i);
    timed[i].median_s = 20 + static_cast<double>(i);
    timed[i].mad_s = 30 + static_cast<double>(i);
  }
  std::string shown;
  for (const Table52Row& row : catalogue::table_5_2_rows(timed)) {
    shown += row.number ? std::to_string(*row.number) : "-";
    shown += " " + row.solver + " " + row.method;
    if (row.steps) shown += " " + std::to_string(*row.steps) + test::shown(*row.median_s) + test::shown(*row.mad_s);
    CHECK(row.steps.has_value() == row.median_s.has_value() && row.steps.has_value() == row.mad_s.has_value());
    CHECK_EQUAL(row.number.has_value(), row.seconds_2010.has_value());
    shown += "\n";
  }
  CHECK_EQUAL(shown,
              "1 ode45 dh-ode45 112131\n"
              "2 ode45 dh-ode45 112131\n"
              "3 ode45 lagrange-ode45\n"
              "4 Euler lagrange-euler\n"
              "5 ODE's ode-step-double 122232\n"
              "- - lagrange-cvode\n"
              "- - lagrange-rk4 102030\n"
              "- - ode-rk4-double\n");
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
  rows_are_no_steps();
  a_row_of_timings_says_what_was_timed();
  an_equal_error_is_the_searchs();
  the_reports_pendulum_is_known();
  table_5_2_shows_what_was_timed();
  table_5_2_has_the_steps_of_today();
  return test::verdict();
}
