#pragma once
// The coarsest setting of a method's step or tolerance that keeps a budget, all other settings being given.
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "catalogue/accuracy.hpp"
#include "catalogue/settings_search.hpp"

namespace odeval::catalogue {

/// Settings of a knob from coarse to fine.
struct Ladder {
  std::vector<double> settings;
  double stride;  // how much finer the next is that is looked at while nothing keeps the budget

  std::size_t size() const { return settings.size(); }
  /// In three digits, which are easier to type, and finer than the last.
  void add(double setting);
  /// The first that is as fine as `setting`; `size()`: none is.
  std::size_t place_of(double setting) const;
};

/// A run at one setting.
struct Tried {
  double setting = 0;
  std::vector<Reached> reached;
  long steps = 0;
  bool impacts = false;  // something hit something in it
  std::string why_not;   // what is wrong with the run but its errors
};

/// What a search found for some changes.
struct Best {
  std::vector<Change> changes;
  std::size_t place = 0;  // in the ladder
  Tried trial;
  bool kept = false;
  bool cut = false;  // there was more to try, but no steps for it were left
  std::string why_not;
  Nearby nearby{};      // of what keeps it
  long most_steps = 0;  // that were tried for it
};

/// Searches the ladder of one method, whatever else is changed, within a number of steps.
class LadderSearch {
 public:
  LadderSearch(SettingsSearch& search, const Method& method);

  Knob knob() const { return knob_; }
  const Ladder& ladder() const { return ladder_; }

  /// So many steps for what is searched from now on.
  void allow(long steps) { steps_left_ = steps; }
  long left() const { return steps_left_; }
  bool is_spent() const { return steps_left_ < 0; }
  /// The most steps nearby that kept the budget with some setting, since this was asked for last.
  int steadiest() { return std::exchange(steadiest_, 0); }
  /// Of all runs so far.
  long steps_taken() const { return steps_taken_; }

  /// From coarse to fine, before `end`, until the budget is kept or nothing gets better.
  Best climb(const std::vector<Change>& changes, std::size_t end);
  /// From what is just before `end` to ever coarser ones, as long as they keep the budget.
  Best descend(const std::vector<Change>& changes, std::size_t end);

  /// A run that was done before takes no steps.
  Tried run(const std::vector<Change>& changes, double setting, bool every_step);
  /// How many times the budget: of the worst target.
  double excess(const Tried& trial) const;

 private:
  Ladder make_ladder() const;
  Tried done(const std::vector<Change>& changes, double setting, bool every_step);
  bool keeps(const Tried& trial, double share = 1) const;  // that share of the budget
  Tried coarsest_near(const std::vector<Change>& changes, std::size_t place);
  std::optional<Nearby> steady(const std::vector<Change>& changes, double setting);
  Best bisect(const std::vector<Change>& changes, long coarse, std::size_t fine, std::size_t end);
  std::string why_none(const Tried& nearest, bool stalled) const;

  SettingsSearch& search_;
  const Budget& budget_;
  const Method& method_;
  Knob knob_;
  Ladder ladder_;
  long steps_left_ = 0;
  long steps_taken_ = 0;
  int steadiest_ = 0;
  std::map<std::tuple<std::string, double, bool>, Tried>
      known_;          // by changes, setting, and whether rows are every step
  bool hits_ = false;  // something hit something in a run: the overlap that an impact leaves lasts a step or two
};

/// "ode.start=half-step ode.erp=1", whatever the order they came in; without any "the scenario's own".
std::string settings_name(const std::vector<Change>& changes);

}  // namespace odeval::catalogue
