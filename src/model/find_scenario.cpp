#include "model/find_scenario.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "model/nearest.hpp"
#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"

namespace odeval {

namespace fs = std::filesystem;

std::vector<std::string> scenario_names(const fs::path& folder) {
  std::vector<std::string> names;
  try {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".toml" && entry.is_regular_file()) names.push_back(entry.path().stem().string());
    }
  } catch (const fs::filesystem_error& error) {
    throw MachineError(
        fmt::format("{}: cannot list the scenarios: {}", one_line(folder.string()), error.code().message()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path find_scenario(const std::string& name_or_path, const fs::path& folder) {
  const bool path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".toml");
  if (path || is_robot_file(name_or_path)) return name_or_path;
  const std::vector<std::string> names = scenario_names(folder);
  if (std::find(names.begin(), names.end(), name_or_path) != names.end()) return folder / (name_or_path + ".toml");
  if (names.empty()) {
    throw UserError(fmt::format("no scenario named '{}': there is no scenario file in {}", one_line(name_or_path),
                                one_line(folder.string())));
  }
  throw UserError(fmt::format("no scenario named '{}'{}; 'odeval list' shows all {}", one_line(name_or_path),
                              nearest_hint(name_or_path, names), names.size()));
}

}  // namespace odeval
