#pragma once
// A robot's file through the library that knows its format. Each library stands in a module of its own, loaded when a
// file of its format is read: a build without it says what to install.
#include <filesystem>
#include <string>
#include <string_view>

#include "odeval/robot.hpp"

namespace odeval {

/// What the reader of a module is given and gives back. Nothing is thrown across a module's border.
struct RobotText {
  std::string file;       // for messages
  std::string_view text;  // whole
  Robot robot{};          // what was read
  std::string fault{};    // or what is wrong, with the file's name: one line
};

/// URDF or SDFormat by the file's name.
bool is_robot_file(const std::filesystem::path& file);

/// Throws UserError, of one line, for what is no such file, and where this build has no reader for it.
Robot read_robot(const std::filesystem::path& file);
/// The same with the text at hand.
Robot read_robot(const std::filesystem::path& file, std::string_view text);

/// In the modules.
extern "C" {
void odeval_read_urdf(RobotText* text);
void odeval_read_sdformat(RobotText* text);
}

}  // namespace odeval
