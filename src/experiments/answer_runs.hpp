#pragma once
// "Which settings?": the kinds of task, and for each the largest step of ODE that keeps its error, with which settings,
// and what that costs.
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "catalogue/methods.hpp"
#include "experiments/experiment.hpp"

namespace odeval::experiments::answers {

inline constexpr const char* direct = "ode-step-double";
inline constexpr const char* iterative = "ode-quickstep-double";
inline constexpr const char* accurate = "ode-rk4-double";

/// Rows of every run, which all steps of the ladder fit.
inline constexpr double rows_s = 0.02;
inline constexpr std::array ladder_s{0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001, 5e-5, 2e-5, 1e-5};
// What ODE does where a program sets nothing (ode-0.16, ode/src/objects.h), first; the last CFM is that of single
// precision.
inline constexpr std::array erps{0.2, 0.8, 1.0};
inline constexpr std::array cfms{1e-10, 1e-5};
/// dWorldStep is the answer unless QuickStep costs less than this share of it.
inline constexpr double much_cheaper_percent = 50;

/// A kind of task, the scenario that stands for it, and what it has to keep.
struct Task {
  std::string_view name;  // of its findings
  std::string_view text;  // in words
  Scenario (*of)(Laboratory& laboratory);
  std::string_view flags;  // with which `odeval run` has it
  bool every_step;         // what it has to keep may be broken between rows
  quantity::Id quantity;
  double budget;  // in the quantity's unit
  std::string_view evidence;
};
/// That of an arm first.
std::span<const Task> tasks();

Scenario until(Scenario scenario, double duration_s);

/// ODE's settings where a program sets none, of either precision.
OdeSettings defaults(const Scenario& scenario, bool single = false);

/// A run that keeps the budget, or the best there was.
struct Kept {
  OdeSettings ode;
  double step_s = 0;
  double error = std::numeric_limits<double>::infinity();
  double uncertainty = 0;
  bool keeps = false;
  bool impacts = false;  // something hit something in it
};

/// A task's motion, whose reference all its runs share.
class Bench {
 public:
  Bench(const Task& task, Laboratory& laboratory);

  const Task& task() const { return task_; }
  const Scenario& scenario() const { return scenario_; }

  catalogue::Evaluator at(double step_s, const OdeSettings& ode) const;

  Kept tried(const catalogue::Method& method, double step_s, const OdeSettings& ode) const;

  /// The largest step of the ladder that keeps the budget, if the next smaller one keeps it as well: a step that keeps
  /// it by luck is none. Where impacts fall anywhere in a step, those nearby have to keep it too (keeping.hpp). Looks
  /// only for one above `above_s`.
  Kept largest_step(const catalogue::Method& method, const OdeSettings& ode, double above_s = 0) const;

  /// Of all choices that with the largest step; of equals the first, which changes least.
  Kept best(const catalogue::Method& method) const;

 private:
  Kept kept_nearby(const catalogue::Method& method, double step_s, const OdeSettings& ode) const;

  const Task& task_;
  Scenario scenario_;
  std::shared_ptr<const Reference> reference_;  // null: its rows are the steps, which differ
};

/// One method at one setting, and its time.
struct Answer {
  const catalogue::Method* method = nullptr;
  Kept kept{};
  std::optional<catalogue::Evaluator> evaluator{};
  double us_per_s = 0;  // CPU time of a simulated second
};

/// A task's answers: ODE as its defaults are, its best settings in either stepper, the fourth-order step.
struct Answered {
  Answer plain, direct, iterative, accurate;

  const Answer& best() const {
    const bool is_cheaper = iterative.kept.keeps &&
                            (!direct.kept.keeps || 100 * iterative.us_per_s < much_cheaper_percent * direct.us_per_s);
    return is_cheaper ? iterative : direct;
  }
};

/// Searches them, and times in turns what keeps the budget.
Answered answered(const Bench& bench);

/// Whether the method reads that key of the scenario file in that motion.
bool reads(const Bench& bench, const Answer& answer, std::string_view key);

/// What has to be typed for a run, in a folder of its own by the name of its settings.
std::string command_of(const Bench& bench, const Answer& answer, std::string_view settings);

/// What is changed besides step, ERP and CFM; "-": nothing.
std::string also(const Answer& answer);

}  // namespace odeval::experiments::answers
