// The runs behind "Should I switch?", and the rule.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "catalogue/keeping.hpp"
#include "catalogue/timing.hpp"
#include "experiments/parts.hpp"
#include "experiments/should_i_switch.hpp"
#include "output/summary.hpp"

namespace odeval::experiments::engines {
namespace {

/// Rows of every run, which all steps of the ladder fit.
constexpr double rows_s = 0.02;
constexpr double plain_erp = 0.2;  // as ODE has it where nothing sets it, and its CFM
constexpr double plain_cfm = 1e-10;
constexpr double firm_erp = 0.8;
constexpr double soft_cfm = 1e-5;
constexpr int many_iterations = 100;
constexpr std::array steps_s{0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002};
/// An error this many times the budget, and more by the order where smaller steps are left, no step of the ladder makes
/// one within it.
constexpr double hopeless = 10;
constexpr std::array rtols{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};
constexpr int rounds_told = 3;
constexpr int rounds_drawn = 1;  // a point of the figure is within a few percent, of four decades

void own(Scenario&) {}
void ode_as_it_is(Scenario& scenario) {
  scenario.ode.erp = plain_erp;
  scenario.ode.cfm = plain_cfm;
}
void firm(Scenario& scenario) {
  scenario.ode.erp = firm_erp;
  scenario.ode.cfm = plain_cfm;
}
void soft(Scenario& scenario) {
  scenario.ode.erp = plain_erp;
  scenario.ode.cfm = soft_cfm;
}
void half_step(Scenario& scenario) {
  firm(scenario);
  scenario.ode.start = Start::half_step;
}
void along_sliding(Scenario& scenario) {
  ode_as_it_is(scenario);
  scenario.ode.friction_axes = FrictionAxes::sliding;
}
void cone(Scenario& scenario) { scenario.mujoco.elliptic = true; }
void stiff(Scenario& scenario) { scenario.mujoco.time_constant_s = 2 * scenario.step_s; }  // the least there is
void stiff_cone(Scenario& scenario) {
  stiff(scenario);
  cone(scenario);
}
void patient(Scenario& scenario) { scenario.bullet.iterations = many_iterations; }
void patient_and_firm(Scenario& scenario) {
  patient(scenario);
  scenario.bullet.erp = firm_erp;
}

void patient_without_erp(Scenario& scenario) {
  patient(scenario);
  scenario.bullet.erp = 0;
}

std::vector<Way> of_ode(const Scenario& scenario, const catalogue::Method& method, const catalogue::Method& quick) {
  const bool rubs = catalogue::reads(method, "ode.friction_axes", scenario);
  const bool held = catalogue::reads(method, "ode.erp", scenario);
  std::vector<Way> ways{{&method, Move::stay, "", ode_as_it_is}};
  if (held) ways.push_back({&method, Move::change_a_setting, fmt::format("ERP {}", firm_erp), firm});
  if (held) ways.push_back({&method, Move::change_a_setting, fmt::format("CFM {}", soft_cfm), soft});
  ways.push_back({&method, Move::change_a_setting, fmt::format("half-step start and ERP {}", firm_erp), half_step});
  if (rubs) ways.push_back({&method, Move::change_a_setting, "friction along the slide", along_sliding});
  ways.push_back({&quick, Move::change_a_setting, "dWorldQuickStep", ode_as_it_is});
  return ways;
}

class Bench {
 public:
  Bench(const Stage& stage, Laboratory& laboratory) : stage_(stage), scenario_(stage.of(laboratory)) {
    scenario_.sample_s = rows_s;
    scenario_.step_s = rows_s;
    catalogue::Evaluator first(scenario_);
    reference_ = std::make_shared<const Reference>(first.reference());
  }

  const Scenario& scenario() const { return scenario_; }

  catalogue::Evaluator at(const Way& way, double setting) const { return beside(way, setting, rows_s, reference_); }

  struct Run {
    Metrics metrics{};  // none of a run that does not count
    Found found{};
    bool kept = false;  // the budget, where something hits something at the settings nearby as well
  };

