#include "catalogue/settings_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <span>

#include "catalogue/accuracy.hpp"
#include "catalogue/engine_settings.hpp"
#include "catalogue/grid_runs.hpp"
#include "catalogue/keeping.hpp"
#include "catalogue/searched_settings.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/summary.hpp"
#include "reference/providers.hpp"

namespace odeval::catalogue {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr double apart = 1.02;        // of two steps that are tried
constexpr double longest_step_s = 1;  // that a scenario may have
constexpr long fewest_steps = 4;      // of a run
constexpr std::size_t rtols_a_decade = 16;
constexpr double loosest_rtol = 1e-2;
constexpr double tightest_rtol = 3e-15;       // below it rounding alone is larger
constexpr long rows_of_a_trial = 2'000;       // at most, where nothing hits; the answer's own run has every step
constexpr std::size_t most_unsteady = 40;     // finer steps that are tried in the place of an unsteady one
constexpr long most_steps_apart = 100'000;    // of runs with other settings, where the scenario's own keep no budget
constexpr int most_runs = 10;                 // of the most steps, for all that is tried of a method
constexpr double worth_a_change = 1.03;       // what costs less to leave as it was is left
constexpr double farthest_back = 32;          // times the steps, with one change taken back
constexpr double for_worth = 0.25;            // of all steps, for whether each change is worth it and how much
constexpr int most_stalled = 3;               // times that a finer setting was no better, one after the other
constexpr double far = 10;                    // times the budget: from there an error falls when it likes
constexpr int passes = 2;                     // over the settings, one after the other
constexpr long rows_of_references = 300'000;  // that are kept: some 100 MB

// CPU time of a QuickStep beside its iterations, in iterations: 8 of a double pendulum, 7 of an arm of three links, 10
// of a sliding box (ODE 0.16.2).
constexpr double beside_iterations = 8;

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

/// Settings of a knob from coarse to fine.
struct Ladder {
  std::vector<double> settings;
  double stride;  // how much finer the next is that is looked at while nothing keeps the budget

  std::size_t size() const { return settings.size(); }
  /// In three digits, which are easier to type, and finer than the last.
  void add(double setting) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.3g", setting);
    const double rounded = std::strtod(digits, nullptr);
    if (settings.empty() || rounded < settings.back()) settings.push_back(rounded);
  }
  /// The first that is as fine as `setting`; `size()`: none is.
  std::size_t place_of(double setting) const {
    const auto fine = [&](double other) { return other <= setting * (1 + 1e-12); };
    return static_cast<std::size_t>(std::ranges::find_if(settings, fine) - settings.begin());
  }
};

struct Tried {
  double setting = 0;
  std::vector<Reached> reached;
  long steps = 0;
  bool impacts = false;  // something hit something in it
  std::string why_not;   // what is wrong with the run but its errors
};

struct Best {
  std::vector<Change> changes;
  std::size_t place = 0;  // in the ladder
  Tried trial;
  bool kept = false;
  std::string why_not;
  Nearby nearby{};      // of what keeps it
  long most_steps = 0;  // that were tried for it
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

/// The search of one method.
class MethodSearch {
 public:
  MethodSearch(SettingsSearch& search, const Method& method)
      : search_(search),
        budget_(search.budget_),
        scenario_(search.scenario_),
        method_(method),
        knob_(knob_of(method)),
        ladder_(make_ladder()),
        searched_(what_to_search()),
        all_steps_(static_cast<double>(most_runs * budget_.most_steps)),
        steps_left_(static_cast<long>((1 - for_worth) * all_steps_)) {}

  Recommended cheapest();

 private:
  Ladder make_ladder() const;
  std::vector<Searched> what_to_search() const;
  double cost_of_step(const std::vector<Change>& changes) const;

  Tried run(const std::vector<Change>& changes, double setting, bool every_step);
  double excess(const Tried& trial) const;
  bool keeps(const Tried& trial) const;
  Tried coarsest_near(const std::vector<Change>& changes, std::size_t place);
  std::optional<Nearby> steady(const std::vector<Change>& changes, double setting);

  Best climb(const std::vector<Change>& changes, std::size_t end);
  Best descend(const std::vector<Change>& changes, std::size_t end);
  Best bisect(const std::vector<Change>& changes, long coarse, std::size_t fine, std::size_t end);
  bool improve(Best& best, const std::vector<Change>& changes);
  void try_together(Best& best);
  void try_alone(Best& best);
  long share_of_worth(const Best& best) const;
  void drop_what_is_worth_little(Best& best);
  void tell_worth(Best& best);
  std::string why_none(const Tried& nearest, bool stalled) const;

