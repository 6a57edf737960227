#pragma once
// What `odeval run` says at its end: for people, and for programs.
#include <span>
#include <string>
#include <vector>

#include "odeval/reference.hpp"
#include "output/summary.hpp"

namespace odeval {

/// The table of methods, that of impacts where there were any, and how to read them.
std::string run_report(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step,
                       const Reference& reference);

/// A list of the summaries, as they stand in their files.
std::string summaries_json(const std::vector<RunSummary>& runs);

}  // namespace odeval
