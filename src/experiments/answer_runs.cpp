#include "experiments/answer_runs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "catalogue/keeping.hpp"
#include "catalogue/timing.hpp"
#include "experiments/parts.hpp"
#include "output/number.hpp"
#include "output/summary.hpp"

namespace odeval::experiments::answers {
namespace {

constexpr int timed_rounds = 3;

/// Across the axes of ODE's friction pyramid, as fast as the file has it.
Scenario slide_across(Laboratory& laboratory) {
  Scenario scenario = laboratory.scenario("friction_slide");
  scenario.mechanism.bodies.front().velocity_m_s = {1.6, 1.2, 0};
  return scenario;
}

// clang-format off
const std::array table{
    Task{"arm", "an arm that moves freely", [](Laboratory& l) { return until(l.scenario("double_pendulum"), 2); }, "", false, quantity::max_error_q, 1e-3, "accuracy"},
    Task{"impacts", "impacts on a wall", [](Laboratory& l) { return until(l.scenario("wall_pendulum"), 2); }, "", true, quantity::max_error_q, 1e-2, "wall-pendulum"},
    Task{"chain", "a long chain", [](Laboratory& l) { return chain_of(l.scenario("chain"), 32, 1); }, " --set n=32", false, quantity::max_error_q, 1e-2, "chain"},
    Task{"sliding", "a box that slides to rest", slide_across, " --set bodies.0.velocity=[1.6,1.2,0]", false, quantity::max_error_position, 1e-2, "friction"},
    Task{"rest", "a ball that comes to rest", [](Laboratory& l) { return l.scenario("bouncing_ball"); }, "", true, quantity::max_penetration, 1e-3, "bouncing-ball"},
    Task{"tumbling", "a body that tumbles freely", [](Laboratory& l) { return until(l.scenario("free_box"), 2); }, "", false, quantity::max_error_turn, 1e-2, "free-box"},
    Task{"motor", "a motor that lifts", [](Laboratory& l) { return l.scenario("motor_lift"); }, "", false, quantity::max_error_position, 1e-3, "motor-lift"},
};
// clang-format on

/// What of ODE may be changed to keep an error, each in the file's place or in that of another choice.
std::vector<OdeSettings> choices(const Scenario& scenario, const catalogue::Method& method) {
  const bool constrained = !scenario.mechanism.joints.empty() || !scenario.mechanism.contacts.empty();
  const bool rubs = std::ranges::any_of(scenario.mechanism.contacts, [](const Contact& contact) {
    return contact.friction && contact.friction->limit > 0;
  });
  std::vector<OdeSettings> all;
  for (const double erp : erps) {
    if (!constrained && erp != erps.front()) continue;
    for (const double cfm : cfms) {
      if (!constrained && cfm != cfms.front()) continue;
      for (const FrictionAxes axes : {FrictionAxes::plane_space, FrictionAxes::sliding}) {
        if (!rubs && axes != FrictionAxes::plane_space) continue;
        for (const Start start : {Start::as_given, Start::half_step}) {
          if (start == Start::half_step && !catalogue::has_half_step_start(method)) continue;
          OdeSettings ode = scenario.ode;
          ode.erp = erp;
          ode.cfm = cfm;
          ode.friction_axes = axes;
          ode.start = start;
          all.push_back(ode);
        }
      }
    }
  }
  return all;
}

/// Times in turns what keeps the budget.
void time_all(std::span<Answer> answers, double duration_s) {
  std::vector<catalogue::TimedRun> runs;
  std::vector<Answer*> timed;
  for (Answer& answer : answers) {
    if (!answer.evaluator) continue;
    timed.push_back(&answer);
    catalogue::TimedRun run{};
    run.evaluator = &*answer.evaluator;
    run.method = answer.method;
    runs.push_back(std::move(run));
  }
  catalogue::time_in_turns(runs, timed_rounds);
  for (std::size_t i = 0; i < runs.size(); ++i) timed[i]->us_per_s = 1e6 * runs[i].median_s() / duration_s;
}

Answer answer_of(const Bench& bench, std::string_view name, bool as_it_is) {
  Answer answer{available(name)};
  if (answer.method == nullptr || !catalogue::does(*answer.method, bench.scenario())) return answer;
  answer.kept = as_it_is ? bench.largest_step(*answer.method, defaults(bench.scenario())) : bench.best(*answer.method);
  if (answer.kept.keeps) answer.evaluator.emplace(bench.at(answer.kept.step_s, answer.kept.ode));
  return answer;
}

}  // namespace

std::span<const Task> tasks() { return table; }

Scenario until(Scenario scenario, double duration_s) {
  scenario.duration_s = duration_s;
  return scenario;
}

OdeSettings defaults(const Scenario& scenario, bool single) {
  OdeSettings ode = scenario.ode;
  ode.erp = erps.front();
  ode.cfm = single ? cfms.back() : cfms.front();
  return ode;
}

Bench::Bench(const Task& task, Laboratory& laboratory) : task_(task), scenario_(task.of(laboratory)) {
  scenario_.step_s = ladder_s.front();
  scenario_.sample_s = {};
  if (task.every_step) return;
  scenario_.sample_s = rows_s;
  catalogue::Evaluator first(scenario_);
  reference_ = std::make_shared<const Reference>(first.reference());
}

catalogue::Evaluator Bench::at(double step_s, const OdeSettings& ode) const {
  Scenario scenario = scenario_;
  scenario.step_s = step_s;
  scenario.ode = ode;
  return reference_ ? catalogue::Evaluator(std::move(scenario), reference_) : catalogue::Evaluator(std::move(scenario));
}

Kept Bench::tried(const catalogue::Method& method, double step_s, const OdeSettings& ode) const {
  const catalogue::Suspects trials;  // a run that ODE complained of is no answer, and not shown
  catalogue::Evaluator evaluator = at(step_s, ode);
  const catalogue::Evaluation run = evaluator.evaluate(method);
  const Metrics metrics = evaluator.measure(run, scenario_.duration_s);
  const Quantity& row = quantities[task_.quantity];
  Kept kept{ode, step_s};
  if (run.outcome.diverged || !metrics[row.id]) return kept;
  kept.impacts = !run.outcome.impacts.empty();
  kept.error = *metrics[row.id];
  if (row.uncertainty) kept.uncertainty = metrics[*row.uncertainty].value_or(0);
  kept.keeps = suspicion(run.outcome).empty() && catalogue::keeps(kept.error, kept.uncertainty, task_.budget);
  return kept;
}

/// As at one step, and where impacts fall anywhere in it, whether the steps nearby keep the budget as well.
Kept Bench::kept_nearby(const catalogue::Method& method, double step_s, const OdeSettings& ode) const {
  Kept kept = tried(method, step_s, ode);
  if (!kept.keeps || !task_.every_step) return kept;
  kept.keeps = catalogue::kept_nearby(step_s, [&](double near_s) {
    const Kept near = tried(method, near_s, ode);
    return catalogue::Near{near.keeps, near.impacts};
  });
  return kept;
}

Kept Bench::largest_step(const catalogue::Method& method, const OdeSettings& ode, double above_s) const {
  Kept best;
  Kept coarser;
  for (const double step_s : ladder_s) {
    if (!coarser.keeps && step_s <= above_s) break;
    const Kept here = kept_nearby(method, step_s, ode);
    if (here.keeps && coarser.keeps) return coarser;
    if (here.error < best.error) best = here;
    coarser = here;
  }
  best.keeps = false;
  return best;
}

Kept Bench::best(const catalogue::Method& method) const {
  Kept best;
  for (const OdeSettings& ode : choices(scenario_, method)) {
    const Kept kept = largest_step(method, ode, best.keeps ? best.step_s : 0);
    const bool better = kept.keeps ? !best.keeps || kept.step_s > best.step_s : !best.keeps && kept.error < best.error;
    if (better) best = kept;
  }
  return best;
}

Answered answered(const Bench& bench) {
  std::array all{answer_of(bench, direct, true), answer_of(bench, direct, false), answer_of(bench, iterative, false),
                 answer_of(bench, accurate, true)};
  time_all(all, bench.scenario().duration_s);
  auto& [plain, best, iterated, fourth] = all;
  return {std::move(plain), std::move(best), std::move(iterated), std::move(fourth)};
}

bool reads(const Bench& bench, const Answer& answer, std::string_view key) {
  return catalogue::reads(*answer.method, key, bench.scenario());
}

/// What has to be typed for that run. `run` refuses what its method does not read.
std::string command_of(const Bench& bench, const Answer& answer, std::string_view settings) {
  const Task& task = bench.task();
  const Scenario& scenario = bench.scenario();
  const OdeSettings& ode = answer.kept.ode;
  std::string command =
      fmt::format("odeval run {}{} --method {} --duration {} --step {}{}", scenario.name, task.flags,
                  answer.method->name, number_text(scenario.duration_s), number_text(answer.kept.step_s),
                  task.every_step ? "" : " --sample " + number_text(rows_s));
  const auto add = [&](std::string_view key, bool differs, const std::string& flag) {
    if (differs && reads(bench, answer, key)) command += flag;
  };
  add("ode.erp", ode.erp != scenario.ode.erp, " --erp " + number_text(ode.erp));
  add("ode.cfm", ode.cfm != scenario.ode.cfm, " --cfm " + number_text(ode.cfm));
  add("ode.start", ode.start != scenario.ode.start, " --start half-step");
  add("ode.friction_axes", ode.friction_axes != scenario.ode.friction_axes, " --set ode.friction_axes=sliding");
  return command + fmt::format(" --out proofs/{}-{}", task.name, settings);  // a folder holds one setting of a method
}

/// What is changed besides step, ERP and CFM.
std::string also(const Answer& answer) {
  const OdeSettings& ode = answer.kept.ode;
  std::vector<std::string> all;
  if (ode.start == Start::half_step) all.emplace_back("half-step start");
  if (ode.friction_axes == FrictionAxes::sliding) all.emplace_back("friction along the slide");
  if (answer.method != nullptr && answer.method->name == iterative)
    all.push_back(fmt::format("{} iterations", ode.iterations));
  return all.empty() ? "-" : fmt::format("{}", fmt::join(all, ", "));
}

}  // namespace odeval::experiments::answers
