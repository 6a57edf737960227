#pragma once
// What an experiment leaves, as bytes, to pass it from one process of this program to another.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/document.hpp"
#include "report/findings.hpp"

namespace odeval::report {

struct Outcome {
  Section section;
  std::vector<std::pair<std::string, Finding>> findings;  // by name
  std::vector<std::string> failures;
};

std::string outcome_bytes(const Outcome& outcome);

/// Bytes of `outcome_bytes` only: they are not checked.
Outcome outcome_of(std::string_view bytes);

}  // namespace odeval::report
