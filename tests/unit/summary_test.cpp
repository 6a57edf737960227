// Summaries and timings as files: keys, undefined and infinite values, same bytes for the same run.
#include "output/summary.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "measure/metrics.hpp"
#include "odeval/origin.hpp"
#include "output/checks.hpp"
#include "output/number.hpp"
#include "output/sweep_table.hpp"
#include "output/table.hpp"
#include "output/timing.hpp"
#include "tests/cells.hpp"
#include "tests/check.hpp"
#include "tests/unit/example_summary.hpp"

namespace {

using namespace odeval;
using nlohmann::json;
using odeval::test::cells;
using odeval::test::example;

constexpr double infinity = std::numeric_limits<double>::infinity();

void json_has_the_keys_of_the_interface() {
  const json run = json::parse(summary_json(example()));
  for (const char* key : {"scenario", "method", "steps", "max_error_q", "rms_error_q", "error_at", "divergence_time",
                          "reference_uncertainty", "max_energy_drift", "rms_energy_drift", "final_energy_drift",
                          "max_gap", "max_out_of_plane", "max_reaction_error", "impacts", "diverged", "versions"}) {
    CHECK(run.contains(key));
  }
  CHECK_EQUAL(run["max_error_q"].get<double>(), 0.25);
  CHECK_EQUAL(run["rms_error_q"].get<std::string>(), "inf");
  CHECK(run["divergence_time"].is_null());
  CHECK(run["max_reaction_error"].is_null());
  CHECK_EQUAL(run["error_at"]["1"]["max_error_q"].get<double>(), 0.0089);
  CHECK(run["error_at"]["2"]["max_error_q"].is_null());
  CHECK(!run["error_at"].contains("3"));
  CHECK_EQUAL(run["impacts"].size(), 2u);
  CHECK_EQUAL(run["impacts"][0]["restitution"].get<double>(), 0.8);
  CHECK(run["impacts"][1]["restitution"].is_null());
  RunSummary uncounted = example();
  uncounted.scenario.impact_views.clear();  // of contacts that no method counts: not the same as none
  CHECK(json::parse(summary_json(uncounted))["impacts"].is_null());
  CHECK_EQUAL(run["versions"]["ode"].get<std::string>(), "0.16.2");
  CHECK_EQUAL(run["settings"]["step"].get<double>(), 1e-3);
  CHECK_EQUAL(run["settings"]["ode"]["bounce"].get<double>(), 0.75);  // the wall's, as none is set
  CHECK_EQUAL(run["settings"]["ode"]["max_correcting_vel"].get<std::string>(), "inf");
  CHECK(!run["settings"].contains("rtol"));
  CHECK(summary_json(example()).find("/some/where") == std::string::npos);

  RunSummary other = example();
  other.uses_ode = false;
  other.uses_maximal = true;
  other.scenario.maximal = {25, 10};
  other.rtol = 1e-3;
  CHECK(!json::parse(summary_json(other))["settings"].contains("ode"));
  CHECK(!run["settings"].contains("maximal"));
  CHECK_EQUAL(json::parse(summary_json(other))["settings"]["maximal"]["ks"].get<double>(), 25.0);
  CHECK_EQUAL(json::parse(summary_json(other))["settings"]["maximal"]["kd"].get<double>(), 10.0);
  CHECK_EQUAL(json::parse(summary_json(other))["settings"]["rtol"].get<double>(), 1e-3);
}

void csv_has_a_row_a_method() {
  std::istringstream text(summary_csv({example(), example()}));
  std::string header, row, rest;
  std::getline(text, header);
  std::getline(text, row);
  const std::vector<std::string> names = cells(header);
  const std::vector<std::string> values = cells(row);
  CHECK_EQUAL(values.size(), names.size());
  const auto value = [&](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? "no such column" : values[static_cast<std::size_t>(at - names.begin())];
  };
  CHECK_EQUAL(value("scenario"), "wall_pendulum");
  CHECK_EQUAL(value("max_error_q"), "0.25");
  CHECK_EQUAL(value("rms_error_q"), "inf");
  CHECK_EQUAL(value("divergence_time"), "");
  CHECK_EQUAL(value("max_error_q_at_1"), "0.0089");
  CHECK_EQUAL(value("max_error_q_at_10"), "");
  CHECK_EQUAL(value("impacts"), "2");
  CHECK_EQUAL(value("diverged"), "false");
  std::getline(text, row);
  CHECK(!std::getline(text, rest));

  RunSummary broken = example();
  broken.outcome.diverged = true;
  broken.outcome.reason = "said \"no\", twice\nand stopped";
  CHECK(summary_csv({broken}).find(",true,\"said \"\"no\"\", twice and stopped\",") != std::string::npos);
}

// Of a run with angles their errors and bounds, of one with bodies theirs, known or not; the clock's of both.
void errors_are_of_what_the_run_has() {
  const auto names = [](const RunSummary& run) {
    std::vector<std::string> all;
    const json summary = json::parse(summary_json(run));
    for (const auto& [name, value] : summary["error_at"]["2"].items()) all.push_back(name);
    std::ranges::sort(all);
    return all;
  };
  RunSummary run = example();
  run.metrics[quantity::max_long_axis_spin] = 0.5;  // of links, which the reference bounds no spin of
  CHECK(names(run) ==
        std::vector<std::string>({"error_q_after_shift", "impact_uncertainty", "max_error_q", "max_impact_error",
                                  "reference_uncertainty", "rms_error_q", "time_shift", "time_shift_uncertainty"}));
  run.metrics = {};
  run.metrics[quantity::max_error_turn] = 0.5;
  run.metrics[quantity::turn_uncertainty] = 1e-9;
  CHECK(names(run) ==
        std::vector<std::string>({"error_position_after_shift", "impact_uncertainty", "max_error_position",
                                  "max_error_turn", "max_impact_error", "max_long_axis_spin", "position_uncertainty",
                                  "spin_uncertainty", "time_shift", "time_shift_uncertainty", "turn_uncertainty"}));
}

// A spring is shown as it was given and as ODE was told, whatever erp and cfm say; without one the softness as both.
void softness_is_shown_both_ways() {
  RunSummary run = example();
  run.scenario.ode.spring = Spring{1e4, 1};
  const json given = json::parse(summary_json(run))["settings"]["ode"];
  CHECK_EQUAL(given["kp"].get<double>(), 1e4);
  CHECK_EQUAL(given["kd"].get<double>(), 1.0);
  CHECK_NEAR(given["erp"].get<double>(), 10.0 / 11, 1e-15);  // h kp / (h kp + kd), report eq. 3.6
  CHECK_NEAR(given["cfm"].get<double>(), 1.0 / 11, 1e-15);   // 1 / (h kp + kd)
  run.scenario.ode.spring.reset();
  run.scenario.ode.erp = 0.25;
  run.scenario.ode.cfm = 2.5;
  const json told = json::parse(summary_json(run))["settings"]["ode"];
  CHECK_EQUAL(told["erp"].get<double>(), 0.25);
  CHECK_EQUAL(told["cfm"].get<double>(), 2.5);
  CHECK_NEAR(told["kp"].get<double>(), 100, 1e-12);
  CHECK_NEAR(told["kd"].get<double>(), 0.3, 1e-15);
}

// Every metric in its own column, every error time in its own three, of the run it belongs to.
void csv_holds_every_number() {
  RunSummary run = example();
  Metrics& m = run.metrics;
  double next = 100;
  for (const Quantity& row : quantities) m[row.id] = ++next;
  m[quantity::final_energy_drift] = -++next;
  run.error_at.clear();
  for (const double time : error_times) {
    Metrics& at = run.error_at.emplace_back();
    at.until_s = time;
    at[quantity::max_error_q] = time / 8;
    at[quantity::rms_error_q] = time / 16;
    at[quantity::reference_uncertainty] = time / 1024;
  }
  run.outcome.evaluations = 77;
  run.outcome.at_rest_from = 2.25;
  const std::string text = summary_csv({run});
  const std::size_t end = text.find('\n');
  const std::vector<std::string> names = cells(text.substr(0, end));
  const std::vector<std::string> values = cells(text.substr(end + 1, text.size() - end - 2));
  CHECK_EQUAL(values.size(), names.size());
  std::vector<std::pair<std::string, double>> wanted{{"step", 1e-3},      {"duration", 2.5},      {"steps", 2500},
                                                     {"evaluations", 77}, {"at_rest_from", 2.25}, {"impacts", 2}};
  const json same = json::parse(summary_json(run));
  for (const Quantity& row : quantities) {
    wanted.emplace_back(row.name, m[row.id].value());
    CHECK_EQUAL(same.at(std::string(row.name)).get<double>(), m[row.id].value());
  }
  for (const auto& [name, at] :
       {std::pair{"_at_1", 1.0}, {"_at_2", 2.0}, {"_at_3", 3.0}, {"_at_5", 5.0}, {"_at_10", 10.0}}) {
    wanted.emplace_back("max_error_q" + std::string(name), at / 8);
    wanted.emplace_back("rms_error_q" + std::string(name), at / 16);
    wanted.emplace_back("reference_uncertainty" + std::string(name), at / 1024);
  }
  for (const auto& [name, number] : wanted) {
    const auto at = std::ranges::find(names, name) - names.begin();
    CHECK(static_cast<std::size_t>(at) < names.size());
    if (static_cast<std::size_t>(at) < values.size())
      CHECK_EQUAL(std::stod(values[static_cast<std::size_t>(at)]), number);
  }
  CHECK_EQUAL(names.size(), wanted.size() + 5);  // scenario, method, is_reference, diverged, reason
}

void same_run_same_bytes() {
  CHECK_EQUAL(summary_json(example()), summary_json(example()));
  CHECK_EQUAL(summary_csv({example()}), summary_csv({example()}));
}

void error_times_fit_the_run() {
  SampleGrid grid;
  grid.step_s = 0.1;
  grid.rows = 31;  // ends at 3.0000000000000004
  CHECK_EQUAL(error_times_within(grid).size(), 3u);
  grid.rows = 30;
  CHECK_EQUAL(error_times_within(grid).size(), 2u);
  grid.rows = 101;
  CHECK_EQUAL(error_times_within(grid).size(), 5u);
}

/// Of JSON, as a cell of CSV shows it.
std::string cell_of(const json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  return value.is_string() ? value.get<std::string>() : value.is_number_float() ? number_text(value) : value.dump();
}

/// Each row of the list, or the object that holds it, has every column of the CSV, with what stands there.
void check_same(const std::string& csv, const json& file) {
  std::istringstream text(csv);
  std::string header, line;
  std::getline(text, header);
  const std::vector<std::string> names = cells(header);
  for (const json& row : file["rows"]) {
    std::getline(text, line);
    const std::vector<std::string> values = cells(line);
    CHECK_EQUAL(values.size(), names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const json& holder = row.contains(names[i]) ? row : file;
      CHECK_EQUAL(names[i] + " " + cell_of(holder.at(names[i])), names[i] + " " + values[i]);
    }
  }
  CHECK(!std::getline(text, line));
}

void timings_have_the_columns_of_the_interface() {
  const TimingRow row{"double_pendulum", "ode-step-double", 1e-3, 10000, 10, 7, 0.0125, 1e-4, 0.012, 1250, 800};
  CHECK_EQUAL(timing_csv({row}),
              "scenario,method,h,steps,simulated_s,repeats,median_s,mad_s,min_s,ns_per_step,realtime_factor\n"
              "double_pendulum,ode-step-double,0.001,10000,10,7,0.0125,0.0001,0.012,1250,800\n");
  const json all = json::parse(timing_json({row}, {}, {{"compiler", "g++"}}));
  CHECK_EQUAL(all["environment"]["compiler"].get<std::string>(), "g++");
  check_same(timing_csv({row}), all);
  CHECK_EQUAL(timing_table({row}),
              "scenario         method            h, s  steps  median, ms    ±   ns/step  times real time\n"
              "double_pendulum  ode-step-double  0.001  10000        12.5  0.1  1.25e+03              800\n");
}

// One of each kind and a number of its own for each, so that none is taken for another.
void checks_say_what_was_held_against_what() {
  using Verdict = CheckRow::Verdict;
  const Tolerance both{"ode-step-double", "max_error_q", 2, 0.5, 0.25};
  const Tolerance least{"lagrange-rk4", "divergence_time", 3, {}, 1};
  std::vector<CheckRow> rows{{"a", both, 0.375, 1e-9, Verdict::kept}};
  rows.insert(rows.end(), 2, {"b", least, 0.75, {}, Verdict::failed});
  rows.insert(rows.end(), 3, {"c", both, 0.5, 0.1, Verdict::undecided});
  rows.insert(rows.end(), 4, {"d", least, {}, {}, Verdict::left_out});
  const std::string failed =
      "b         lagrange-rk4     divergence_time         3           0.75         1        -  FAILED\n";
  const std::string undecided =
      "c         ode-step-double  max_error_q             2      0.5 ± 0.1      0.25      0.5  UNDECIDED: within the "
      "uncertainty\n";
  const std::string left_out =
      "d         lagrange-rk4     divergence_time         3              -         1        -  not in this build\n";
  CHECK_EQUAL(checks_table(rows),
              "scenario  method           metric           until, s       measured  at least  at most\n"
              "a         ode-step-double  max_error_q             2  0.375 ± 1e-09      0.25      0.5  kept\n" +
                  failed + failed + undecided + undecided + undecided + left_out + left_out + left_out + left_out +
                  "\n10 tolerances: 1 kept, 2 failed, 3 undecided, 4 left out\n");

  const json list = json::parse(checks_json(rows));
  CHECK_EQUAL(list.size(), rows.size());
  CHECK_EQUAL(list[0].dump(), json({{"scenario", "a"},
                                    {"method", "ode-step-double"},
                                    {"metric", "max_error_q"},
                                    {"until", 2.0},
                                    {"measured", 0.375},
                                    {"reference_uncertainty", 1e-9},
                                    {"at_least", 0.25},
                                    {"at_most", 0.5},
                                    {"verdict", "kept"}})
                                  .dump());
  CHECK(list[1]["at_most"].is_null() && list[1]["reference_uncertainty"].is_null() && list[9]["measured"].is_null());
  CHECK_EQUAL(list[1]["verdict"].get<std::string>(), "FAILED");
  CHECK_EQUAL(list[3]["verdict"].get<std::string>(), "UNDECIDED: within the uncertainty");
  CHECK_EQUAL(list[9]["verdict"].get<std::string>(), "not in this build");
}

// Every column of a sweep's results is found again under its name, and what is empty is no number.
void a_row_of_a_sweep_holds_every_metric() {
  Outcome outcome;
  outcome.steps = 101;
  outcome.evaluations = 202;
  outcome.messages = 303;
  Metrics metrics;
  metrics[quantity::max_error_q] = 0.1;
  metrics[quantity::max_energy_drift] = 1e-300;
  metrics[quantity::final_energy_drift] = -2.5;
  metrics[quantity::max_gap] = infinity;
  const std::vector<std::string> columns = result_columns();
  const std::string row = result_cells(outcome, metrics);
  const auto value = [&](std::string_view name) {
    return number_in(row, static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin()));
  };
  CHECK_EQUAL(cells(row).size(), columns.size());
  CHECK_EQUAL(value("steps"), 101.0);
  CHECK_EQUAL(value("evaluations"), 202.0);
  CHECK_EQUAL(value("messages"), 303.0);
  for (const Quantity& metric : quantities) {
    const std::optional<double> wanted = metrics[metric.id];
    CHECK(wanted ? value(metric.name) == *wanted : std::isnan(value(metric.name)));
  }
  CHECK(std::isnan(number_in(row, columns.size())));
  CHECK(std::isnan(number_in("1,2x,3", 1)) && number_in("1,2x,3", 2) == 3);
  const std::vector<std::string> keys{"q0", "method"};
  const std::vector<std::string> names{"steps", "max_gap", "rest_time"};
  CHECK_EQUAL(sweep_header(keys, names), "run,q0,method,status,reason,steps,max_gap,rest_time\n");
  const std::vector<std::string> values{"[1,2]", "m"};
  CHECK_EQUAL(sweep_line(7, values, "ok", "", "3,0.5,", 3), "7,\"[1,2]\",m,ok,,3,0.5,\n");
  CHECK_EQUAL(sweep_line(8, values, "crashed", "no, \"it\" did", "", 3),
              "8,\"[1,2]\",m,crashed,\"no, \"\"it\"\" did\",,,\n");
}

