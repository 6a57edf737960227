// The problems of the IFToMM library: the CPU time that it costs to stay near the exact motion, of the pendulum A01 for
// 2000 s.
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <vector>

#include "catalogue/accuracy.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "odeval/error.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Accuracy;
using catalogue::Method;
using catalogue::Trial;
using report::Cell;
using report::Missing;

constexpr double asked[] = {0.1, 0.001};  // rad; m of the point, which is 1 m from its hinge
// So that the page keeps its time: what costs a microsecond a step gets fewer of them than what costs a tenth of it.
constexpr double most_steps_cartesian = 320'000;  // of first order half as many
constexpr int loosest_digits = 6;                 // of rtol
constexpr double most_steps_generalized = 5'200'000;
constexpr double best_settings_steps_a_row[] = {40,
                                                80};  // of ODE with ERP 1 and the half-step start: all of its ladder

/// CPU time of the whole motion at a setting, nothing recorded, s. It takes so long that one run is enough.
double cpu_time(const Accuracy& accuracy, const Method& method, double setting) {
  const auto simulation = accuracy.at(method, setting).make(method);
  const double start = catalogue::cpu_seconds();
  simulation->run(Recorder());
  return catalogue::cpu_seconds() - start;
}

std::string setting_of(const Method& method, double setting) {
  const auto knob = catalogue::knob_of(method);
  if (knob == catalogue::Knob::none) return "-";
  return fmt::format("{} = {}", catalogue::knob_name(knob), shown(setting));
}

double most_steps_of(const Method& method) {
  if (method.inverts == SystemMatrix::mass_matrix) return most_steps_generalized;
  return most_steps_cartesian / (method.order == 1 ? 2 : 1);
}

/// From coarse to fine: steps that are halved, or tolerances that are a tenth of those before.
std::vector<double> ladder_of(const Accuracy& accuracy, const Method& method, double duration_s, double most) {
  std::vector<double> settings;
  const auto knob = catalogue::knob_of(method);
  if (knob == catalogue::Knob::none) return {0.0};
  if (knob == catalogue::Knob::rtol) {
    for (int digits = loosest_digits; digits <= 13; ++digits) settings.push_back(std::pow(10.0, -digits));
    return settings;
  }
  for (double step = accuracy.row_spacing_s(); duration_s / step <= most; step /= 2) settings.push_back(step);
  return settings;
}

/// The coarsest setting of the ladder that keeps each of the errors; the search goes on where it was.
struct Reached {
  std::optional<double> setting[std::size(asked)];
  Trial best;
  std::vector<Trial> tried;
};

/// Errors of what was tried over the number of steps, of runs that stayed finite.
report::Series series_of(std::string name, const Reached& reached, int colour) {
  report::Series series{std::move(name), {}, {}, report::Mark::line_and_points, colour};
  for (const Trial& trial : reached.tried) {
    if (!std::isfinite(trial.error) || trial.steps == 0) continue;
    series.x.push_back(static_cast<double>(trial.steps));
    series.y.push_back(trial.error);
  }
  return series;
}

Reached search(const Accuracy& accuracy, const Method& method, const std::vector<double>& ladder) {
  Reached reached;
  std::size_t next = 0;
  for (const double setting : ladder) {
    const Trial trial = accuracy.try_setting(method, setting);
    if (!(trial.error >= reached.best.error)) reached.best = trial;
    reached.tried.push_back(trial);
    while (next < std::size(asked) && trial.keeps(asked[next])) reached.setting[next++] = setting;
    if (next == std::size(asked)) break;
  }
  return reached;
}

std::string best_seen(const Method& method, const Trial& best) {
  if (!std::isfinite(best.error)) return "not reached: no run stayed finite";
  return fmt::format("not reached; best seen {} rad at {}", shown(best.error), setting_of(method, best.setting));
}

void add_cells(std::vector<Cell>& row, const Accuracy& accuracy, const Method& method, const Reached& reached) {
  for (const std::optional<double>& setting : reached.setting) {
    row.push_back(setting ? Cell(cpu_time(accuracy, method, *setting))
                          : Cell(Missing{best_seen(method, reached.best)}));
    row.emplace_back(setting ? setting_of(method, *setting) : "-");
  }
}

