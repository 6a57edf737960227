#pragma once
// "Should I switch?": ODE beside other engines, task by task: who moves what, until when, and what has to be kept.
#include <cmath>
#include <functional>
#include <map>
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

/// The steps that are tried, from the coarsest to the finest.
std::span<const double> steps_tried_s();

/// An error, or why there is none to tell.
struct Found {
  double error = INFINITY;
  std::string why_none{};
};

/// A setting of the ladder that was tried.
struct Rung {
  double setting = 0;       // step, s, or rtol
  double error = INFINITY;  // infinite where there is none to tell
  double us_per_s = NAN;    // CPU time of a simulated second, where the figure shows it
};

/// Of one way on one stage. Where something hits something an error is the largest of the settings nearby
/// (keeping.hpp), each with rows of its own; of settings that do not keep the budget that of the first run that says
/// so.
struct Tried {
  double setting = 0;         // the coarsest of the ladder that keeps the budget: step, s, or rtol
  Found error{};              // there
  bool keeps = false;         // else the setting is the finest that was tried
  double best_setting = 0;    // that with the smallest error of those tried
  Found best{};               // there
  std::vector<Rung> rungs{};  // all that were tried, from coarse to fine
  double us_per_s = 0;        // CPU time of a simulated second
  Found error_at_ms{};        // at a step of 1 ms; of a way with rtol at the engine's own
  double us_per_step = 0;     // there; not a number where the motion is lost
  double equal_cpu_s = 0;     // the step that costs what ODE as it is costs at 1 ms
  Found error_at_cpu{};       // there
  double drift_J = 0;         // of energy, at 1 ms
};

/// A stage's answers, one a way.
struct Result {
  std::vector<Way> ways;
  std::vector<Tried> tried;
};
/// `drawn`: the figure shows it, and every setting that was tried has a CPU time.
Result result_of(const Stage& stage, Laboratory& laboratory, bool drawn = false);

/// A curve of the figure.
struct Curve {
  std::string_view label;
  int colour;       // the same in all panels
  std::size_t way;  // number
};
/// ODE as it is, the accurate step, and of every other engine the way that keeps the budget at the least CPU time, or
/// where none keeps it that with the smallest error.
std::vector<Curve> curves_of(const Result& result);
/// Error over CPU time of the settings that were tried.
report::Panel panel_of(std::string title, const Stage& stage, const Result& result);

/// CPU time of ODE as it is over that of a way, both where they keep the budget. 1 where the way is the same run to the
/// last digit, of which times would tell noise. Where ODE as it is keeps the budget nowhere its time at the finest step
/// stands for it: a lower bound.
double factor_of(const Result& result, std::size_t way);

/// What to do, by how many times the CPU time of ODE as it is falls at equal error.
struct Advice {
  Move move = Move::stay;
  std::string method;    // of the way
  std::string settings;  // of the way
  double factor = 1;     // geometric mean over the stages
  double least = 1;      // over the stages
  double most = 1;
  std::size_t stages = 0;
  std::size_t bounds = 0;       // stages on which ODE as it is keeps the budget nowhere: their factors are larger
  bool least_is_bound = false;  // the least is of one of these
};
/// "switch to mujoco-rk4: 49.6 times less CPU time".
std::string sentence_of(const Advice& advice);
/// Where a way keeps the budget, or how far it was followed: "not reached down to 0.2 ms, least at 1 ms".
std::string setting_of(const Way& way, const Tried& tried);
/// "13.1 times less CPU time", or at least that.
std::string gain_of(const Advice& advice);
/// "1 to 47.6"; "at least" stands before what may be larger, as the largest of several may be once one of them is.
std::string spread_of(const Advice& advice);
/// Of less than this factor nobody has to change anything.
inline constexpr double worth = 1.5;
/// The rule: of the ways that keep the budget on every stage that with the largest mean factor; and of the moves, in
/// the order of what they ask of a program (stay, change a setting, accurate_step, leave), the first that comes within
/// `worth` of it. Nothing where no way keeps every budget.
std::optional<Advice> advice_of(std::span<const Result> results);
/// Of each move the way with the largest mean factor of those that keep the budget on every stage.
std::map<Move, Advice> best_of(std::span<const Result> results);

}  // namespace odeval::experiments::engines
