#pragma once
// The box around a mesh, for the formats that are lists of points.
#include <filesystem>
#include <optional>
#include <string>

#include "odeval/geometry.hpp"

namespace odeval {

struct MeshBox {
  Vec3 centre_m{};
  Vec3 sides_m{};
};

/// Whether the format is one of those: STL and OBJ.
bool has_mesh_box(const std::string& mesh);

/// Of a mesh that a robot's file names: by a path from that file, or by package:// or model:// from a folder above it
/// or of ROS_PACKAGE_PATH. `who` names it in messages. Nothing for another format. Throws UserError for one that is not
/// there, or not what its name says.
std::optional<MeshBox> mesh_box(const std::filesystem::path& robot, const std::string& mesh, const std::string& who);

}  // namespace odeval