void add_step_findings(Findings& findings, const Method& method, const Reached& reached, double duration_s) {
  if (method.name == "ode-rk4-double" || method.name == "lagrange-symplectic-euler") {
    for (std::size_t i = 0; i < std::size(asked); ++i) {
      const std::optional<double>& setting = reached.setting[i];
      const std::string meaning =
          fmt::format("step of {} that stays within {} rad for {} s", method.name, asked[i], duration_s);
      findings.add(fmt::format("iftomm.{}_within_{}", method.name, asked[i]),
                   setting ? measured(meaning, "s", *setting) : unavailable(meaning, "s", "not reached"));
    }
  }
  if (method.name == "ode-step-double") {
    findings.add("iftomm.ode-step-double_best",
                 measured("least error of dWorldStep over the whole time among the steps tried", "rad",
                          reached.best.error, reached.best.uncertainty));
  }
}

/// Every method's row and curve.
void measure_methods(const Accuracy& accuracy, const Scenario& scenario, report::Table& table, report::Panel& panel,
                     Findings& findings) {
  for (const Method& method : catalogue::methods()) {
    if (!catalogue::does(method, scenario)) continue;
    std::vector<Cell> row{std::string(method.name)};
    if (method.make == nullptr || method.name == "lagrange-quad" || method.tells) {  // `tells`: an engine beside ODE
      const std::string why = method.make == nullptr ? "left out of this build" : "not tried: it takes minutes";
      for (int i = 0; i < 4; ++i) row.emplace_back(Missing{why});
      table.rows.push_back(std::move(row));
      continue;
    }
    const Reached reached =
        search(accuracy, method, ladder_of(accuracy, method, scenario.duration_s, most_steps_of(method)));
    add_cells(row, accuracy, method, reached);
    panel.series.push_back(series_of(std::string(method.name), reached, colour_beside_ode(method.name)));
    add_step_findings(findings, method, reached, scenario.duration_s);
    table.rows.push_back(std::move(row));
  }
}

/// The settings that claims O1 and O2 come to.
void measure_best_settings(const Scenario& scenario, report::Table& table, report::Panel& panel, Findings& findings) {
  Scenario best = scenario;
  best.ode.erp = 1;
  best.ode.start = Start::half_step;
  const Accuracy with_best(best, best.duration_s);
  const Method& engine = *available("ode-step-double");
  std::vector<double> ladder;
  for (const double steps : best_settings_steps_a_row) ladder.push_back(with_best.row_spacing_s() / steps);
  const Reached reached = search(with_best, engine, ladder);
  const std::string row_name = fmt::format("{}, ERP 1, half-step start", engine.name);
  std::vector<Cell> row{row_name};
  add_cells(row, with_best, engine, reached);
  panel.series.push_back(series_of(row_name, reached, -1));
  table.rows.push_back(std::move(row));
  const std::string meaning = fmt::format(
      "step of dWorldStep with ERP 1 and the half-step start that stays within {} rad "
      "for {} s",
      asked[0], best.duration_s);
  findings.add("iftomm.best_settings_within_0.1", reached.setting[0] ? measured(meaning, "s", *reached.setting[0])
                                                                     : unavailable(meaning, "s", "not reached"));
}

/// The library's mechanisms, and so many steps of each method: they cost ten times what those of the pendulum do.
struct MechanismCase {
  const char* problem;
  const char* scenario;
};
constexpr MechanismCase mechanisms[] = {
    {"A03 squeezer", "iftomm_squeezer"}, {"A04 Bricard", "iftomm_bricard"}, {"A05 governor", "iftomm_governor"}};
constexpr double most_steps_mechanism = 20'000;
constexpr double fewest_rows = 20;

bool is_tried(const Method& method, const Scenario& scenario) {
  return method.make != nullptr && !method.tells && catalogue::does(method, scenario);
}

