#pragma once
// Where bodies are at a time, and where they would be at a step of 0; what they look like.
#include <array>
#include <filesystem>
#include <map>
#include <vector>

#include "audit/judge.hpp"
#include "audit/preload/record_format.hpp"
#include "odeval/geometry.hpp"

namespace odeval::audit {

struct Place {
  Vec3 position_m{};
  std::array<double, 4> quaternion{1, 0, 0, 0};  // w, x, y, z
};

/// Of all bodies of all worlds, by their numbers from 1.
struct Scene {
  double t_s = 0;
  std::map<std::uint32_t, Place> own;    // of the unchanged run
  std::map<std::uint32_t, Place> limit;  // from the polynomial of Answer::limit_degree through the finest runs
};

/// At the first step of all runs at or after each time, which rise; those that all runs reach.
std::vector<Scene> scenes_at(const Records& records, std::size_t degree, const std::vector<double>& times);

std::vector<ShapeSample> shapes_of(const std::filesystem::path& record);

/// Against gravity, a unit vector; z where there is none.
Vec3 up_of(const std::filesystem::path& record);

}  // namespace odeval::audit