// What was not timed, or not reached, has no number: a dash, null, an empty cell.
void missing_timings_stay_missing() {
  const std::vector<Table52Row> table{{4, "by hand", "Euler", 10000, 1.16, "lagrange-euler", {}, {}, {}},
                                      {5, "ODE", "ODE's", 10000, 0.29, "ode-step-double", 10000, 0.02, 0.001},
                                      {{}, "-", "-", {}, {}, "lagrange-rk4", 10000, 0.005, 0.001}};
  CHECK_EQUAL(table_5_2_text(table),
              "case  equations  solver  steps 2010     s  x ODE  method           steps  ms  ±  x ODE\n"
              "   4  by hand    Euler        10000  1.16      4  lagrange-euler       -   -  -      -\n"
              "   5  ODE        ODE's        10000  0.29      1  ode-step-double  10000  20  1      1\n"
              "   -  -          -                -     -      -  lagrange-rk4     10000   5  1   0.25\n");
  const json timing = json::parse(timing_json({}, table, {{"compiler", "GNU"}}));
  const auto row_text = [&](std::size_t row) {
    std::string text;
    for (const char* key :
         {"case", "equations", "solver", "steps_2010", "seconds_2010", "method", "steps", "median_s", "mad_s"}) {
      text += cell_of(timing["table_5_2"][row].at(key)) + ",";
    }
    return text;
  };
  CHECK_EQUAL(row_text(0), "4,by hand,Euler,10000,1.16,lagrange-euler,,,,");
  CHECK_EQUAL(row_text(1), "5,ODE,ODE's,10000,0.29,ode-step-double,10000,0.02,0.001,");
  CHECK_EQUAL(row_text(2), ",-,-,,,lagrange-rk4,10000,0.005,0.001,");
  CHECK(!json::parse(timing_json({}, {}, {})).contains("table_5_2"));

  EqualErrorRow reached{"s", "m", "h", 0.25, 1e-4, 1e-9, "", 40, 160, 3, 0.5, 0.125};
  EqualErrorRow failed{"s", "n", "", {}, 1e-2, 1e-9, "no knob", 40, 0, 0, 0, 0};
  CHECK_EQUAL(
      equal_error_csv({reached, failed}, 1e-3, 2),
      "scenario,method,max_error,until,reached,knob,setting,error,uncertainty,steps,evaluations,repeats,median_s,"
      "mad_s\n"
      "s,m,0.001,2,1,h,0.25,0.0001,1e-09,40,160,3,0.5,0.125\n"
      "s,n,0.001,2,0,,,0.01,1e-09,40,0,0,,\n");
  const json equal = json::parse(equal_error_json({reached, failed}, 1e-3, 2, {}));
  check_same(equal_error_csv({reached, failed}, 1e-3, 2), equal);
  CHECK_EQUAL(equal["rows"][1]["why_not"].get<std::string>(), "no knob");
  CHECK_EQUAL(
      equal_error_table({reached, failed}),
      "scenario  method  setting       error, rad  steps  evaluations  median, ms    ±\n"
      "s         m       h = 0.25  0.0001 ± 1e-09     40          160         500  125\n"
      "s         n       -           0.01 ± 1e-09     40            -           -    -  not reached: no knob\n");
}

}  // namespace

int main() {
  json_has_the_keys_of_the_interface();
  errors_are_of_what_the_run_has();
  softness_is_shown_both_ways();
  csv_has_a_row_a_method();
  csv_holds_every_number();
  same_run_same_bytes();
  error_times_fit_the_run();
  timings_have_the_columns_of_the_interface();
  missing_timings_stay_missing();
  checks_say_what_was_held_against_what();
  a_row_of_a_sweep_holds_every_metric();
  return odeval::test::verdict();
}
