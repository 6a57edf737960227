#include "catalogue/settings_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "catalogue/engine_settings.hpp"
#include "catalogue/ladder_search.hpp"
#include "catalogue/searched_settings.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/summary.hpp"
#include "reference/providers.hpp"

namespace odeval::catalogue {
namespace {

constexpr long most_steps_apart = 100'000;    // of runs with other settings, where the scenario's own keep no budget
constexpr int most_runs = 10;                 // of the most steps, for all that is tried of a method
constexpr double worth_a_change = 1.03;       // what costs less to leave as it was is left
constexpr double farthest_back = 32;          // times the steps, with one change taken back
constexpr double for_worth = 0.25;            // of all steps, for whether each change is worth it and how much
constexpr double for_own = 0.5;               // of the steps before, for the scenario's own settings at first
constexpr double for_first_turns = 0.5;       // of those that are left, for a first look at all others
constexpr int passes = 2;                     // over the settings, one after the other
constexpr long rows_of_references = 300'000;  // that are kept: some 100 MB

/// What a step costs beside a solver's iterations, in iterations.
struct Iterated {
  std::string_view key;
  double beside;
  int (*own)(const Scenario&);
};
// QuickStep's: 8 of a double pendulum, 7 of an arm of three links, 10 of a sliding box (ODE 0.16.2). Bullet's, from 10,
// 110 and 1010 iterations: 30 of a double pendulum and some 25 of a sliding box of constraints, 17 of the box in joint
// coordinates (3.24).
constexpr std::array iterated{
    Iterated{"ode.iterations", 8, [](const Scenario& scenario) { return scenario.ode.iterations; }},
    Iterated{"bullet.iterations", 25, [](const Scenario& scenario) { return scenario.bullet.iterations; }}};

Recommended::Kind kind_of(const Method& method) {
  if (is_plain_ode(method.name)) return Recommended::Kind::plain_ode;
  return method.name.starts_with("ode-") ? Recommended::Kind::accurate_step : Recommended::Kind::other;
}

/// The changes with another of a key, which takes the place of one that is there; back to the scenario's own it is
/// none.
std::vector<Change> with(std::vector<Change> changes, const Change& change) {
  std::erase_if(changes, [&](const Change& other) { return other.key == change.key; });
  if (change.value != change.before) changes.push_back(change);
  return changes;
}

std::vector<Change> without(std::vector<Change> changes, std::size_t place) {
  changes.erase(changes.begin() + static_cast<std::ptrdiff_t>(place));
  return changes;
}

struct Searched {
  std::string key;
  bool together;
  std::string own;
  std::vector<std::string> values;  // the scenario's own first
};

}  // namespace

SettingsSearch::SettingsSearch(const ScenarioFile& file, std::vector<Override> settings, Names names, Budget budget)
    : file_(file),
      settings_(std::move(settings)),
      names_(std::move(names)),
      budget_(std::move(budget)),
      scenario_(file_.read(settings_, names_)) {
  scenario_.duration_s = budget_.until_s;
}

Scenario SettingsSearch::scenario(const Method& method, const std::vector<Change>& changes, double setting) const {
  std::vector<Override> settings = settings_;
  for (const Change& change : changes) settings.push_back({change.key, change.value, "--set"});
  Scenario scenario = file_.read(settings, names_);
  scenario.duration_s = budget_.until_s;
  scenario.tolerances.clear();
  set_knob(scenario, method, setting);
  if (scenario.sample_s) scenario.sample_s = scenario.step_s;
  return scenario;
}

/// Settings that were looked at, and the most steps nearby that kept the budget in the last look.
struct Begun {
  std::vector<Change> changes;
  int steadiest;
};

/// The search of one method.
class MethodSearch {
 public:
  MethodSearch(SettingsSearch& search, const Method& method)
      : search_(search),
        budget_(search.budget_),
        scenario_(search.scenario_),
        method_(method),
        steps_(search, method),
        ladder_(steps_.ladder()),
        searched_(what_to_search()),
        all_steps_(static_cast<double>(most_runs * budget_.most_steps)) {
    steps_.allow(static_cast<long>((1 - for_worth) * all_steps_));
  }

