#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "model/sdf_includes.hpp"
#include "model/toml_tree.hpp"
#include "model/xml_outline.hpp"
#include "odeval/error.hpp"
#include "odeval/part.hpp"

namespace odeval {
namespace {

/// A format: whose files, read by which function of which module, and which elements that function knows.
struct Format {
  std::string_view name;
  std::string_view package;  // of Debian
  std::array<std::string_view, 3> extensions;
  const char* function;
  const char* installed;  // the module, empty where this build has none
  const char* built;
  std::string_view root;
  std::span<const std::string_view> elements;  // that are read, below the root or at any depth ("*/")
};

constexpr std::string_view urdf_elements[]{"robot",
                                           "robot/link",
                                           "robot/link/inertial",
                                           "robot/link/inertial/origin",
                                           "robot/link/inertial/mass",
                                           "robot/link/inertial/inertia",
                                           "robot/link/collision",
                                           "robot/link/collision/origin",
                                           "robot/link/collision/geometry",
                                           "robot/link/collision/geometry/box",
                                           "robot/link/collision/geometry/sphere",
                                           "robot/link/collision/geometry/cylinder",
                                           "robot/link/collision/geometry/mesh",
                                           "robot/joint",
                                           "robot/joint/origin",
                                           "robot/joint/parent",
                                           "robot/joint/child",
                                           "robot/joint/axis",
                                           "robot/joint/limit",
                                           "robot/joint/dynamics",
                                           "robot/joint/mimic"};

constexpr std::string_view sdformat_elements[]{"sdf",
                                               "sdf/model",
                                               "sdf/gravity",
                                               "sdf/frame",
                                               "sdf/frame/pose",
                                               "sdf/model/static",
                                               "sdf/model/pose",
                                               "sdf/model/frame",
                                               "sdf/model/frame/pose",
                                               "sdf/model/link",
                                               "sdf/model/link/pose",
                                               "sdf/model/link/inertial",
                                               "sdf/model/link/inertial/pose",
                                               "sdf/model/link/inertial/mass",
                                               "sdf/model/link/inertial/inertia",
                                               "sdf/model/link/inertial/inertia/ixx",
                                               "sdf/model/link/inertial/inertia/iyy",
                                               "sdf/model/link/inertial/inertia/izz",
                                               "sdf/model/link/inertial/inertia/ixy",
                                               "sdf/model/link/inertial/inertia/ixz",
                                               "sdf/model/link/inertial/inertia/iyz",
                                               "sdf/model/link/collision",
                                               "sdf/model/link/collision/pose",
                                               "sdf/model/link/collision/geometry",
                                               "sdf/model/link/collision/geometry/box",
                                               "sdf/model/link/collision/geometry/box/size",
                                               "sdf/model/link/collision/geometry/sphere",
                                               "sdf/model/link/collision/geometry/sphere/radius",
                                               "sdf/model/link/collision/geometry/cylinder",
                                               "sdf/model/link/collision/geometry/cylinder/radius",
                                               "sdf/model/link/collision/geometry/cylinder/length",
                                               "sdf/model/link/collision/geometry/capsule",
                                               "sdf/model/link/collision/geometry/capsule/radius",
                                               "sdf/model/link/collision/geometry/capsule/length",
                                               "sdf/model/link/collision/geometry/plane",
                                               "sdf/model/link/collision/geometry/plane/normal",
                                               "sdf/model/link/collision/geometry/plane/size",
                                               "sdf/model/link/collision/geometry/mesh",
                                               "sdf/model/link/collision/geometry/mesh/uri",
                                               "sdf/model/link/collision/geometry/mesh/scale",
                                               "sdf/model/joint",
                                               "sdf/model/joint/pose",
                                               "sdf/model/joint/parent",
                                               "sdf/model/joint/child",
                                               "sdf/model/joint/axis",
                                               "sdf/model/joint/axis/xyz",
                                               "sdf/model/joint/axis/limit",
                                               "sdf/model/joint/axis/limit/lower",
                                               "sdf/model/joint/axis/limit/upper",
                                               "sdf/model/joint/axis/limit/effort",
                                               "sdf/model/joint/axis/limit/velocity",
                                               "sdf/model/joint/axis/dynamics",
                                               "sdf/model/joint/axis/dynamics/damping",
                                               "sdf/model/joint/axis/dynamics/friction",
                                               "sdf/model/joint/axis/dynamics/spring_reference",
                                               "sdf/model/joint/axis/dynamics/spring_stiffness",
                                               "sdf/model/joint/axis/use_parent_model_frame",
                                               "sdf/physics",
                                               "sdf/physics/max_step_size",
                                               "sdf/physics/ode",
                                               "sdf/physics/ode/solver",
                                               "sdf/physics/ode/solver/type",
                                               "sdf/physics/ode/solver/iters",
                                               "sdf/physics/ode/solver/sor",
                                               "sdf/physics/ode/constraints",
                                               "sdf/physics/ode/constraints/erp",
                                               "sdf/physics/ode/constraints/cfm",
                                               "sdf/physics/ode/constraints/contact_max_correcting_vel",
                                               "sdf/physics/ode/constraints/contact_surface_layer"};

constexpr std::array formats{Format{"URDF",
                                    "liburdfdom-dev",
                                    {".urdf"},
                                    "odeval_read_urdf",
                                    ODEVAL_INSTALLED_URDF,
                                    ODEVAL_BUILT_URDF,
                                    "robot",
                                    urdf_elements},
                             Format{"SDFormat",
                                    "libsdformat-dev",
                                    {".sdf", ".world"},
                                    "odeval_read_sdformat",
                                    ODEVAL_INSTALLED_SDFORMAT,
                                    ODEVAL_BUILT_SDFORMAT,
                                    "sdf",
                                    sdformat_elements}};

/// Models stand in a world or alone, and in one another; a joint's second axis is told as its first.
std::string plain_path(std::string path) {
  if (path == "sdf/world") return "sdf";
  if (path.starts_with("sdf/world/")) path.erase(4, 6);
  for (std::size_t at; (at = path.find("/model/model")) != std::string::npos;) path.erase(at, 6);
  constexpr std::string_view second = "/axis2";
  if (const std::size_t at = path.find(second); at != std::string::npos) path.erase(at + second.size() - 1, 1);
  return path;
}

const Format* format_of(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  const auto found = std::ranges::find_if(formats, [&](const Format& format) {
    return !extension.empty() && std::ranges::find(format.extensions, extension) != format.extensions.end();
  });
  return found == formats.end() ? nullptr : &*found;
}

/// What the outline has and the reader does not know; of elements within one another the outer.
void remark_unknown(Robot& robot, const Format& format, const std::map<std::string, std::size_t>& outline) {
  const auto known = [&](std::string_view path) {
    return std::ranges::find(format.elements, path) != format.elements.end();
  };
  std::map<std::string, std::size_t> plain;
  for (const auto& [path, count] : outline) plain[plain_path(path)] += count;
  for (const auto& [path, count] : plain) {
    if (known(path) || !known(path.substr(0, path.rfind('/')))) continue;
    robot.remarks.push_back({fmt::format("<{}>", path.substr(path.find('/') + 1)),
                             fmt::format("not taken, {} time{}", count, count == 1 ? "" : "s"),
                             {}});
  }
}

}  // namespace

bool is_robot_file(const std::filesystem::path& file) { return format_of(file) != nullptr; }

Robot read_robot(const std::filesystem::path& file, std::string_view text) {
  const Format& format = *format_of(file);
  const std::string whole = format.root == "sdf" ? with_includes(file, text) : std::string(text);
  RobotText reading{.file = one_line(file.string()), .text = whole};
  if (*format.installed == 0) {
    throw UserError(fmt::format("{}: this build reads no {}; install {} and build again", reading.file, format.name,
                                format.package));
  }
  const auto outline = xml_outline(reading.file, whole);
  if (!outline.contains(std::string(format.root))) {
    throw UserError(fmt::format("{}: not {}: its element <{}> is missing", reading.file, format.name, format.root));
  }
  const auto includes = [](const auto& element) { return element.first.ends_with("/include"); };
  if (std::ranges::any_of(outline, includes)) {
    throw UserError(reading.file + ": include: is not followed; put what it names into the file");
  }
  const std::string module = part_file(format.installed, format.built);
  part_function<void (*)(RobotText*)>(module, format.function, "robot files")(&reading);
  if (!reading.fault.empty()) throw UserError(one_line(reading.fault, 400));
  remark_unknown(reading.robot, format, outline);
  return std::move(reading.robot);
}

Robot read_robot(const std::filesystem::path& file) { return read_robot(file, scenario_text(file)); }

}  // namespace odeval
