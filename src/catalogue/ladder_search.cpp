#include "catalogue/ladder_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "catalogue/grid_runs.hpp"
#include "catalogue/keeping.hpp"
#include "odeval/error.hpp"
#include "output/summary.hpp"

namespace odeval::catalogue {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double apart = 1.02;        // of two steps that are tried
constexpr double longest_step_s = 1;  // that a scenario may have
constexpr long fewest_steps = 4;      // of a run
constexpr std::size_t rtols_a_decade = 16;
constexpr double loosest_rtol = 1e-2;
constexpr double tightest_rtol = 3e-15;    // below it rounding alone is larger
constexpr long rows_of_a_trial = 2'000;    // at most, where nothing hits; the answer's own run has every step
constexpr std::size_t most_unsteady = 40;  // finer steps that are tried in the place of an unsteady one
constexpr int most_stalled = 3;            // times that a finer setting was no better, one after the other
constexpr double far = 10;                 // times the budget: from there an error falls when it likes

}  // namespace

void Ladder::add(double setting) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g", setting);
  const double rounded = std::strtod(digits, nullptr);
  if (settings.empty() || rounded < settings.back()) settings.push_back(rounded);
}

std::size_t Ladder::place_of(double setting) const {
  const auto fine = [&](double other) { return other <= setting * (1 + 1e-12); };
  return static_cast<std::size_t>(std::ranges::find_if(settings, fine) - settings.begin());
}

LadderSearch::LadderSearch(SettingsSearch& search, const Method& method)
    : search_(search), budget_(search.budget_), method_(method), knob_(knob_of(method)), ladder_(make_ladder()) {}

Ladder LadderSearch::make_ladder() const {
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

std::string settings_name(const std::vector<Change>& changes) {
  std::vector<std::string> words;
  for (const Change& change : changes) words.push_back(change.key + "=" + change.value);
  std::ranges::sort(words);
  std::string name;
  for (const std::string& word : words) name += (name.empty() ? "" : " ") + word;
  return name.empty() ? "the scenario's own" : name;
}

Tried LadderSearch::run(const std::vector<Change>& changes, double setting, bool every_step) {
  const std::tuple key{settings_name(changes), setting, every_step || hits_};
  if (const auto before = known_.find(key); before != known_.end()) return before->second;
  Tried trial = done(changes, setting, every_step);
  known_.emplace(key, trial);
  return trial;
}

Tried LadderSearch::done(const std::vector<Change>& changes, double setting, bool every_step) {
  Tried trial;
  trial.setting = setting;
  trial.reached.resize(budget_.targets.size());
  try {
    Scenario scenario = search_.scenario(method_, changes, setting);
    const long steps = sample_grid(scenario).steps();
    steps_left_ -= steps;
    steps_taken_ += steps;
    if (!every_step && !hits_) scenario = with_enough_rows(std::move(scenario), rows_of_a_trial);
    Evaluator evaluator(scenario, search_.reference_for(scenario));
    const Evaluation done = evaluator.evaluate(method_);
    const Metrics metrics = evaluator.measure(done, evaluator.grid().time(evaluator.grid().rows - 1));
    trial.steps = done.outcome.steps;
    const bool hits = !done.outcome.impacts.empty() || !done.outcome.strikes.empty();
    hits_ = hits_ || hits;
    trial.impacts = hits || !scenario.mechanism.contacts.empty();  // impacts of [[contacts]] are not told
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

bool LadderSearch::keeps(const Tried& trial, double share) const {
  if (!trial.why_not.empty()) return false;
  for (std::size_t i = 0; i < budget_.targets.size(); ++i) {
    const Reached& reached = trial.reached[i];
    if (!catalogue::keeps(*reached.value, reached.uncertainty.value_or(0), share * budget_.targets[i].at_most))
      return false;
  }
  return true;
}

double LadderSearch::excess(const Tried& trial) const {
  double worst = 0;
  for (std::size_t i = 0; i < budget_.targets.size(); ++i) {
    const double value = trial.reached[i].value ? std::fabs(*trial.reached[i].value) : infinity;
    worst = std::max(worst, (value + trial.reached[i].uncertainty.value_or(0)) / budget_.targets[i].at_most);
  }
  return worst;
}

/// The setting that a search tries at a place of the ladder: of those that have to keep the budget with it the
/// coarsest, so that where errors grow with the step one run tells of all.
Tried LadderSearch::coarsest_near(const std::vector<Change>& changes, std::size_t place) {
  const double setting = ladder_.settings[place];
  const double near = moved(setting, farthest_percent);
  return run(changes, near > longest_step_s ? setting : near, false);
}

/// What the settings nearby leave, if all keep the budget.
std::optional<Nearby> LadderSearch::steady(const std::vector<Change>& changes, double setting) {
  Nearby nearby{0, std::vector<double>(budget_.targets.size())};
  const bool kept = kept_nearby(setting, [&](double near) {
    if (near > longest_step_s) return Near{true, false};
    const Tried trial = run(changes, near, false);
    const double share = trial.impacts ? share_where_it_hits : 1;
    if (!keeps(trial, share)) return Near{false, trial.impacts};
    ++nearby.tried;
    steadiest_ = std::max(steadiest_, nearby.tried);
    nearby.share = std::min(nearby.share, share);
    for (std::size_t i = 0; i < nearby.worst.size(); ++i) {
      nearby.worst[i] = std::max(nearby.worst[i], std::fabs(*trial.reached[i].value));
    }
    return Near{true, trial.impacts};
  });
  return kept ? std::optional(std::move(nearby)) : std::nullopt;
}

/// From `coarse`, which does not keep the budget (-1: nothing coarser is there), and `fine`, which does, to the
/// coarsest between them that does so steadily, before `end`.
Best LadderSearch::bisect(const std::vector<Change>& changes, long coarse, std::size_t fine, std::size_t end) {
  while (static_cast<long>(fine) - coarse > 1) {
    const auto middle = static_cast<std::size_t>((coarse + static_cast<long>(fine)) / 2);
    if (keeps(coarsest_near(changes, middle))) {
      fine = middle;
    } else {
      coarse = static_cast<long>(middle);
    }
  }
  Best best{changes, fine, {}, false, false, "some steps keep it, others nearby do not"};
  for (std::size_t place = fine; place < std::min(end, fine + most_unsteady); ++place) {
    best.place = place;
    const double setting = ladder_.settings[place];
    if (knob_ != Knob::none) {
      std::optional<Nearby> nearby = steady(changes, setting);
      if (!nearby) {
        best.cut = steps_left_ < 0;
        if (best.cut) break;
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

Best LadderSearch::climb(const std::vector<Change>& changes, std::size_t end) {
  Best nearest{changes, 0, {}, false, false, ""};
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
      if (now < least || place == 0) nearest = {changes, place, trial, false, false, ""};
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
    nearest.cut = nearest.cut || (steps_left_ < 0 && place < end);
    if (nearest.cut) break;
  }
  if (nearest.cut) nearest.why_not = "the search spent its steps";
  if (nearest.why_not.empty()) nearest.why_not = why_none(nearest.trial, stalled == most_stalled);
  nearest.most_steps = most_steps;
  return nearest;
}

std::string LadderSearch::why_none(const Tried& nearest, bool stalled) const {
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

Best LadderSearch::descend(const std::vector<Change>& changes, std::size_t end) {
  if (end == 0 || !keeps(coarsest_near(changes, end - 1))) return {changes, 0, {}, false, false, ""};
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

}  // namespace odeval::catalogue
