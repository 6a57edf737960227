// What an ODE user reads first who thinks of leaving: MuJoCo, Bullet, DART and Simbody beside ODE, task by task.
#include "experiments/should_i_switch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "catalogue/keeping.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"
#include "odeval/error.hpp"

namespace odeval::experiments {
namespace engines {
namespace {

Scenario until(Scenario scenario, double duration_s) {
  scenario.duration_s = duration_s;
  return scenario;
}

/// A slide in a direction, deg.
Scenario slide(Laboratory& laboratory, double direction_deg) {
  Scenario scenario = until(laboratory.scenario("friction_slide"), 1);
  Vec3& velocity = scenario.mechanism.bodies.front().velocity_m_s;
  const double speed = length(velocity);
  const double direction = direction_deg * std::numbers::pi / 180;
  velocity = {speed * std::cos(direction), speed * std::sin(direction), 0};
  return scenario;
}

/// The box of the slide at rest, on the level or on a slope of a part of the angle of friction.
Scenario box_at_rest(Laboratory& laboratory, double part) {
  Scenario scenario = until(laboratory.scenario("friction_slide"), 1);
  const double slope = std::atan(scenario.mechanism.contacts.front().friction.value().limit * part);
  set_slope(scenario, slope);
  Body& box = scenario.mechanism.bodies.front();
  const double half = sides_m(box.shape)[2] / 2;
  box.position_m = {half * std::sin(slope), 0, half * std::cos(slope)};
  box.attitude = Vec3{0, slope, 0};
  box.velocity_m_s = {};
  return scenario;
}

/// Three bars and four hinges that fall from rest; the middle bar is of this length.
Scenario four_bar(double middle_m) {
  Scenario scenario;
  scenario.name = "four_bar";
  scenario.duration_s = 0.6;
  const Vec3 y{0, 1, 0};
  const std::array<Vec3, 4> points{Vec3{0, 0, 0}, Vec3{0.2, 0, 0.5}, Vec3{0.2 + middle_m, 0, 0.6}, Vec3{1, 0, 0}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 along = points[i + 1] - points[i];
    scenario.mechanism.bodies.push_back({.shape = Box{{length(along), 0.05, 0.05}},
                                         .mass_kg = 1,
                                         .position_m = 0.5 * (points[i] + points[i + 1]),
                                         .attitude = Vec3{0, -std::atan2(along[2], along[0]), 0}});
    Joint joint{.kind = HingeJoint{points[i], y}, .first = i, .second = {}};
    if (i > 0) joint.second = i - 1;
    scenario.mechanism.joints.push_back(joint);
  }
  scenario.mechanism.joints.push_back({.kind = HingeJoint{points[3], y}, .first = 2, .second = {}});
  return scenario;
}

}  // namespace

namespace {

/// A scenario's file until a time.
Stage from_file(std::string label, std::string name, double until_s, quantity::Id quantity, double budget) {
  const auto of = [name = std::move(name), until_s](Laboratory& l) { return until(l.scenario(name), until_s); };
  return {fmt::format("{}, {} s", label, shown(until_s)), of, quantity, budget};
}
Stage links(std::size_t n) {
  constexpr double until_s = 0.5;
  return {fmt::format("{} links, {} s", n, shown(until_s)),
          [n](Laboratory& l) { return chain_of(l.scenario("chain"), n, until_s); }, quantity::max_error_q, 1e-2};
}
Stage slide_at(double direction_deg) {
  return {fmt::format("at {} degrees to an axis", shown(direction_deg)),
          [=](Laboratory& l) { return slide(l, direction_deg); }, quantity::max_error_position, 1e-2};
}
Stage rest_at(double part) {
  return {part > 0 ? fmt::format("a box on a slope of {} of the angle of friction", shown(part)) : "a box on the level",
          [=](Laboratory& l) { return box_at_rest(l, part); }, quantity::max_error_position, 1e-3};
}

}  // namespace

std::span<const Task> tasks() {
  const auto bars = [](double middle_m) { return [=](Laboratory&) { return four_bar(middle_m); }; };
  static const std::array all{
      Task{"joints",
           "arms that move freely",
           {from_file("double pendulum", "double_pendulum", 1, quantity::max_error_q, 1e-3),
            from_file("arm with a turntable", "three_link_arm", 0.5, quantity::max_error_turn, 1e-3),
            from_file("falling PUMA", "puma560_falling", 0.5, quantity::max_error_turn, 1e-3)},
           "switch"},
      Task{"chains", "long chains", {links(8), links(16), links(32)}, "chain"},
      Task{"loops",
           "loops of joints",
           {{"a closed loop of bars, short", bars(0.6), quantity::max_error_turn, 1e-2},
            {"a closed loop of bars, long", bars(0.8), quantity::max_error_turn, 1e-2},
            from_file("Bricard's mechanism", "iftomm_bricard", 0.6, quantity::max_error_turn, 1e-2)},
           "switch"},
      Task{"impacts",
           "impacts",
           {from_file("a ball", "bouncing_ball", 1.2, quantity::max_error_position, 2e-2),
            from_file("a link on a wall", "wall_pendulum", 1, quantity::max_error_q, 1e-2),
            from_file("Newton's cradle", "newtons_cradle", 1, quantity::max_error_position, 1e-2)},
           "wall-pendulum"},
      Task{"friction", "sliding friction", {slide_at(0), slide_at(22.5), slide_at(45)}, "friction"},
      Task{"rest", "standing still", {rest_at(0), rest_at(0.5), rest_at(0.99)}, "friction"}};
  return all;
}

std::string gain_of(const Advice& advice) {
  const std::string gain = fmt::format("{} times less CPU time", shown(advice.factor));
  if (advice.bounds == 0) return gain;
  return fmt::format("at least {} (ODE as it is keeps the error at no step on {} of {} motions)", gain, advice.bounds,
                     advice.stages);
}

std::string spread_of(const Advice& advice) {
  const auto bound = [](bool is) { return is ? "at least " : ""; };
  return fmt::format("{}{} to {}{}", bound(advice.least_is_bound), shown(advice.least), bound(advice.bounds > 0),
                     shown(advice.most));
}

namespace {

std::string name_of(const Way& way) {
  return std::string(way.method->name) + (way.settings.empty() ? "" : ": " + way.settings);
}

}  // namespace

std::string sentence_of(const Advice& advice) {
  const std::string gain = gain_of(advice);
  switch (advice.move) {
    case Move::stay:
      return "stay";
    case Move::change_a_setting:
      return fmt::format("change a setting, {}: {}", advice.settings, gain);
    case Move::accurate_step:
      return fmt::format("use accurate_step: {}", gain);
    case Move::leave:
      return fmt::format("switch to {}{}: {}", advice.method,
                         advice.settings.empty() ? "" : " (" + advice.settings + ")", gain);
  }
  return {};
}

std::string setting_of(const Way& way, const Tried& tried) {
  const bool adaptive = way.method->order == 0;
  const auto told = [&](double setting) {
    return adaptive ? fmt::format("rtol {}", shown(setting)) : fmt::format("{} ms", shown(1e3 * setting));
  };
  if (tried.keeps) return told(tried.setting);
  const std::string tried_to = fmt::format("not reached down to {}", told(tried.setting));
  if (!std::isfinite(tried.best.error)) return tried_to;
  return fmt::format("{}, least at {}", tried_to, told(tried.best_setting));
}

namespace {

report::Cell cell_of(const Found& found) {
  if (std::isfinite(found.error)) return found.error;
  return report::Missing{found.why_none};
}

/// The errors of a task, and how many motions have to keep them: "0.02 m, 0.01 rad on 3 motions".
std::string asked(const Task& task) {
  std::vector<std::string> errors;
  for (const Stage& stage : task.stages) {
    std::string error = fmt::format("{} {}", shown(stage.budget), quantities[stage.quantity].unit);
    if (std::ranges::find(errors, error) == errors.end()) errors.push_back(std::move(error));
  }
  return fmt::format("{} on {} motions", fmt::join(errors, ", "), task.stages.size());
}

/// The best that leaving does: "mujoco-rk4: 49.6 (42.6 to 60.5)".
report::Cell best_engine(std::span<const Result> results) {
  const std::map<Move, Advice> best = best_of(results);
  const auto found = best.find(Move::leave);
  if (found == best.end()) return report::Missing{"none of this build keeps the error on every motion"};
  const Advice& advice = found->second;
  return fmt::format("{}{}: {}{} ({})", advice.method, advice.settings.empty() ? "" : ", " + advice.settings,
                     advice.bounds > 0 ? "at least " : "", shown(advice.factor), spread_of(advice));
}

void add_rows(const Task& task, const Stage& stage, const Result& result, report::Table& at_error,
              report::Table& at_step) {
  const std::string unit(quantities[stage.quantity].unit);
  for (std::size_t i = 0; i < result.ways.size(); ++i) {
    const Way& way = result.ways[i];
    const Tried& tried = result.tried[i];
    const bool adaptive = way.method->order == 0;
    const report::Missing never{"no setting of the ladder keeps it"};
    const auto kept = [&](report::Cell cell) { return tried.keeps ? std::move(cell) : report::Cell(never); };
    at_error.rows.push_back({std::string(task.text), std::string(stage.label), name_of(way),
                             fmt::format("{} {}", shown(stage.budget), unit), setting_of(way, tried),
                             cell_of(tried.keeps ? tried.error : tried.best), kept(tried.us_per_s),
                             kept(factor_of(result, i))});
    if (!way.shown_at_step()) continue;
    const report::Missing own{"it chooses its own steps"};
    at_step.rows.push_back(
        {std::string(task.text), std::string(stage.label), name_of(way), unit, cell_of(tried.error_at_ms),
         cell_of({tried.drift_J, tried.error_at_ms.why_none}), cell_of({tried.us_per_step, tried.error_at_ms.why_none}),
         adaptive ? report::Cell(own) : cell_of({1e3 * tried.equal_cpu_s, tried.error_at_cpu.why_none}),
         adaptive ? report::Cell(own) : cell_of(tried.error_at_cpu)});
  }
}

/// Of three motions that between the easiest and the hardest.
constexpr std::size_t stage_drawn = 1;

/// What each makes of the energy and the angular momentum of a body that tumbles freely.
report::Table momentum(Laboratory& laboratory) {
  report::Table table{.name = "switch-momentum",
                      .columns = {"method", "angular momentum drift, N m s", "energy drift, J", "error, rad"}};
  const Scenario scenario = until(laboratory.scenario("free_box"), 2);
  catalogue::Evaluator evaluator(scenario);
  for (const Way& way : ways(scenario)) {
    if (!way.settings.empty()) continue;
    const catalogue::Evaluation run = evaluator.evaluate(*way.method);
    const Metrics metrics = evaluator.measure(run, scenario.duration_s);
    table.rows.push_back({std::string(way.method->name), finite_cell(metrics[quantity::max_angular_momentum_drift]),
                          finite_cell(metrics[quantity::max_energy_drift]),
                          finite_cell(metrics[quantity::max_error_turn])});
  }
  return table;
}

}  // namespace
}  // namespace engines

Content should_i_switch(Laboratory& laboratory, Findings& findings) {
  using namespace engines;
  report::Table table{
      .name = "switch",
      .columns = {"task", "to keep", "what to do", "times less CPU time than ODE's defaults, over the motions",
                  "best other engine, times less CPU time (over the motions)"}};
  report::Table at_error{.name = "switch-equal-error",
                         .columns = {"task", "motion", "method", "to keep", "setting", "error", "CPU time, µs a second",
                                     "CPU time of ODE as it is over that"}};
  const std::string step = fmt::format("{} ms", shown(1e3 * equal_step_s));
  report::Table at_step{
      .name = "switch-equal-step",
      .columns = {"task", "motion", "method", "unit", "error at " + step, "energy drift at " + step + ", J",
                  "CPU time, µs a step of " + step, "step of ODE's CPU time, ms", "error at ODE's CPU time"}};
  report::Figure figure{.name = "switch-figure", .columns = 3};
  for (const Task& task : tasks()) {
    table.evidence.emplace_back(task.evidence);
    const std::string meaning = fmt::format("CPU time of ODE as it is over that of the advice, {}", task.text);
    const std::string name = fmt::format("switch.{}_gain_at_equal_error", task.name);
    try {
      std::vector<Result> results;
      for (const Stage& stage : task.stages) {
        const bool drawn = &stage == &task.stages[stage_drawn];
        results.push_back(result_of(stage, laboratory, drawn));
        add_rows(task, stage, results.back(), at_error, at_step);
        if (drawn)
          figure.panels.push_back(panel_of(fmt::format("{}: {}", task.text, stage.label), stage, results.back()));
      }
      const std::optional<Advice> advice = advice_of(results);
      if (!advice) throw MachineError("nobody keeps the error on every motion");
      table.rows.push_back({std::string(task.text), asked(task), sentence_of(*advice),
                            advice->move == Move::stay ? std::string("-") : spread_of(*advice), best_engine(results)});
      findings.add(name, among(known_by(report::Source::timing, measured(meaning, "", advice->factor)),
                               {advice->least, advice->most}));
    } catch (const std::exception& error) {  // the build lacks what the task's reference needs
      table.rows.push_back(
          {std::string(task.text), asked(task), report::Missing{error.what()}, std::string("-"), std::string("-")});
      findings.add(name, unavailable(meaning, "", error.what()));
    }
  }
  std::vector<std::string> all;
  for (const catalogue::Method& method : catalogue::methods()) {
    if (method.tells) all.emplace_back(method.name);
  }
  Content content;
  content.values = {{"left_out", left_out(all)},
                    {"worth", worth},
                    {"coarsest", 1e3 * steps_tried_s().front()},
                    {"finest", 1e3 * steps_tried_s().back()},
                    {"equal", 1e3 * equal_step_s},
                    {"nearby", catalogue::nearby_percents.size()},
                    {"percent", catalogue::farthest_percent},
                    {"share", catalogue::share_where_it_hits}};
  content.exhibits.emplace_back(std::move(table));
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(at_error));
  content.exhibits.emplace_back(std::move(at_step));
  content.exhibits.emplace_back(momentum(laboratory));
  return content;
}

}  // namespace odeval::experiments
