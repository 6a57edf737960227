#pragma once
// "Should I switch?": ODE beside other engines, task by task: who moves what, until when, and what has to be kept.
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/experiment.hpp"

namespace odeval::experiments::engines {

/// A motion that a task is tried on.
struct Stage {
  std::string label;
  std::function<Scenario(Laboratory& laboratory)> of;
  quantity::Id quantity;  // that has to be kept
  double budget;          // in its unit
};

/// A kind of task, and the motions over which its numbers spread.
struct Task {
  std::string_view name;  // of its findings
  std::string_view text;  // in words
  std::vector<Stage> stages;
  std::string_view evidence;
};
std::span<const Task> tasks();

/// What somebody may do who has ODE as it is.
enum class Move { stay, change_a_setting, accurate_step, leave };

/// Where methods are compared at equal step.
inline constexpr double equal_step_s = 1e-3;

/// A method with settings of its own.
struct Way {
  const catalogue::Method* method;
  Move move;
  std::string settings;  // in words; empty: the engine's own
  void (*set)(Scenario&);

  /// At equal step: engines with their own settings, ODE with any.
  bool shown_at_step() const { return settings.empty() || move == Move::change_a_setting; }
};
/// All that this build has for a scenario: ODE as it is first. `setting` of the ladder below is a step in s, or rtol.
std::vector<Way> ways(const Scenario& scenario);

/// Of one way on one stage.
struct Tried {
  double setting = 0;       // the coarsest of the ladder that keeps the budget: step, s, or rtol
  double error = 0;         // there
  bool keeps = false;       // else the setting is the finest
  double us_per_s = 0;      // CPU time of a simulated second
  double error_at_ms = 0;   // at a step of 1 ms; of a way with rtol at the engine's own
  double us_per_step = 0;   // there; not a number where the motion is lost
  double equal_cpu_s = 0;   // the step that costs what ODE as it is costs at 1 ms
  double error_at_cpu = 0;  // there
  double drift_J = 0;       // of energy, at 1 ms
};

/// A stage's answers, one a way.
struct Result {
  std::vector<Way> ways;
  std::vector<Tried> tried;
};
Result result_of(const Stage& stage, Laboratory& laboratory);

/// What to do, by how many times the CPU time of ODE as it is falls at equal error.
struct Advice {
  Move move = Move::stay;
  std::string method;    // of the way
  std::string settings;  // of the way
  double factor = 1;     // geometric mean over the stages
  double least = 1;      // over the stages
  double most = 1;
  bool at_least = false;  // ODE as it is keeps some budget at no step: of its CPU time only a lower bound is known
};
/// Of less than this factor nobody has to change anything.
inline constexpr double worth = 1.5;
/// The rule: of the ways that keep the budget on every stage that with the largest mean factor; and of the moves, in
/// the order of what they ask of a program (stay, change a setting, accurate_step, leave), the first that comes within
/// `worth` of it. Nothing where no way keeps every budget.
std::optional<Advice> advice_of(std::span<const Result> results);

}  // namespace odeval::experiments::engines
