#include "model/mesh_box.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <vector>

#include "model/one_line.hpp"
#include "odeval/error.hpp"

namespace odeval {
namespace {

namespace fs = std::filesystem;

std::string extension_of(const std::string& mesh) {
  std::string extension = fs::path(mesh).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return extension;
}

std::vector<fs::path> folders_above(const fs::path& file) {
  std::vector<fs::path> folders;
  for (fs::path folder = fs::absolute(file).parent_path();; folder = folder.parent_path()) {
    folders.push_back(folder);
    if (folder == folder.parent_path()) return folders;
  }
}

/// Where a name with a scheme may lead.
std::vector<fs::path> candidates(const fs::path& robot, const std::string& mesh) {
  const std::size_t scheme = mesh.find("://");
  if (scheme == std::string::npos) return {fs::absolute(robot).parent_path() / mesh};
  std::string rest = mesh.substr(scheme + 3);
  if (mesh.starts_with("file://")) return {rest};
  rest.erase(0, rest.find_first_not_of('/'));  // package:///name is written as well
  std::vector<fs::path> folders = folders_above(robot);
  if (const char* paths = std::getenv("ROS_PACKAGE_PATH")) {
    std::istringstream all(paths);
    for (std::string one; std::getline(all, one, ':');) folders.emplace_back(one);
  }
  const std::string package = rest.substr(0, rest.find('/'));
  const std::string within = rest.substr(std::min(rest.size(), package.size() + 1));
  std::vector<fs::path> found;
  for (const fs::path& folder : folders) {
    found.push_back(folder / rest);
    if (folder.filename() == package) found.push_back(folder / within);
  }
  return found;
}

class Box {
 public:
  void add(const Vec3& point) {
    if (!std::ranges::all_of(point, [](double x) { return std::isfinite(x); })) return;
    for (std::size_t k = 0; k < 3; ++k) {
      low_[k] = std::fmin(low_[k], point[k]);
      high_[k] = std::fmax(high_[k], point[k]);
    }
    any_ = true;
  }
  std::optional<MeshBox> box() const {
    if (!any_) return std::nullopt;
    return MeshBox{0.5 * (low_ + high_), high_ - low_};
  }

 private:
  static constexpr double inf = std::numeric_limits<double>::infinity();
  Vec3 low_{inf, inf, inf};
  Vec3 high_{-inf, -inf, -inf};
  bool any_ = false;
};

/// 80 bytes of anything, a count, and triangles of a normal, three points and two bytes.
std::optional<MeshBox> of_binary_stl(const std::string& bytes) {
  constexpr std::size_t head = 84;
  constexpr std::size_t triangle = 50;
  std::uint32_t count = 0;
  if (bytes.size() < head) return std::nullopt;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  if (bytes.size() < head + triangle * static_cast<std::size_t>(count)) return std::nullopt;
  Box box;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 12> numbers{};
    std::memcpy(numbers.data(), bytes.data() + head + triangle * i, sizeof numbers);
    for (std::size_t k = 3; k < 12; k += 3) box.add({numbers[k], numbers[k + 1], numbers[k + 2]});
  }
  return box.box();
}

/// Lines that begin with a word and go on with three numbers.
std::optional<MeshBox> of_lines(const std::string& text, std::string_view word) {
  Box box;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream parts(line);
    parts.imbue(std::locale::classic());
    std::string first;
    Vec3 point{};
    if (parts >> first && first == word && parts >> point[0] >> point[1] >> point[2]) box.add(point);
  }
  return box.box();
}

}  // namespace

bool has_mesh_box(const std::string& mesh) {
  const std::string extension = extension_of(mesh);
  return extension == ".stl" || extension == ".obj";
}

std::optional<MeshBox> mesh_box(const fs::path& robot, const std::string& mesh, const std::string& who) {
  const auto all = candidates(robot, mesh);
  const auto file = std::ranges::find_if(all, [](const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
  });
  const std::string name = one_line(robot.string());
  if (file == all.end()) {
    throw UserError(fmt::format("{}: {}: mesh = {}: is not there; {}", name, who, one_line(mesh),
                                mesh.find("://") == std::string::npos
                                    ? "a path from the file is wanted"
                                    : "its package is wanted above the file, or in ROS_PACKAGE_PATH"));
  }
  if (!has_mesh_box(mesh)) return std::nullopt;
  std::ifstream in(*file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::optional<MeshBox> box;
  if (extension_of(mesh) == ".obj") {
    box = of_lines(bytes, "v");
  } else {
    box = of_binary_stl(bytes);
    if (!box) box = of_lines(bytes, "vertex");
  }
  if (!box) throw UserError(fmt::format("{}: {}: mesh = {}: holds no points", name, who, one_line(mesh)));
  return box;
}

}  // namespace odeval
