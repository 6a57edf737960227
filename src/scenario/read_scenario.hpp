#pragma once
// A scenario file with the command line on top, checked.
#include <filesystem>
#include <vector>

#include "odeval/scenario.hpp"
#include "scenario/override.hpp"
#include "scenario/scenario_keys.hpp"

namespace odeval {

/// Overrides take their place in the file's tree before it is read, so a value is checked the same wherever it stands.
///
/// Names   methods and metrics the file may name
/// Throws  UserError of one line: file or flag, key, value and what would be right
Scenario read_scenario(const std::filesystem::path& file, const std::vector<Override>& overrides, const Names& names);

}  // namespace odeval
