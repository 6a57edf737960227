#pragma once
// Robots' files (URDF, SDFormat) on the command line.
#include <filesystem>
#include <optional>
#include <string>

#include "cli/flags.hpp"
#include "model/import_robot.hpp"
#include "odeval/import_proof.hpp"

namespace odeval::cli {

/// `--base`, `--friction` and `--meshes`.
class RobotFlags {
 public:
  void attach(Flags& flags);
  /// Throws UserError where a flag was typed and the file is no robot's.
  ImportOptions options(const std::filesystem::path& file) const;

 private:
  struct Choice {
    std::string name;
    std::string value;  // the default until another is typed
    std::optional<Flag> flag = {};
  };
  Choice base_{"--base", "fixed"};
  Choice friction_{"--friction", "motor"};
  Choice meshes_{"--meshes", "box"};
};

/// A robot whose import is proved.
struct ProvedRobot {
  Imported imported;
  std::size_t bodies = 0;  // of the scenario
  ImportProof proof;

  std::string report() const;
  std::string json(const std::filesystem::path& file) const;
};

/// Nothing for a scenario file. Throws UserError for what can not be read, MachineError where the proof fails.
std::optional<ProvedRobot> proved_robot(const std::filesystem::path& file, const ImportOptions& options);

/// A line on standard error, of a robot's file: where what was not taken is listed.
void tell_of_import(const std::filesystem::path& file);

}  // namespace odeval::cli
