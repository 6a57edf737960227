// URDF by urdfdom, in a module of its own.
#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"

namespace odeval {
namespace {

/// Keeps what the library would print, for as long as it lives.
class Complaints final : public console_bridge::OutputHandler {
 public:
  Complaints() { console_bridge::useOutputHandler(this); }
  ~Complaints() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) lines_.push_back(one_line(text, 160));
    if (level == console_bridge::CONSOLE_BRIDGE_LOG_WARN) warnings_.push_back(one_line(text, 160));
  }
  bool any() const { return !lines_.empty(); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// The first tells the cause, the second where.
  std::string text() const {
    if (lines_.empty()) return "cannot be read";
    return lines_.size() == 1 ? lines_[0] : lines_[0] + "; " + lines_[1];
  }

 private:
  std::vector<std::string> lines_;
  std::vector<std::string> warnings_;
};

Vec3 ours(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Frame ours(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return {ours(pose.position), rotation_of_quaternion(r.w, r.x, r.y, r.z)};
}

struct SolidOf {
  using Form = Robot::Solid::Form;
  Robot::Solid operator()(const urdf::Geometry& geometry) const {
    switch (geometry.type) {
      case urdf::Geometry::BOX:
        return {.form = Form::box, .frame = {}, .sides_m = ours(static_cast<const urdf::Box&>(geometry).dim)};
      case urdf::Geometry::SPHERE: {
        const double d = 2 * static_cast<const urdf::Sphere&>(geometry).radius;
        return {.form = Form::sphere, .frame = {}, .sides_m = {d, d, d}};
      }
      case urdf::Geometry::CYLINDER: {
        const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
        return {.form = Form::cylinder,
                .frame = {},
                .sides_m = {2 * cylinder.radius, 2 * cylinder.radius, cylinder.length}};
      }
      case urdf::Geometry::MESH: {
        const auto& mesh = static_cast<const urdf::Mesh&>(geometry);
        return {.form = Form::mesh, .frame = {}, .file = mesh.filename, .scale = ours(mesh.scale)};
      }
    }
    return {.form = Form::other, .frame = {}, .file = "a shape of another kind"};
  }
};

Robot::Link link_of(const urdf::Link& link) {
  Robot::Link made{.name = link.name};
  if (link.inertial) {
    const urdf::Inertial& i = *link.inertial;
    made.mass = Robot::Mass{i.mass, ours(i.origin), {i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz}};
  }
  for (const auto& collision : link.collision_array) {
    if (!collision || !collision->geometry) continue;
    Robot::Solid solid = SolidOf{}(*collision->geometry);
    solid.frame = ours(collision->origin);
    solid.name = collision->name;
    made.solids.push_back(std::move(solid));
  }
  return made;
}

class Reading {
 public:
  Reading(RobotText& text, const urdf::ModelInterface& model) : text_(text), robot_(text.robot), model_(model) {}

  void read() {
    robot_.name = model_.getName();
    robot_.format = "URDF";
    check_parents();
    const urdf::Link& root = *model_.getRoot();
    // The file says nothing of what carries the root: the base of the whole.
    robot_.joints.push_back({.name = "", .kind = Robot::Joint::Kind::fixed, .parent = {}, .frame = {}, .link = {}});
    robot_.links.push_back(link_of(root));
    hang_on(root, 0);
    if (robot_.links.size() != model_.links_.size())
      fail("joints close a loop; they must make a tree, from one root link");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw UserError(text_.file + ": " + what); }

  void check_parents() const {
    std::map<std::string, std::string> carried;
    for (const auto& [name, joint] : model_.joints_) {
      const auto [first, added] = carried.emplace(joint->child_link_name, name);
      if (added) continue;
      fail(fmt::format("joint '{}': child = {}: hangs on joint '{}' already; joints must make a tree",
                       one_line(name, 60), one_line(joint->child_link_name, 60), one_line(first->second, 60)));
    }
  }

  void hang_on(const urdf::Link& parent, std::size_t number) {
    for (const auto& joint : parent.child_joints) {
      const auto child = model_.getLink(joint->child_link_name);
      if (!child) continue;
      robot_.joints.push_back(joint_of(*joint, number));
      robot_.links.push_back(link_of(*child));
      hang_on(*child, robot_.links.size() - 1);
    }
  }

  Robot::Joint joint_of(const urdf::Joint& joint, std::size_t parent) {
    Robot::Joint made{.name = joint.name,
                      .kind = kind_of(joint),
                      .parent = parent,
                      .frame = ours(joint.parent_to_joint_origin_transform),
                      .link = {}};
    if (made.kind != Robot::Joint::Kind::hinge && made.kind != Robot::Joint::Kind::slider) return made;
    made.axis = ours(joint.axis);
    if (!(length(made.axis) > 0)) {
      fail(fmt::format("joint '{}': axis = [0, 0, 0]: must have a direction", one_line(joint.name, 60)));
    }
    made.axis = unit(made.axis);
    if (joint.limits && joint.type != urdf::Joint::CONTINUOUS) {
      made.acting.limits_q = {joint.limits->lower, joint.limits->upper};
    }
    if (joint.limits && joint.limits->effort > 0) {
      robot_.remark("effort limits", "not taken: nothing drives the joints yet", joint.name);
    }
    if (joint.limits && joint.limits->velocity > 0) {
      robot_.remark("velocity limits", "not taken: ODE has none", joint.name);
    }
    if (joint.dynamics) {
      made.acting.damping = joint.dynamics->damping;
      made.acting.friction = joint.dynamics->friction;
    }
    if (joint.mimic) {
      robot_.remark("mimic", "not taken: the joint moves by itself, and not as another does", joint.name);
    }
    return made;
  }

  Robot::Joint::Kind kind_of(const urdf::Joint& joint) const {
    using Kind = Robot::Joint::Kind;
    switch (joint.type) {
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
        return Kind::hinge;
      case urdf::Joint::PRISMATIC:
        return Kind::slider;
      case urdf::Joint::FLOATING:
        return Kind::free;
      case urdf::Joint::FIXED:
        return Kind::fixed;
      case urdf::Joint::PLANAR:
      case urdf::Joint::UNKNOWN:
        break;
    }
    fail(fmt::format("joint '{}': type = {}: must be revolute, continuous, prismatic, fixed or floating",
                     one_line(joint.name, 60), joint.type == urdf::Joint::PLANAR ? "planar" : "unknown"));
  }

  RobotText& text_;
  Robot& robot_;
  const urdf::ModelInterface& model_;
};

void read(RobotText& text) {
  Complaints complaints;
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(std::string(text.text));
  // It goes on without what it could not read in some places, and only says so.
  if (!model || !model->getRoot() || complaints.any()) throw UserError(text.file + ": not URDF: " + complaints.text());
  Reading(text, *model).read();
  for (const std::string& warning : complaints.warnings()) text.robot.remark("warnings of urdfdom", warning, "");
}

}  // namespace

extern "C" __attribute__((visibility("default"))) void odeval_read_urdf(RobotText* text) try {
  read(*text);
} catch (const std::exception& error) {
  text->fault = error.what();
}

}  // namespace odeval
