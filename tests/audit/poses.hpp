#pragma once
// The file of poses that audit_plain writes.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace odeval::test {

struct Pose {
  std::array<double, 3> position{};
  std::array<double, 4> quaternion{};
};

/// All bodies of the first step, then of the next.
inline std::vector<Pose> read_poses(const std::filesystem::path& file) {
  std::vector<Pose> poses;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    auto& [p, q] = poses.emplace_back();
    std::sscanf(line.c_str(), "%la %la %la %la %la %la %la", &p[0], &p[1], &p[2], &q[0], &q[1], &q[2], &q[3]);
  }
  return poses;
}

}  // namespace odeval::test