  /// What is told of a setting. Chance decides at which place of a step something hits something: there the largest
  /// error of the settings nearby counts (keeping.hpp).
  Run largest(const Way& way, double setting) const {
    return worst_nearby(way, setting, run(way, setting), [](const Run&) { return false; });
  }

  /// The coarsest setting that keeps the budget where the next finer one keeps it too, and where something hits
  /// something those nearby (keeping.hpp): no luck.
  void climb(const Way& way, Tried& tried) const {
    const std::span<const double> ladder =
        way.method->order == 0 ? std::span<const double>(rtols) : std::span<const double>(steps_s);
    bool kept_before = false;
    for (const double setting : ladder) {
      Run run = this->run(way, setting);
      const bool proves = kept_before && run.kept;
      if (!proves && run.kept) run = steady(way, setting, std::move(run));
      tried.rungs.push_back({setting, run.found.error, NAN});
      if (run.found.error < tried.best.error || tried.best_setting == 0) {
        tried.best_setting = setting;
        tried.best = run.found;
      }
      if (proves) return;
      kept_before = run.kept;
      tried.keeps = kept_before;
      tried.setting = setting;
      tried.error = run.found;
      const double left = std::pow(setting / steps_s.back(), way.method->order);
      const bool last =
          way.method->order > 0 && setting <= equal_step_s && run.found.error > hopeless * left * stage_.budget;
      if (last && way.move != Move::stay) return;
    }
  }

 private:
  catalogue::Evaluator beside(const Way& way, double setting, double every_s,
                              std::shared_ptr<const Reference> reference) const {
    Scenario scenario = scenario_;
    scenario.sample_s = every_s;
    if (way.method->order == 0) {
      scenario.rtol = setting;
    } else {
      scenario.step_s = setting;
    }
    way.set(scenario);
    return {std::move(scenario), std::move(reference)};
  }

  bool keeps(const Run& run, double share = 1) const {
    const double uncertainty = uncertainty_of(stage_.quantity, run.metrics).value_or(0);
    return catalogue::keeps(run.found.error, uncertainty, share * stage_.budget);
  }

  Run run(const Way& way, double setting) const { return run(way, at(way, setting)); }

  /// What blew up does not count, nor what ODE itself complained of.
  Run run(const Way& way, catalogue::Evaluator evaluator) const {
    const catalogue::Suspects trials;
    const catalogue::Evaluation run = evaluator.evaluate(*way.method);
    if (run.outcome.diverged) return {{}, {INFINITY, "the run blew up"}};
    if (const std::string why = suspicion(run.outcome); !why.empty()) return {{}, {INFINITY, "suspect: " + why}};
    const Metrics metrics = evaluator.measure(run, scenario_.duration_s);
    Run told{metrics, {metrics[stage_.quantity].value_or(INFINITY), "nothing is told of it"}};
    told.kept = keeps(told);
    return told;
  }

  /// The run that keeps the budget least of those at a setting that keeps it and nearby, or the first that does not.
  Run steady(const Way& way, double setting, Run run) const {
    return worst_nearby(way, setting, std::move(run), [&](Run& near) {
      near.kept = keeps(near, catalogue::share_where_it_hits);
      return !near.kept;
    });
  }

  /// The run with the largest error of that one and those at the settings nearby, where something hits something; each
  /// has rows of its own, and with them a reference. Elsewhere that one. `until` is asked of each: true stops there.
  template <class Until>
  Run worst_nearby(const Way& way, double setting, Run worst, const Until& until) const {
    if (reference_->impacts.empty() || !std::isfinite(worst.found.error)) return worst;
    for (const double percent : catalogue::nearby_percents) {
      const double every_s = catalogue::moved(rows_s, percent);
      Run near = run(way, beside(way, catalogue::moved(setting, percent), every_s, reference_every(every_s)));
      if (until(near)) return near;
      if (near.found.error > worst.found.error) worst = std::move(near);
    }
    return worst;
  }

  /// The reference at other rows, solved once for all ways.
  std::shared_ptr<const Reference> reference_every(double every_s) const {
    std::shared_ptr<const Reference>& found = references_[every_s];
    if (!found) {
      Scenario scenario = scenario_;
      scenario.sample_s = scenario.step_s = every_s;
      catalogue::Evaluator solver(std::move(scenario));
      found = std::make_shared<const Reference>(solver.reference());
    }
    return found;
  }