  SettingsSearch& search_;
  const Budget& budget_;
  const Scenario& scenario_;
  const Method& method_;
  Knob knob_;
  Ladder ladder_;
  std::vector<Searched> searched_;
  double all_steps_;   // of all runs
  long steps_left_;    // of what is searched now
  bool hits_ = false;  // something hit something in a run: the overlap that an impact leaves lasts a step or two
};

Ladder MethodSearch::make_ladder() const {
  Ladder ladder{{}, 2};
  if (knob_ == Knob::step) {
    const double fewest = std::max<double>(fewest_steps, std::ceil(budget_.until_s / longest_step_s));
    for (double steps = fewest; steps <= static_cast<double>(budget_.most_steps);
         steps = std::max(steps + 1, std::round(steps * apart))) {
      ladder.add(budget_.until_s / steps);
    }
  } else if (knob_ == Knob::rtol) {
    ladder.stride = 10;
    for (std::size_t n = 0;; ++n) {
      const double rtol = loosest_rtol * std::pow(10.0, -static_cast<double>(n) / double{rtols_a_decade});
      if (rtol < tightest_rtol) break;
      ladder.add(rtol);
    }
  } else {
    ladder.settings.push_back(0);
  }
  return ladder;
}

std::vector<Searched> MethodSearch::what_to_search() const {
  std::vector<Searched> searched;
  if (!budget_.settings_too) return searched;
  for (const SearchedSetting& row : searched_settings) {
    const auto is_given = [&](const Override& setting) { return overlap(setting.key, row.key); };
    const bool spring = is_of_spring(row.key) && (scenario_.ode.spring || joints_are_springs(scenario_));
    if (spring || !reads(method_, row.key, scenario_) || std::ranges::any_of(search_.settings_, is_given)) continue;
    Searched one{std::string(row.key), row.together, row.own(scenario_.ode), {}};
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
  if (!reads(method_, "ode.iterations", scenario_)) return 1;
  const auto changed = std::ranges::find(changes, "ode.iterations", &Change::key);
  const double own = scenario_.ode.iterations;
  const double now = changed == changes.end() ? own : std::stod(changed->value);
  return (beside_iterations + now) / (beside_iterations + own);
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

Tried MethodSearch::run(const std::vector<Change>& changes, double setting, bool every_step) {
  Tried trial;
  trial.setting = setting;
  trial.reached.resize(budget_.targets.size());
  try {
    Scenario scenario = search_.scenario(method_, changes, setting);
    const long steps = sample_grid(scenario).steps();
    steps_left_ -= steps;
    if (!every_step && !hits_) scenario = with_enough_rows(std::move(scenario), rows_of_a_trial);
    Evaluator evaluator(scenario, search_.reference_for(scenario));
    const Evaluation done = evaluator.evaluate(method_);
    const Metrics metrics = evaluator.measure(done, evaluator.grid().time(evaluator.grid().rows - 1));
    trial.steps = done.outcome.steps;
    trial.impacts = !done.outcome.impacts.empty() || !done.outcome.strikes.empty();
    hits_ = hits_ || trial.impacts;
    for (std::size_t i = 0; i < budget_.targets.size(); ++i) {
      const quantity::Id id = budget_.targets[i].id;
      trial.reached[i] = {metrics[id], uncertainty_of(id, metrics)};
      if (!metrics[id]) trial.why_not = "it has no " + std::string(quantities[id].name);
    }
    if (done.outcome.messages > 0) trial.why_not = "suspect: " + suspicion(done.outcome);
    if (done.outcome.diverged) trial.why_not = "diverged";
  } catch (const MachineError& why) {  // an adaptive method that gave up
    trial.why_not = why.what();
  } catch (const UserError& why) {  // settings that have no start
    trial.why_not = why.what();
  }
  return trial;
}

bool MethodSearch::keeps(const Tried& trial) const {
  if (!trial.why_not.empty()) return false;
  for (std::size_t i = 0; i < budget_.targets.size(); ++i) {
    const Reached& reached = trial.reached[i];
    if (!catalogue::keeps(*reached.value, reached.uncertainty.value_or(0), budget_.targets[i].at_most)) return false;
  }
  return true;
}

/// How many times the budget: of the worst target.
double MethodSearch::excess(const Tried& trial) const {
  double worst = 0;
  for (std::size_t i = 0; i < budget_.targets.size(); ++i) {
    const double value = trial.reached[i].value ? std::fabs(*trial.reached[i].value) : infinity;
    worst = std::max(worst, (value + trial.reached[i].uncertainty.value_or(0)) / budget_.targets[i].at_most);
  }
  return worst;
}

/// The setting that a search tries at a place of the ladder: of those that have to keep the budget with it the
/// coarsest, so that where errors grow with the step one run tells of all.
Tried MethodSearch::coarsest_near(const std::vector<Change>& changes, std::size_t place) {
  const double setting = ladder_.settings[place];
  const double near = moved(setting, farthest_percent);
  return run(changes, near > longest_step_s ? setting : near, false);
}

/// What the settings nearby leave, if all keep the budget.
std::optional<Nearby> MethodSearch::steady(const std::vector<Change>& changes, double setting) {
  Nearby nearby{0, std::vector<double>(budget_.targets.size())};
  const bool kept = kept_nearby(setting, [&](double near) {
    if (near > longest_step_s) return Near{true, false};
    const Tried trial = run(changes, near, false);
    if (!keeps(trial)) return Near{false, trial.impacts};
    ++nearby.tried;
    for (std::size_t i = 0; i < nearby.worst.size(); ++i) {
      nearby.worst[i] = std::max(nearby.worst[i], std::fabs(*trial.reached[i].value));
    }
    return Near{true, trial.impacts};
  });
  return kept ? std::optional(std::move(nearby)) : std::nullopt;
}

/// From `coarse`, which does not keep the budget (-1: nothing coarser is there), and `fine`, which does, to the
/// coarsest between them that does so steadily, before `end`.
Best MethodSearch::bisect(const std::vector<Change>& changes, long coarse, std::size_t fine, std::size_t end) {
  while (static_cast<long>(fine) - coarse > 1) {
    const auto middle = static_cast<std::size_t>((coarse + static_cast<long>(fine)) / 2);
    if (keeps(coarsest_near(changes, middle))) {
      fine = middle;
    } else {
      coarse = static_cast<long>(middle);
    }
  }
  Best best{changes, fine, {}, false, "some steps keep it, others nearby do not"};
  for (std::size_t place = fine; place < std::min(end, fine + most_unsteady); ++place) {
    best.place = place;
    const double setting = ladder_.settings[place];
    if (knob_ != Knob::none) {
      std::optional<Nearby> nearby = steady(changes, setting);
      if (!nearby) {
        if (steps_left_ < 0) break;
        continue;
      }
      best.nearby = std::move(*nearby);
    }
    best.trial = run(changes, setting, true);
    if (!keeps(best.trial)) continue;
    best.kept = true;
    best.why_not.clear();
    return best;
  }
  best.trial = coarsest_near(changes, best.place);
  return best;
}

/// From coarse to fine, until the budget is kept or nothing gets better.
Best MethodSearch::climb(const std::vector<Change>& changes, std::size_t end) {
  Best nearest{changes, 0, {}, false, ""};
  double least = infinity;
  int stalled = 0;
  long coarse = -1;
  long most_steps = 0;
  for (std::size_t place = 0; place < end;) {
    const Tried trial = coarsest_near(changes, place);
    most_steps = std::max(most_steps, trial.steps);
    if (keeps(trial)) {
      Best found = bisect(changes, coarse, place, end);
      if (found.kept) return found;
      most_steps = std::max(most_steps, found.trial.steps);
      place = found.place;  // luck so far: on to finer ones
      nearest = std::move(found);
    } else {
      const double now = excess(trial);
      stalled = now < least || least > far ? 0 : stalled + 1;
      if (now < least || place == 0) nearest = {changes, place, trial, false, ""};
      least = std::min(least, now);
      if (stalled == most_stalled) break;
    }
    coarse = static_cast<long>(place);
    const std::size_t next = ladder_.place_of(ladder_.settings[place] / ladder_.stride);
    if (next >= end && place + 1 < end) {
      place = end - 1;
    } else {
      place = std::max(next, place + 1);
    }
    if (steps_left_ < 0) break;
  }
  if (nearest.why_not.empty()) nearest.why_not = why_none(nearest.trial, stalled == most_stalled);
  nearest.most_steps = most_steps;
  return nearest;
}

std::string MethodSearch::why_none(const Tried& nearest, bool stalled) const {
  if (!nearest.why_not.empty()) return nearest.why_not;
  if (stalled) return "the error no longer falls";
  switch (knob_) {
    case Knob::step:
      return "not in " + std::to_string(budget_.most_steps) + " steps";
    case Knob::rtol:
      return "no tighter rtol is left";
    case Knob::none:
      break;
  }
  return "it has no step and no tolerance to change";
}

/// From what is just before `end` to ever coarser ones, as long as they keep the budget.
Best MethodSearch::descend(const std::vector<Change>& changes, std::size_t end) {
  if (end == 0 || !keeps(coarsest_near(changes, end - 1))) return {changes, 0, {}, false, ""};
  std::size_t fine = end - 1;
  for (std::size_t stride = 2; fine > 0; stride *= 2) {
    const std::size_t next = fine - std::min(stride, fine);
    if (!keeps(coarsest_near(changes, next))) {
      return bisect(changes, static_cast<long>(next), fine, end);
    }
    fine = next;
  }
  return bisect(changes, -1, fine, end);
}

/// Whether the changes are cheaper than the best so far, which they then are.
bool MethodSearch::improve(Best& best, const std::vector<Change>& changes) {
  if (steps_left_ < 0) return false;
  if (!best.kept) {
    const std::size_t end = ladder_.place_of(budget_.until_s / static_cast<double>(most_steps_apart));
    Best found = climb(changes, end);
    const bool nearer = found.kept || excess(found.trial) < excess(best.trial);
    if (nearer) best = std::move(found);
    return nearer;
  }
  // Fewer steps than the best's cost buys: what is worth less is left.
  const double dearer = worth_a_change * cost_of_step(changes) / cost_of_step(best.changes);
  Best found = descend(changes, ladder_.place_of(ladder_.settings[best.place] * dearer));
  if (!found.kept) return false;
  best = std::move(found);
  return true;
}

void MethodSearch::try_together(Best& best) {
  std::vector<std::vector<Change>> combinations(1);
  for (const Searched& one : searched_) {
    if (!one.together) continue;
    std::vector<std::vector<Change>> more;
    for (const std::vector<Change>& changes : combinations) {
      for (const std::string& value : one.values) more.push_back(with(changes, {one.key, one.own, value}));
    }
    combinations = std::move(more);
  }
  for (std::size_t i = 1; i < combinations.size(); ++i) improve(best, combinations[i]);
}

void MethodSearch::try_alone(Best& best) {
  for (int pass = 0; pass < passes; ++pass) {
    bool better = false;
    for (const Searched& one : searched_) {
      if (pass == 0 && one.together) continue;
      for (const std::string& value : one.values) {
        const auto now = std::ranges::find(best.changes, one.key, &Change::key);
        if (value == (now == best.changes.end() ? one.own : now->value)) continue;
        better = improve(best, with(best.changes, {one.key, one.own, value})) || better;
      }
    }
    if (!better) return;
  }
}

/// Steps to look at one change with, twice: a long search leaves none.
long MethodSearch::share_of_worth(const Best& best) const {
  return static_cast<long>(for_worth * all_steps_ / (2 * static_cast<double>(best.changes.size())));
}

/// Fewer changes at nearly the same cost are better advice.
void MethodSearch::drop_what_is_worth_little(Best& best) {
  for (std::size_t i = best.changes.size(); i-- > 0;) {
    steps_left_ = share_of_worth(best);
    const std::vector<Change> changes = without(best.changes, i);
    const double dearer = cost_of_step(changes) / cost_of_step(best.changes);
    const double finest = ladder_.settings[best.place] * dearer / worth_a_change;
    Best found = descend(changes, ladder_.place_of(finest));
    if (found.kept) best = std::move(found);
  }
}

void MethodSearch::tell_worth(Best& best) {
  for (std::size_t i = 0; i < best.changes.size(); ++i) {
    steps_left_ = share_of_worth(best);
    const std::vector<Change> changes = without(best.changes, i);
    const std::size_t end = ladder_.place_of(ladder_.settings[best.place] / farthest_back);
    const Best found = climb(changes, std::min(end + 1, ladder_.size()));
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
  Best best = climb({}, ladder_.size());
  try_together(best);
  try_alone(best);
  if (best.kept) {
    drop_what_is_worth_little(best);
    tell_worth(best);
  } else {
    best.trial = run(best.changes, ladder_.settings[best.place], false);
  }
  Recommended run;
  run.method = method_.name;
  run.kind = kind_of(method_);
  run.place = static_cast<int>(&method_ - methods().data());
  run.changes = std::move(best.changes);
  run.knob = knob_ == Knob::step ? "step" : knob_name(knob_);
  run.before = knob_ == Knob::step ? scenario_.step_s : knob_ == Knob::rtol ? method_.rtol : 0;
  run.setting = best.trial.setting;
  run.reached = std::move(best.trial.reached);
  run.steps = best.trial.steps;
  run.nearby = std::move(best.nearby);
  run.why_not = best.why_not;
  return run;
}

Recommended SettingsSearch::cheapest(const Method& method) { return MethodSearch(*this, method).cheapest(); }

}  // namespace odeval::catalogue
