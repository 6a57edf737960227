#pragma once
// From a robot's file to a scenario file.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "odeval/robot.hpp"

namespace odeval {

/// What a robot's file leaves open.
struct ImportOptions {
  bool drop_friction = false;  // of joints; else it is a motor that keeps a speed of 0
  bool base_free = false;      // the root link flies; else it is fixed in the world
  bool refuse_meshes = false;  // else a mesh is the box around it
  bool operator==(const ImportOptions&) const = default;
};

/// A robot as a scenario.
struct Imported {
  Robot robot;                                        // as it was read, with where its joints start
  std::vector<std::optional<std::size_t>> body_of{};  // of each link the number of its body; absent: part of the world
  std::string toml{};                                 // the scenario file
};

/// Fixed joints are no joints of the scenario: what they hold together is one body. Throws UserError, of one line, for
/// what can not be a scenario: links that move and have no mass, inertias of no body.
Imported import_robot(const std::filesystem::path& file, const ImportOptions& options);
/// The same of a robot that was read.
Imported import_robot(const std::filesystem::path& file, Robot robot, const ImportOptions& options);

}  // namespace odeval