void measure_mechanism(const MechanismCase& one, const Scenario& scenario, report::Table& table, Findings& findings) {
  const Accuracy accuracy(scenario, scenario.duration_s, std::fmin(0.05, scenario.duration_s / fewest_rows));
  for (const Method& method : catalogue::methods()) {
    if (!is_tried(method, scenario)) continue;
    const Reached reached =
        search(accuracy, method, ladder_of(accuracy, method, scenario.duration_s, most_steps_mechanism));
    std::vector<Cell> row{fmt::format("{}, {} s", one.problem, shown(scenario.duration_s)), std::string(method.name)};
    add_cells(row, accuracy, method, reached);
    table.rows.push_back(std::move(row));
    if (method.name != "ode-step-double" && method.name != "ode-rk4-double") continue;
    const std::string meaning =
        fmt::format("step of {} that keeps {} within {} rad", method.name, one.problem, asked[1]);
    findings.add(fmt::format("iftomm.{}_{}", one.scenario, method.name),
                 reached.setting[1] ? measured(meaning, "s", *reached.setting[1])
                                    : unavailable(meaning, "s", best_seen(method, reached.best)));
  }
}

report::Table table_of_mechanisms(Laboratory& laboratory, Findings& findings) {
  report::Table table{
      .name = "iftomm-mechanisms",
      .columns = {"problem", "method", "within 0.1 rad, CPU s", "with", "within 0.001 rad, CPU s", "with"}};
  for (const MechanismCase& one : mechanisms) {
    try {
      measure_mechanism(one, laboratory.scenario(one.scenario), table, findings);
    } catch (const UserError& error) {  // the build lacks the reference of trees
      std::vector<Cell> row{std::string(one.problem)};
      row.resize(table.columns.size(), Missing{error.what()});
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

/// What the pendulum's text says of a symplectic step.
std::string about_symplectic(const Findings& findings) {
  const std::string name = fmt::format("iftomm.lagrange-symplectic-euler_within_{}", asked[0]);
  const std::optional<double> step_s = findings.all().at(name).value;
  const std::string keeps =
      fmt::format("a symplectic step of first order, in generalized coordinates, keeps {} rad", asked[0]);
  return step_s ? fmt::format("{} at {} ms", keeps, shown(1e3 * *step_s)) : keeps + " at none";
}

}  // namespace

Content iftomm(Laboratory& laboratory, Findings& findings) {
  const Scenario& scenario = laboratory.scenario("iftomm_pendulum");
  const Accuracy accuracy(scenario, scenario.duration_s);
  report::Table table{.name = "iftomm",
                      .columns = {"method", "within 0.1 rad, CPU s", "with", "within 0.001 rad, CPU s", "with"}};
  report::Panel panel{.x_label = "steps", .y_label = "largest angle error, rad", .log_x = true, .log_y = true};
  measure_methods(accuracy, scenario, table, panel, findings);
  measure_best_settings(scenario, table, panel, findings);

  Content content;
  content.values = {{"duration", scenario.duration_s},
                    {"mass", shown(scenario.planar->links[0].mass_kg)},
                    {"length", shown(scenario.planar->links[0].length_m)},
                    {"loosest", shown(std::pow(10.0, -loosest_digits))},
                    {"rows_apart", accuracy.row_spacing_s()},
                    {"dworldstep", shown(findings.all().at("iftomm.ode-step-double_best").value.value_or(NAN))},
                    {"symplectic", about_symplectic(findings)},
                    {"most_cartesian", most_steps_cartesian},
                    {"most_generalized", most_steps_generalized},
                    {"most_best", scenario.duration_s / accuracy.row_spacing_s() * best_settings_steps_a_row[1]},
                    {"known", shown(accuracy.uncertainty())},
                    {"most_mechanism", most_steps_mechanism}};
  content.exhibits.emplace_back(report::Figure{.name = "iftomm-figure", .panels = {std::move(panel)}});
  content.exhibits.emplace_back(std::move(table));
  content.exhibits.emplace_back(table_of_mechanisms(laboratory, findings));
  return content;
}

}  // namespace odeval::experiments
