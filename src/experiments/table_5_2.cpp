// What the methods cost: the report's Table 5.2, at equal steps and at equal error. Claim C7.
#include "catalogue/table_5_2.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "catalogue/equal_error.hpp"
#include "catalogue/timing.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/spread.hpp"

namespace odeval::experiments {
namespace {

using report::Cell;
using report::Missing;

constexpr int points_of_2010 = 500;  // report, Table 5.2
constexpr int rounds = 9;
constexpr double max_error_rad = 1e-3;
constexpr double until_s = 3;
constexpr long most_steps = 10'000'000;  // enough for Euler

/// Those of Table 5.2 that this build has, each once, and those shown beside it.
std::vector<const catalogue::Method*> methods_of_table() {
  std::vector<const catalogue::Method*> methods;
  const auto add = [&](std::string_view name) {
    const catalogue::Method* const method = available(name);
    if (method != nullptr && std::ranges::find(methods, method) == methods.end()) methods.push_back(method);
  };
  for (const catalogue::Case2010& then : catalogue::table_5_2) add(then.method);
  for (const std::string_view name : catalogue::beside_table_5_2) add(name);
  return methods;
}

template <class Number>
Cell cell(const std::optional<Number>& number, double factor, const char* why) {
  return number ? Cell(factor * static_cast<double>(*number)) : Cell(Missing{why});
}

report::Table side_by_side(const std::vector<TimingRow>& timed) {
  const std::vector<Table52Row> rows = catalogue::table_5_2_rows(timed);
  const auto ode = std::ranges::find_if(rows, [](const Table52Row& row) { return row.number == 5; });
  constexpr const char* not_in_report = "the report did not have it";
  constexpr const char* not_timed = "not timed in this build";
  report::Table table{.name = "table-5-2",
                      .columns = {"case", "equations", "solver", "steps 2010", "2010, s", "2010, times ODE",
                                  "method now", "steps now", "now, ms", "deviation, ms", "now, times ODE"}};
  for (const Table52Row& row : rows) {
    std::vector<Cell> cells{row.number ? Cell(fmt::format("{}", *row.number)) : Cell(std::string("-")), row.equations,
                            row.solver};
    cells.push_back(cell(row.steps_2010, 1, not_in_report));
    cells.push_back(cell(row.seconds_2010, 1, not_in_report));
    cells.push_back(cell(row.seconds_2010, 1 / ode->seconds_2010.value(), not_in_report));
    cells.emplace_back(row.method);
    cells.push_back(cell(row.steps, 1, not_timed));
    cells.push_back(cell(row.median_s, 1e3, not_timed));
    cells.push_back(cell(row.mad_s, 1e3, not_timed));
    cells.push_back(ode->median_s ? cell(row.median_s, 1 / *ode->median_s, not_timed) : Cell(Missing{not_timed}));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

report::Table equal_error(const Scenario& file) {
  const catalogue::Accuracy accuracy(file, until_s);
  const auto rows = catalogue::at_equal_error(accuracy, file.name, methods_of_table(), {max_error_rad, 5, most_steps});
  report::Table table{
      .name = "equal-error",
      .columns = {"method", "made accurate by", "setting", "error, rad", "the reference's uncertainty, rad", "steps",
                  "evaluations", "CPU time, ms", "deviation, ms"}};
  for (const EqualErrorRow& row : rows) {
    const Missing why{"not reached: " + row.why_not};
    const bool reached = row.why_not.empty();
    table.rows.push_back({row.method, row.knob.empty() ? std::string("nothing") : row.knob,
                          row.setting ? Cell(*row.setting) : Cell(Missing{"it has no setting"}), row.error,
                          row.uncertainty, static_cast<double>(row.steps),
                          row.evaluations > 0 ? Cell(static_cast<double>(row.evaluations))
                                              : Cell(Missing{"ODE does not evaluate equations of motion"}),
                          reached ? Cell(1e3 * row.median_s) : Cell(why), reached ? Cell(1e3 * row.mad_s) : Cell(why)});
  }
  return table;
}

void add_ratio(Findings& findings, const std::string& name, const std::string& meaning,
               const std::vector<catalogue::TimedRun>& runs, std::string_view a, std::string_view b) {
  const auto run_of = [&](std::string_view method) -> const std::vector<double>& {
    return std::ranges::find_if(runs, [&](const auto& run) { return run.method->name == method; })->seconds;
  };
  const std::vector<double>& one = run_of(a);
  const std::vector<double>& other = run_of(b);
  findings.add(
      name, known_by(report::Source::timing, measured_ratio(meaning, median(one), median(other), median_half_width(one),
                                                            median_half_width(other))));
}

}  // namespace

Content table_5_2(Laboratory& laboratory, Findings& findings) {
  const catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  std::vector<catalogue::TimedRun> runs;
  for (const catalogue::Method* method : methods_of_table()) runs.push_back({&evaluator, method, 0, 0, {}});
  catalogue::time_in_turns(runs, rounds);
  std::vector<TimingRow> timed;
  for (const catalogue::TimedRun& run : runs) timed.push_back(catalogue::timing_row(run));

  add_ratio(findings, "C7.ode45_over_ode", "CPU time of ode45 on hand-derived equations over that of ODE, 10 s", runs,
            "lagrange-ode45", "ode-step-double");
  add_ratio(findings, "C7.euler_over_ode", "CPU time of Euler on hand-derived equations over that of ODE, same steps",
            runs, "lagrange-euler", "ode-step-double");
  add_ratio(findings, "C7.dh_over_lagrange",
            "CPU time of ode45 on a toolbox's equations over that on hand-derived ones", runs, "dh-ode45",
            "lagrange-ode45");
  add_ratio(findings, "table-5-2.accurate_over_ode",
            "CPU time of the fourth-order step beside ODE's collision detection over that of ODE, same steps", runs,
            "ode-rk4-double", "ode-step-double");

  Content content;
  content.values = {{"rounds", rounds},
                    {"points", points_of_2010},
                    {"duration", evaluator.scenario().duration_s},
                    {"ode45_steps", points_of_2010 / catalogue::ode45_refine},
                    {"ode45_refine", catalogue::ode45_refine},
                    {"max_error", max_error_rad},
                    {"until", until_s},
                    {"accurate_over_ode", shown(*findings.find("table-5-2.accurate_over_ode"))}};
  content.exhibits.emplace_back(side_by_side(timed));
  content.exhibits.emplace_back(equal_error(evaluator.scenario()));
  return content;
}

}  // namespace odeval::experiments
