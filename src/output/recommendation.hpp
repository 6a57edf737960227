#pragma once
// Which settings keep a budget, and what each is worth: for a terminal, a spreadsheet and programs.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "odeval/quantity.hpp"

namespace odeval {

/// A quantity of which less is better, and how much of it is allowed, in its unit.
struct Target {
  quantity::Id id{};
  double at_most = 0;
};

/// How far a run keeps a target.
struct Reached {
  std::optional<double> value;        // empty: the run has no such quantity
  std::optional<double> uncertainty;  // of the reference
};

/// A setting other than the scenario's own.
struct Change {
  std::string key;
  std::string before;
  std::string value;

  // With this one taken back and the others kept:
  std::optional<long> steps_without = {};  // that keep the budget; empty: none of those that were tried do
  long most_steps_without = 0;             // that were tried, where none does
  double cost_without = 0;                 // over that of the recommended run
};

/// What runs leave whose step, or tolerance, is the recommended one but for a few percent.
struct Nearby {
  int tried = 0;              // all keep the budget
  std::vector<double> worst;  // size of each target
  double share = 1;           // of the budget, that they keep
};

/// How far the search of a method came: in settings beside the step or the tolerance, each by its name.
struct Effort {
  long steps = 0;                    // of all runs
  long most_steps = 0;               // of a run, as was asked for
  int settings = 0;                  // that were looked at to the end
  std::vector<std::string> cut;      // that were begun when no steps were left
  std::vector<std::string> untried;  // that were not

  bool spent() const { return !cut.empty() || !untried.empty(); }
};

/// A method at the cheapest settings that keep the budget, or at those that come nearest.
struct Recommended {
  enum class Kind { plain_ode, accurate_step, other };

  std::string method;
  Kind kind = Kind::other;
  int place = 0;                 // in the list of methods
  std::vector<Change> changes;   // besides the step or the tolerance
  std::string knob;              // "step", "rtol" or ""
  double before = 0;             // the scenario's own; 0: none
  double setting = 0;            // of the knob
  std::vector<Reached> reached;  // one a target
  long steps = 0;
  std::string why_not;       // empty: it keeps the budget
  double cpu_per_s = 0;      // of what keeps it: CPU time of the stepping over simulated time, median
  double cpu_spread = 0;     // likewise the median absolute deviation
  std::string command = {};  // the run that proves it
  Nearby nearby = {};
  Effort effort = {};

  bool keeps() const { return why_not.empty(); }
};

struct Recommendation {
  std::string scenario;
  double until_s = 0;
  std::vector<Target> targets;
  std::vector<Recommended> runs;  // what keeps the budget, cheapest first; then what does not, nearest first
};

/// "largest angle error at most 0.01 rad, deepest overlap of a body with the ground at most 1e-04 m"
std::string budget_text(std::span<const Target> targets);

/// The answers of plain ODE, of the accurate step and of the rest, and a table of all methods.
std::string recommendation_text(const Recommendation& answer);

/// A row a method.
std::string recommendation_csv(const Recommendation& answer);

/// An object with "answers", what keeps the budget, and "others", what does not.
std::string recommendation_json(const Recommendation& answer);

}  // namespace odeval