  const Stage& stage_;
  Scenario scenario_;
  std::shared_ptr<const Reference> reference_;
  mutable std::map<double, std::shared_ptr<const Reference>> references_{};  // by the spacing of their rows, s
};

/// CPU time of a simulated second, µs, of each way at a setting of its own, in turns; 0 where that is 0, and not a
/// number where the motion is lost before its end.
std::vector<double> timed(const Bench& bench, const std::vector<Way>& ways, const std::vector<double>& settings,
                          int rounds) {
  std::vector<catalogue::Evaluator> evaluators;
  evaluators.reserve(ways.size());
  std::vector<catalogue::TimedRun> runs;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (settings[i] == 0) continue;
    evaluators.push_back(bench.at(ways[i], settings[i]));
    runs.push_back({&evaluators.back(), ways[i].method, 0, 0, {}});
  }
  time_in_turns(runs, rounds);
  std::vector<double> us_per_s;
  auto run = runs.begin();
  for (const double setting : settings) {
    if (setting == 0) {
      us_per_s.push_back(0);
      continue;
    }
    us_per_s.push_back(run->diverged.empty() ? 1e6 * run->median_s() / bench.scenario().duration_s : NAN);
    ++run;
  }
  return us_per_s;
}

/// CPU times of all that the figure shows, in turns.
void time_rungs(const Bench& bench, Result& result) {
  std::vector<Way> ways;
  std::vector<double> settings;
  std::vector<Rung*> rungs;
  for (const Curve& curve : curves_of(result)) {
    for (Rung& rung : result.tried[curve.way].rungs) {
      if (!std::isfinite(rung.error)) continue;
      ways.push_back(result.ways[curve.way]);
      settings.push_back(rung.setting);
      rungs.push_back(&rung);
    }
  }
  const std::vector<double> us_per_s = timed(bench, ways, settings, rounds_drawn);
  for (std::size_t k = 0; k < rungs.size(); ++k) rungs[k]->us_per_s = us_per_s[k];
}

}  // namespace

std::vector<Way> ways(const Scenario& scenario) {
  std::vector<Way> all =
      of_ode(scenario, catalogue::find_method("ode-step-double"), catalogue::find_method("ode-quickstep-double"));
  const auto add = [&](const catalogue::Method& method, Move move, std::string settings, void (*set)(Scenario&)) {
    if (method.make != nullptr && catalogue::does(method, scenario)) {
      all.push_back({&method, move, std::move(settings), set});
    }
  };
  add(catalogue::find_method("ode-rk4-double"), Move::accurate_step, "", own);
  for (const catalogue::Method& method : catalogue::methods()) {
    if (!method.tells || method.name.ends_with("-single")) continue;
    add(method, Move::leave, "", own);
    if (catalogue::reads(method, "mujoco.time_constant", scenario)) {
      add(method, Move::leave, "contacts as stiff as its step allows", stiff);
    }
    if (catalogue::reads(method, "mujoco.cone", scenario)) {
      add(method, Move::leave, "elliptic cone", cone);
      add(method, Move::leave, "stiff contacts, elliptic cone", stiff_cone);
    }
    const std::string iterations = fmt::format("{} iterations", many_iterations);
    if (catalogue::reads(method, "bullet.iterations", scenario)) add(method, Move::leave, iterations, patient);
    if (catalogue::reads(method, "bullet.erp", scenario)) {
      add(method, Move::leave, fmt::format("{}, ERP {}", iterations, firm_erp), patient_and_firm);
      add(method, Move::leave, iterations + ", ERP 0", patient_without_erp);
    }
  }
  return all;
}

