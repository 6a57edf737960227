// What a run prints: tables, hints, what went wrong.
#include "output/run_report.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

#include "measure/metrics.hpp"
#include "odeval/origin.hpp"
#include "output/number.hpp"
#include "output/table.hpp"
#include "output/timing.hpp"
#include "tests/check.hpp"
#include "tests/unit/example_summary.hpp"

namespace {

using namespace odeval;
using odeval::test::example;

/// A run that dWorldStep might have made: until 1 s and until 2 s its clock is so many steps ahead, which explains all
/// of its error but for a part.
RunSummary shifted(double steps, double left) {
  RunSummary run = example();
  for (Metrics& until : run.error_at) {
    until[quantity::max_error_q] = 4e-3 * until.until_s;
    until[quantity::time_shift] = steps * run.grid.step_s;
    until[quantity::error_q_after_shift] = left * *until[quantity::max_error_q];
  }
  return run;
}

bool says(const std::string& text, const std::string& line) { return text.find(line) != std::string::npos; }

void the_report_of_a_run_gives_hints() {
  const auto report = [](const RunSummary& run) { return run_report({run}, std::vector<double>{1250}, Reference{}); };
  const std::string hint =
      "half step  to 2 s ode-step-double is 0.46 steps ahead of the reference; error 0.008 rad, after shifting by that "
      "time 0.0004 rad: try --start half-step\n";
  CHECK(says(report(shifted(0.46, 0.05)), hint));  // the longer span of the two
  RunSummary second = shifted(0.46, 0.5);          // where half a step explains too little, another method's is said
  second.method = "ode-quickstep-double";
  CHECK(says(run_report({second, shifted(0.46, 0.05)}, {}, Reference{}), hint));
  RunSummary early = shifted(0.46, 0.05);
  early.error_at[1][quantity::error_q_after_shift] = early.error_at[1][quantity::max_error_q];
  CHECK(says(report(early), "half step  to 1 s"));
  CHECK(!says(report(shifted(0.46, 0.11)), "half step"));
  CHECK(!says(report(shifted(0.39, 0.05)), "half step"));
  CHECK(!says(report(shifted(0.61, 0.05)), "half step"));
  CHECK(!says(report(shifted(-0.5, 0.05)), "half step"));
  RunSummary started = shifted(0.5, 0.05);
  started.scenario.ode.start = Start::half_step;
  CHECK(!says(report(started), "half step"));
  RunSummary other = shifted(0.5, 0.05);
  other.uses_ode = false;
  CHECK(!says(report(other), "half step"));
}

/// The cells of a table's first row, which stand at least two blanks apart.
std::vector<std::string> first_row(const std::string& table) {
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  std::vector<std::string> parts;
  for (std::size_t at = line.find_first_not_of(' '); at < line.size(); at = line.find_first_not_of(' ', at)) {
    const std::size_t end = std::min(line.find("  ", at), line.size());
    parts.push_back(line.substr(at, end - at));
    at = end;
  }
  return parts;
}

// Each column of the printed tables holds its own number.
void printed_tables_hold_their_numbers() {
  const auto same = [](const std::string& table, const std::vector<std::string>& wanted) {
    odeval::test::report(first_row(table) == wanted, __FILE__, __LINE__, "the first row is not as wanted:\n" + table);
  };
  RunSummary run = example();
  run.error_at.resize(3);
  run.error_at[1][quantity::max_error_q] = 0.021;
  run.error_at[1][quantity::max_error_position] = run.error_at[1][quantity::max_error_turn] = 0.021;
  run.error_at[2].until_s = 3;
  run.error_at[2][quantity::max_error_q] = 0.03;
  run.error_at[2][quantity::reference_uncertainty] = 7e-12;
  run.metrics[quantity::divergence_time] = 2.25;
  run.metrics[quantity::max_gap] = 3e-5;
  run.metrics[quantity::max_out_of_plane] = 4e-5;
  same(summary_table({run}, std::vector<double>{1250}), {"ode-step-double", "0.0089 ± 6e-12", "0.03 ± 7e-12",
                                                         "0.25 ± 6e-12", "2.25", "0.0001", "3e-05", "2", "1.25", "ok"});
  run.metrics[quantity::reference_uncertainty] = 1.5;  // rad: nobody knows
  CHECK_EQUAL(first_row(summary_table({run}, {})).at(3), "reference lost");
  same(impacts_table({run}, {{0.4921, -1.62, -5, 5, 0}}),
       {"ode-step-double", "1", "0.5", "-1.62", "-5", "4", "0.8", "0.001", "+0.0079"});
  run.outcome.impacts[0].link = 2;
  CHECK_EQUAL(first_row(impacts_table({run}, {})).at(1), "1 of 2");

  run.metrics = {};
  run.metrics[quantity::max_energy_drift] = 1e-4;
  run.error_at[0][quantity::max_error_position] = 0.125;
  run.error_at[0][quantity::position_uncertainty] = 1e-15;
  run.error_at[0][quantity::max_error_turn] = 0.25;
  run.error_at[0][quantity::turn_uncertainty] = 2e-15;
  run.metrics[quantity::max_error_position] = 0.5;
  run.metrics[quantity::position_uncertainty] = 3e-15;
  run.metrics[quantity::max_error_turn] = 0.75;
  run.metrics[quantity::turn_uncertainty] = 4e-15;
  run.metrics[quantity::max_angular_momentum_drift] = 5e-3;
  same(summary_table({run}, std::vector<double>{1250}),
       {"ode-step-double", "0.125 ± 1e-15", "0.5 ± 3e-15", "0.25 ± 2e-15", "0.75 ± 4e-15", "0.0001", "0.005", "2",
        "1.25", "ok"});
  run.metrics[quantity::max_reaction_error] = 6e-3;
  CHECK_EQUAL(first_row(summary_table({run}, {})).at(6), "0.006");
}

void the_report_of_a_run_says_what_it_is() {
  RunSummary run = example();
  Reference reference;
  reference.origin = "a reference of words";
  reference.impacts = {{0.4921, -1.62, -5, 5, 0}};
  const auto report = [&] { return run_report({run}, std::vector<double>{1250}, reference); };
  const std::string plain = report();
  CHECK(plain.starts_with("wall_pendulum: 2.5 s, h = 0.001 s, 2501 rows\n\n"));
  CHECK(says(plain, summary_table({run}, std::vector<double>{1250})));
  CHECK(says(plain, "\n\n" + impacts_table({run}, reference.impacts)));
  CHECK(says(plain, "\nerror      largest angle error against the reference"));
  CHECK(says(plain, "\nlost at    first error above 0.1 rad\n"));
  CHECK(says(plain, "\nreference  a reference of words\n"));
  for (const char* absent : {"nothing is called lost", "joints  ", "between its runs", "half step", "distance "}) {
    CHECK(!says(plain, absent));
  }
  run.metrics.reference_lost_at = 1.5;
  CHECK(says(report(), "\n           itself unknown to 0.1 rad from t = 1.5 s: nothing is called lost after that\n"));
  run.scenario.ode.spring = Spring{100, 0.3};
  CHECK(says(report(), "\njoints     kp 100 N/m, kd 0.3 N s/m: ERP 0.25, CFM 2.5 at this step\n"));
  run.outcome.self_difference = 2.5e-21;
  CHECK(says(report(), "\node-step-double: 2.5e-21 rad between its runs at two step sizes\n"));
  run.outcome.impacts.clear();
  CHECK(!says(report(), "depth, m"));

  run.metrics = {};
  run.metrics[quantity::max_error_position] = 0.5;
  run.metrics[quantity::position_uncertainty] = 1e-15;
  const std::string bodies = report();
  CHECK(says(bodies, "\ndistance   largest distance of a body from the reference"));
  CHECK(says(bodies, "\nturned     likewise the angle"));
  CHECK(!says(bodies, "lost at "));
}

// Of what rubs, and where ODE's own friction is the reference, alone.
void another_friction_is_no_fault() {
  RunSummary ode = example(), other = example();
  other.method = "mujoco-euler";
  other.uses_ode = false;
  Reference reference;
  reference.origin = std::string(self_converged_origin) + ": dWorldStep's own limit";
  const auto says_it = [&](const std::vector<RunSummary>& runs) {
    return says(run_report(runs, {}, reference), "\nfriction   the reference has ODE's own law; mujoco-euler may");
  };
  CHECK(!says_it({ode, other}));
  for (RunSummary* const run : {&ode, &other}) run->scenario.mechanism.contacts[0].friction = Friction{0.4};
  CHECK(says_it({ode, other}));
  CHECK(!says_it({ode}));
  reference.origin = "closed form";
  CHECK(!says_it({ode, other}));
}

void tables_are_aligned() {
  TextTable table("lr", {"name", "µs"});
  table.add({"a", "0.5 ± 0.1"});
  table.add({"longer", "7"});
  CHECK_EQUAL(table.text(), "name           µs\na       0.5 ± 0.1\nlonger          7\n");
  CHECK_EQUAL(three_digits(0.0089123), "0.00891");
  CHECK_EQUAL(three_digits({}), "-");
  CHECK_EQUAL(with_uncertainty(0.0089, 6e-12), "0.0089 ± 6e-12");
  CHECK_EQUAL(with_uncertainty(0.0089, {}), "0.0089");

  RunSummary reference = example();
  reference.method = "lagrange-cvode";
  reference.is_reference = true;
  RunSummary broken = example();
  broken.outcome.diverged = true;
  broken.outcome.reason = "not finite at t = 1.5 s";
  const std::vector<double> cost{1250, 500, 10};
  const std::string summary = summary_table({example(), reference, broken}, cost);
  CHECK(summary.find("0.0089 ± 6e-12") != std::string::npos);
  CHECK(summary.find("1.25") != std::string::npos);
  CHECK(summary.find("diverged\n") != std::string::npos);  // the reason stands below, in a line of its own
  CHECK(run_report({example(), broken}, {}, Reference{}).find("not finite at t = 1.5 s") != std::string::npos);
  CHECK(summary_table({example()}, {}).find("ok") != std::string::npos);

  const std::vector<Impact> wanted{{0.4921, -1.62, -5, 5, 0}};
  const std::string impacts = impacts_table({example()}, wanted);
  CHECK(impacts.find("+0.0079") != std::string::npos);
  CHECK(impacts.find("0.8") != std::string::npos);
  CHECK(impacts_table({example()}, wanted, 1).find("... 2") != std::string::npos);
}

}  // namespace

int main() {
  the_report_of_a_run_gives_hints();
  printed_tables_hold_their_numbers();
  the_report_of_a_run_says_what_it_is();
  another_friction_is_no_fault();
  tables_are_aligned();
  return odeval::test::verdict();
}
