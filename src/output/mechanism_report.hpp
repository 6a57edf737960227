#pragma once
// What a mechanism's runs tell beside errors: works, motors, stops, gaps of joints.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "odeval/trace.hpp"
#include "output/summary.hpp"

namespace odeval {

/// What is told of a mechanism's parts at the end of a run; nothing where they have no names.
PartsSummary parts_of(const Scenario& scenario, const Trace& trace);

/// Tables of works, motors, strikes and gaps, those that there are, each after an empty line. `reference` are the
/// strikes to compare with, joint by joint, number by number.
std::string mechanism_tables(const std::vector<RunSummary>& runs, const std::vector<StopStrike>& reference);

/// Adds to a summary what there is of them.
void put_parts(nlohmann::ordered_json& json, const RunSummary& run);

}  // namespace odeval