  Recommended cheapest();

 private:
  std::vector<Searched> what_to_search() const;
  double cost_of_step(const std::vector<Change>& changes) const;

  bool improve(Best& best, const std::vector<Change>& changes);
  bool improve_in_turn(Best& best, const std::vector<Change>& changes);
  std::size_t number_to_try() const;
  void note(const std::vector<Change>& changes, bool cut);
  void try_together(Best& best, const std::vector<Change>& others);
  void try_alone(Best& best);
  void try_on_own(Best& best);
  void go_on_with_cut(Best& best);
  std::vector<Change> alone_of(const std::vector<Change>& changes) const;
  Best search();
  Effort effort() const;
  long share_of_worth(const Best& best) const;
  void drop_what_is_worth_little(Best& best);
  void tell_worth(Best& best);

  SettingsSearch& search_;
  const Budget& budget_;
  const Scenario& scenario_;
  const Method& method_;
  LadderSearch steps_;
  const Ladder& ladder_;
  std::vector<Searched> searched_;
  double all_steps_;  // of all runs
  long turn_ = 0;     // steps of one
  std::vector<Begun> ended_, cut_, untried_;
};

std::vector<Searched> MethodSearch::what_to_search() const {
  std::vector<Searched> searched;
  if (!budget_.settings_too) return searched;
  for (const SearchedSetting& row : searched_settings) {
    const auto is_given = [&](const Override& setting) { return overlap(setting.key, row.key); };
    const bool spring = is_of_spring(row.key) && (scenario_.ode.spring || joints_are_springs(scenario_));
    if (spring || !reads(method_, row.key, scenario_) || std::ranges::any_of(search_.settings_, is_given)) continue;
    Searched one{std::string(row.key), row.together, row.own(scenario_), {}};
    one.values.push_back(one.own);
    for (const std::string_view value : row.values) {
      if (value != one.own) one.values.emplace_back(value);
    }
    searched.push_back(std::move(one));
  }
  return searched;
}

/// Over that of a step with the scenario's own settings.
double MethodSearch::cost_of_step(const std::vector<Change>& changes) const {
  for (const Iterated& one : iterated) {
    const auto changed = std::ranges::find(changes, one.key, &Change::key);
    if (changed == changes.end()) continue;
    return (one.beside + std::stod(changed->value)) / (one.beside + one.own(scenario_));
  }
  return 1;
}

std::shared_ptr<const Reference> SettingsSearch::reference_for(const Scenario& scenario) {
  const SampleGrid grid = sample_grid(scenario);
  const Times times{grid.step_s, grid.stride, grid.rows};
  if (const auto known = references_.find(times); known != references_.end()) return known->second;
  if (rows_kept_ + grid.rows > rows_of_references) {
    references_.clear();
    rows_kept_ = 0;
  }
  rows_kept_ += grid.rows;
  if (!follow_) follow_ = reference::follow(scenario_);
  Reference reference = *follow_ ? (*follow_)(grid) : reference::provider_for(scenario).solve(scenario, grid);
  return references_[times] = std::make_shared<const Reference>(std::move(reference));
}

void MethodSearch::note(const std::vector<Change>& changes, bool cut) {
  const auto same = [&](const Begun& other) { return settings_name(other.changes) == settings_name(changes); };
  const int steadiest = steps_.steadiest();
  std::erase_if(cut_, same);
  std::erase_if(untried_, same);
  if (std::ranges::none_of(ended_, same)) (cut ? cut_ : ended_).push_back({changes, steadiest});
}

/// Whether the changes are cheaper than the best so far, which they then are.
bool MethodSearch::improve(Best& best, const std::vector<Change>& changes) {
  if (steps_.is_spent()) {
    const auto same = [&](const Begun& other) { return settings_name(other.changes) == settings_name(changes); };
    const bool known = std::ranges::any_of(ended_, same) || std::ranges::any_of(cut_, same);
    if (!known && std::ranges::none_of(untried_, same)) untried_.push_back({changes, 0});
    return false;
  }
  if (!best.kept) {
    const double finest = budget_.until_s / static_cast<double>(most_steps_apart);
    const std::size_t end = changes.empty() ? ladder_.size() : ladder_.place_of(finest);
    Best found = steps_.climb(changes, end);
    note(changes, found.cut);
    const bool nearer = found.kept || steps_.excess(found.trial) < steps_.excess(best.trial);
    if (nearer) best = std::move(found);
    return nearer;
  }
  // Fewer steps than the best's cost buys: what is worth less is left.
  const double dearer = worth_a_change * cost_of_step(changes) / cost_of_step(best.changes);
  Best found = steps_.descend(changes, ladder_.place_of(ladder_.settings[best.place] * dearer));
  note(changes, found.cut);
  if (!found.kept) return false;
  best = std::move(found);
  return true;
}

/// As long as nothing keeps the budget, with no more steps than a turn has: where impacts make steps nearby fail by
/// chance, one that has no even ground would spend them all.
bool MethodSearch::improve_in_turn(Best& best, const std::vector<Change>& changes) {
  const long left = steps_.left();
  if (best.kept || left <= turn_) return improve(best, changes);
  steps_.allow(turn_);
  const bool better = improve(best, changes);
  steps_.allow(left - (turn_ - steps_.left()));
  return better;
}

std::size_t MethodSearch::number_to_try() const {
  std::size_t together = 1;
  std::size_t alone = 0;
  for (const Searched& one : searched_) {
    if (one.together) together *= one.values.size();
    if (!one.together) alone += one.values.size();
  }
  return together + alone;
}

/// All combinations of those settings, beside others.
void MethodSearch::try_together(Best& best, const std::vector<Change>& others) {
  std::vector<std::vector<Change>> combinations{others};
  for (const Searched& one : searched_) {
    if (!one.together) continue;
    std::vector<std::vector<Change>> more;
    for (const std::vector<Change>& changes : combinations) {
      for (const std::string& value : one.values) more.push_back(with(changes, {one.key, one.own, value}));
    }
    combinations = std::move(more);
  }
  for (std::size_t i = 1; i < combinations.size(); ++i) improve_in_turn(best, combinations[i]);
}

void MethodSearch::try_alone(Best& best) {
  for (int pass = 0; pass < passes; ++pass) {
    bool better = false;
    for (const Searched& one : searched_) {
      if (pass == 0 && one.together) continue;
      for (const std::string& value : one.values) {
        const auto now = std::ranges::find(best.changes, one.key, &Change::key);
        if (value == (now == best.changes.end() ? one.own : now->value)) continue;
        better = improve_in_turn(best, with(best.changes, {one.key, one.own, value})) || better;
      }
    }
    if (!better) return;
  }
}

/// Where none of the combinations keeps the budget, those that come nearest need not be what another setting needs.
void MethodSearch::try_on_own(Best& best) {
  for (const Searched& one : searched_) {
    if (one.together) continue;
    for (const std::string& value : one.values) {
      if (value == one.own) continue;
      improve_in_turn(best, {{one.key, one.own, value}});
      if (best.kept) return;
    }
  }
}

/// In ever longer turns, until one keeps the budget or no steps are left: in each the half that came nearest to steps
/// that all keep it nearby.
void MethodSearch::go_on_with_cut(Best& best) {
  while (!cut_.empty() && !steps_.is_spent()) {
    turn_ *= 2;
    std::vector<Begun> begun = cut_;
    std::ranges::stable_sort(begun, std::ranges::greater(), &Begun::steadiest);
    if (!best.kept) begun.resize((begun.size() + 1) / 2);
    for (const Begun& one : begun) improve_in_turn(best, one.changes);
  }
}

std::vector<Change> MethodSearch::alone_of(const std::vector<Change>& changes) const {
  std::vector<Change> alone;
  for (const Change& change : changes) {
    if (!std::ranges::find(searched_, change.key, &Searched::key)->together) alone.push_back(change);
  }
  return alone;
}

Best MethodSearch::search() {
  const long all = steps_.left();
  const bool others = !searched_.empty();
  const long own = others ? static_cast<long>(for_own * static_cast<double>(all)) : all;
  steps_.allow(own);
  Best best = steps_.climb({}, ladder_.size());
  note({}, best.cut);
  steps_.allow(all - (own - steps_.left()));
  turn_ =
      static_cast<long>(for_first_turns * static_cast<double>(steps_.left()) / static_cast<double>(number_to_try()));
  try_together(best, {});
  const bool kept_early = best.kept;
  if (!best.kept) try_on_own(best);
  if (!best.kept) try_alone(best);
  go_on_with_cut(best);
  if (best.kept) {
    if (!kept_early) try_together(best, alone_of(best.changes));
    try_alone(best);
  }
  return best;
}

Effort MethodSearch::effort() const {
  Effort effort{steps_.steps_taken(), budget_.most_steps, static_cast<int>(ended_.size()), {}, {}};
  for (const Begun& one : cut_) effort.cut.push_back(settings_name(one.changes));
  for (const Begun& one : untried_) effort.untried.push_back(settings_name(one.changes));
  return effort;
}

/// Steps to look at one change with, twice: a long search leaves none.
long MethodSearch::share_of_worth(const Best& best) const {
  return static_cast<long>(for_worth * all_steps_ / (2 * static_cast<double>(best.changes.size())));
}

/// Fewer changes at nearly the same cost are better advice.
void MethodSearch::drop_what_is_worth_little(Best& best) {
  for (std::size_t i = best.changes.size(); i-- > 0;) {
    steps_.allow(share_of_worth(best));
    const std::vector<Change> changes = without(best.changes, i);
    const double dearer = cost_of_step(changes) / cost_of_step(best.changes);
    const double finest = ladder_.settings[best.place] * dearer / worth_a_change;
    Best found = steps_.descend(changes, ladder_.place_of(finest));
    if (found.kept) best = std::move(found);
  }
}

void MethodSearch::tell_worth(Best& best) {
  for (std::size_t i = 0; i < best.changes.size(); ++i) {
    steps_.allow(share_of_worth(best));
    const std::vector<Change> changes = without(best.changes, i);
    const std::size_t end = ladder_.place_of(ladder_.settings[best.place] / farthest_back);
    const Best found = steps_.climb(changes, std::min(end + 1, ladder_.size()));
    if (!found.kept) {
      best.changes[i].most_steps_without = found.most_steps;
      continue;
    }
    best.changes[i].steps_without = found.trial.steps;
    best.changes[i].cost_without = static_cast<double>(found.trial.steps) * cost_of_step(changes) /
                                   (static_cast<double>(best.trial.steps) * cost_of_step(best.changes));
  }
}

Recommended MethodSearch::cheapest() {
  Best best = search();
  if (best.kept) {
    drop_what_is_worth_little(best);
    tell_worth(best);
  } else {
    best.trial = steps_.run(best.changes, ladder_.settings[best.place], false);
  }
  Recommended run;
  run.method = method_.name;
  run.kind = kind_of(method_);
  run.place = static_cast<int>(&method_ - methods().data());
  run.changes = std::move(best.changes);
  run.knob = steps_.knob() == Knob::step ? "step" : knob_name(steps_.knob());
  run.before = steps_.knob() == Knob::step ? scenario_.step_s : steps_.knob() == Knob::rtol ? method_.rtol : 0;
  run.setting = best.trial.setting;
  run.reached = std::move(best.trial.reached);
  run.steps = best.trial.steps;
  run.nearby = std::move(best.nearby);
  run.why_not = !best.kept && effort().spent() ? "the search spent its steps" : best.why_not;
  run.effort = effort();
  return run;
}

Recommended SettingsSearch::cheapest(const Method& method) { return MethodSearch(*this, method).cheapest(); }

}  // namespace odeval::catalogue