Result result_of(const Stage& stage, Laboratory& laboratory, bool drawn) {
  const Bench bench(stage, laboratory);
  Result result{ways(bench.scenario()), {}};
  result.tried.resize(result.ways.size());
  std::vector<double> kept;
  std::vector<double> usual;
  for (std::size_t i = 0; i < result.ways.size(); ++i) {
    const Way& way = result.ways[i];
    Tried& tried = result.tried[i];
    bench.climb(way, tried);
    kept.push_back(tried.keeps || way.move == Move::stay ? tried.setting : 0);
    const double own = way.method->order == 0 ? way.method->rtol : equal_step_s;
    usual.push_back(way.shown_at_step() ? own : 0);
    if (!way.shown_at_step()) continue;
    const Bench::Run run = bench.largest(way, own);
    tried.error_at_ms = run.found;
    tried.drift_J = run.metrics[quantity::max_energy_drift].value_or(NAN);
  }
  const std::vector<double> at_error = timed(bench, result.ways, kept, rounds_told);
  const std::vector<double> at_step = timed(bench, result.ways, usual, rounds_told);
  for (std::size_t i = 0; i < result.ways.size(); ++i) {
    Tried& tried = result.tried[i];
    tried.us_per_s = at_error[i];
    tried.us_per_step = at_step[i] * equal_step_s;
    if (at_step[i] == 0 || result.ways[i].method->order == 0) continue;
    if (!std::isfinite(at_step[0] / at_step[i])) {
      tried.equal_cpu_s = NAN;
      tried.error_at_cpu = {
          NAN, fmt::format("its run at {} ms, or that of ODE as it is, ended early", shown(1e3 * equal_step_s))};
      continue;
    }
    // As many steps a row as the time of ODE's allows.
    const double rows = std::floor(rows_s / equal_step_s * at_step[0] / at_step[i]);
    tried.equal_cpu_s = rows_s / std::max(1.0, rows);
    tried.error_at_cpu = rows < 1 ? Found{INFINITY, fmt::format("a step of {} ms costs more", shown(1e3 * rows_s))}
                                  : bench.largest(result.ways[i], tried.equal_cpu_s).found;
  }
  if (drawn) time_rungs(bench, result);
  return result;
}

std::span<const double> steps_tried_s() { return steps_s; }

double factor_of(const Result& result, std::size_t way) {
  const Tried& plain = result.tried.front();
  const Tried& tried = result.tried[way];
  const bool same = result.ways[way].method == result.ways.front().method && tried.setting == plain.setting &&
                    tried.error.error == plain.error.error;
  return same ? 1 : plain.us_per_s / tried.us_per_s;
}

std::map<Move, Advice> best_of(std::span<const Result> results) {
  struct Sum {
    Advice advice;
    double log = 0;
  };
  std::map<std::pair<std::string, std::string>, Sum> sums;
  for (const Result& result : results) {
    const bool bound = !result.tried.front().keeps;
    for (std::size_t i = 0; i < result.ways.size(); ++i) {
      const Way& way = result.ways[i];
      if (!result.tried[i].keeps) continue;
      const double factor = factor_of(result, i);
      Sum& sum = sums[{std::string(way.method->name), way.settings}];
      Advice& advice = sum.advice;
      if (advice.stages++ == 0) {
        advice.move = way.move;
        advice.method = way.method->name;
        advice.settings = way.settings;
        advice.least = INFINITY;
        advice.most = 0;
      }
      if (factor < advice.least) advice.least_is_bound = bound;
      advice.least = std::min(advice.least, factor);
      advice.most = std::max(advice.most, factor);
      if (bound) ++advice.bounds;
      sum.log += std::log(factor);
    }
  }
  std::map<Move, Advice> best;  // of each move
  for (auto& [name, sum] : sums) {
    if (sum.advice.stages < results.size()) continue;
    sum.advice.factor = std::exp(sum.log / static_cast<double>(sum.advice.stages));
    const auto found = best.find(sum.advice.move);
    if (found == best.end() || found->second.factor < sum.advice.factor) best[sum.advice.move] = sum.advice;
  }
  return best;
}

std::optional<Advice> advice_of(std::span<const Result> results) {
  const std::map<Move, Advice> best = best_of(results);
  double largest = 0;
  for (const auto& [move, advice] : best) largest = std::max(largest, advice.factor);
  for (const auto& [move, advice] : best) {
    if (advice.factor * worth >= largest) return advice;
  }
  return std::nullopt;
}

}  // namespace odeval::experiments::engines
