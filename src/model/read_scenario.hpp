#pragma once
// A scenario file with the command line on top, checked.
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "model/import_robot.hpp"
#include "model/override.hpp"
#include "model/scenario_keys.hpp"
#include "odeval/scenario.hpp"

namespace odeval {

/// Overrides take their place in the file's tree before it is read, so a value is checked the same wherever it stands.
///
/// Names   methods and metrics the file may name
/// Throws  UserError of one line: file or flag, key, value and what would be right
Scenario read_scenario(const std::filesystem::path& file, const std::vector<Override>& overrides, const Names& names,
                       const ImportOptions& options = {});

/// A scenario file that is loaded once and read many times, each time with other settings on top.
class ScenarioFile {
 public:
  /// A robot's file is read as the scenario file that is made of it. Throws UserError when the file cannot be read or
  /// is not TOML.
  explicit ScenarioFile(std::filesystem::path file, const ImportOptions& options = {});
  /// The same with the file's text at hand; `file` is its name.
  ScenarioFile(std::filesystem::path file, std::string_view text);
  ~ScenarioFile();
  ScenarioFile(const ScenarioFile&) = delete;
  ScenarioFile& operator=(const ScenarioFile&) = delete;

  /// As `read_scenario`.
  Scenario read(const std::vector<Override>& overrides, const Names& names) const;

  /// What a run depends on: the file with the settings on top as TOML in one spelling, without comments, keys in order,
  /// and without tolerances.
  std::string text(const std::vector<Override>& overrides) const;

 private:
  Scenario read_all(const std::vector<Override>& overrides, const Names& names) const;

  struct Tree;  // toml++ stays out of this header
  std::filesystem::path file_;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace odeval
