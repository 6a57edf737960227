#pragma once
// From what the user typed to a scenario file.
#include <filesystem>
#include <string>
#include <vector>

namespace odeval {

/// Names of the folder's scenarios (NAME.toml), sorted. Throws MachineError when the folder cannot be read.
std::vector<std::string> scenario_names(const std::filesystem::path& folder);

/// A word with a slash or ending as scenario and robot files do is a path and comes back as it is; any other is a name
/// in the folder. Throws UserError, with the nearest name, when the folder has none of that name.
std::filesystem::path find_scenario(const std::string& name_or_path, const std::filesystem::path& folder);

}  // namespace odeval
