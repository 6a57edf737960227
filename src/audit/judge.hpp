#pragma once
// What the records of a program's runs say together.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "odeval/audit.hpp"

namespace odeval::audit {

/// The first step in which two runs of the same program differ in any bit of a pose or velocity, or in which bodies
/// there are, or that one of them does not have. Nothing: they are the same.
std::optional<Parting> parting(const std::filesystem::path& one, const std::filesystem::path& other);

struct Records {
  std::vector<std::filesystem::path> refined;  // the first is the unchanged run
  std::filesystem::path unchanged_again;       // without a ledger, which takes time of ODE's
  std::vector<int> refinements;                // of those, 1 first, rising
  std::optional<std::filesystem::path> moved;  // the unchanged run from starts that were moved
  double moved_by_m = 0;
  std::vector<std::filesystem::path> tried;           // the unchanged run with other settings
  std::vector<std::string> tried_sets;                // "erp=0.8"
  std::size_t asked = 0;                              // of those, the last ones: the user's own
  std::optional<std::filesystem::path> with_numbers;  // at the second refinement
};

/// What the unchanged run was: stepper, counts, energy, gaps, messages.
void describe(const std::filesystem::path& unchanged, Answer& answer);

/// Calls `take` with each step of a run.
void each_step(const std::filesystem::path& record, const std::function<void(const StepRow&)>& take);

/// The limit that a row of the answer is from, of places in m, of attitudes in rad.
struct LimitOf {
  std::size_t degree = 0;
  double uncertainty = 0;
  double unseen = 0;  // of that
};

/// Errors, order, horizon, steps. Refined runs are compared as far as all of them go and have the same bodies. Returns
/// the limit of each of Answer::error_at, by which those that were tried are told.
std::vector<LimitOf> judge(const Records& records, Answer& answer);

/// How far those that were tried, and the one with numbers, are from the limit, until Answer::tried_at: beyond,
/// nothing is told of them. `limits` are the judge's.
void judge_tried(const Records& records, const std::vector<LimitOf>& limits, Answer& answer);

}  // namespace odeval::audit
