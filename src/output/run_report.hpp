#pragma once
// What `odeval run` says at its end: for people, and for programs.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "odeval/reference.hpp"
#include "output/summary.hpp"

namespace odeval {

/// The longest span over which a clock half a step fast explains most of a method's error; null: it never does.
const Metrics* half_a_step(const RunSummary& run);

/// The table of methods, that of impacts where there were any, and how to read them. `half_step_leaves` is the angle
/// error that the half-step start leaves the first method it is for, rad, where that was measured.
std::string run_report(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step,
                       const Reference& reference, const std::optional<double>& half_step_leaves = {});

/// A list of the summaries, as they stand in their files.
std::string summaries_json(const std::vector<RunSummary>& runs);

}  // namespace odeval
