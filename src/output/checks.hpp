#pragma once
// Tolerances beside what was measured.
#include <optional>
#include <string>
#include <vector>

#include "odeval/scenario.hpp"

namespace odeval {

struct CheckRow {
  enum class Verdict { kept, failed, undecided, left_out };

  std::string scenario;
  Tolerance tolerance;
  std::optional<double> measured;  // empty: the metric has no meaning for the run
  std::optional<double> reference_uncertainty;
  Verdict verdict = Verdict::failed;  // undecided: the bound lies within the uncertainty; left_out: not in this build
  std::string reference{};            // what the reference is, where that is a word of warning; else empty
  std::string suspect{};              // what ODE itself said of the run; empty: nothing
};

std::string checks_table(const std::vector<CheckRow>& rows);
std::string checks_json(const std::vector<CheckRow>& rows);

}  // namespace odeval
