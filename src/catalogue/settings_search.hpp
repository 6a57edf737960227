#pragma once
// The cheapest settings of a method that keep a budget: its step or tolerance, and of an ODE method whatever else it
// reads that is worth a trial.
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "model/read_scenario.hpp"
#include "output/recommendation.hpp"

namespace odeval::catalogue {

/// What has to be kept, and how much is tried for it.
struct Budget {
  std::vector<Target> targets;
  double until_s = 0;
  long most_steps = 1'000'000;  // of one run; of all runs of a method ten times as many
  bool settings_too = true;     // or else the step or the tolerance alone
};

/// Searches one method after another. What a search finds depends on nothing but the file, the settings and the budget.
class SettingsSearch {
 public:
  /// `settings` are on top of the file's, and are not searched.
  SettingsSearch(const ScenarioFile& file, std::vector<Override> settings, Names names, Budget budget);

  /// As the user has it, until the budget's end.
  const Scenario& scenario() const { return scenario_; }

  /// A run of the method: with the changes, at that setting of its knob, every step of it recorded.
  Scenario scenario(const Method& method, const std::vector<Change>& changes, double setting) const;

  /// The cheapest, without its CPU time and its command. Where nothing keeps the budget, what came nearest and why.
  ///
  /// A step is taken that keeps the budget at every step of the run, and so do those nearby (keeping.hpp). Steps stand
  /// 2 % apart; a larger one that keeps the budget again, beyond ones that do not, may stay unseen.
  Recommended cheapest(const Method& method);

 private:
  friend class LadderSearch;
  friend class MethodSearch;
  std::shared_ptr<const Reference> reference_for(const Scenario& scenario);

  const ScenarioFile& file_;
  std::vector<Override> settings_;
  Names names_;
  Budget budget_;
  Scenario scenario_;

  // The true motion at any times; nothing: not looked for yet, empty: solved for each grid.
  std::optional<std::function<Reference(const SampleGrid&)>> follow_;
  using Times = std::tuple<double, long, long>;  // step, stride, rows
  std::map<Times, std::shared_ptr<const Reference>> references_;
  long rows_kept_ = 0;  // of them
};

/// From one process to another.
std::string packed(const Recommended& run);
Recommended unpacked(std::string_view bytes);

}  // namespace odeval::catalogue
