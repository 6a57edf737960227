// SDFormat by libsdformat, in a module of its own.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <sdf/sdf.hh>
#include <set>
#include <vector>

#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"

namespace odeval {
namespace {

using Kind = Robot::Joint::Kind;
using Form = Robot::Solid::Form;

/// The library's own log would be a file in the user's home, and its messages lines on standard error.
void quieten() {
  static const bool once = [] {
    const char* const home = std::getenv("HOME");
    const std::string kept = home == nullptr ? "" : home;
    ::setenv("HOME", "/dev/null", 1);
    sdf::Console::Instance()->SetQuiet(true);
    if (home == nullptr) {
      ::unsetenv("HOME");
    } else {
      ::setenv("HOME", kept.c_str(), 1);
    }
    return true;
  }();
  static_cast<void>(once);
}

/// Where the file is no SDFormat the library tries it as URDF, by a parser that prints: nothing does while one lives.
class Silence {
 public:
  Silence() : kept_(::dup(STDERR_FILENO)) {
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (kept_ >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) ::close(nowhere);
  }
  ~Silence() {
    if (kept_ < 0) return;
    ::dup2(kept_, STDERR_FILENO);
    ::close(kept_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int kept_;
};

template <class Vector>
Vec3 ours(const Vector& v) {
  return {v.X(), v.Y(), v.Z()};
}
template <class Pose>
Frame frame_of(const Pose& pose) {
  const auto& q = pose.Rot();
  return {ours(pose.Pos()), rotation_of_quaternion(q.W(), q.X(), q.Y(), q.Z())};
}

class Reading {
 public:
  explicit Reading(RobotText& text) : text_(text), robot_(text.robot) {}

  void read() {
    const Silence silence;
    quieten();
    sdf::Root root;
    must(root.LoadSdfString(std::string(text_.text)));
    const std::string version = root.Element() ? root.Element()->OriginalVersion() : root.Version();
    robot_.format = "SDFormat " + version;
    if (number_of(version) > number_of(sdf::SDF::Version())) {
      fail(fmt::format("version = {}: must be at most {}, which this build's library knows", named(version),
                       sdf::SDF::Version()));
    }
    if (root.WorldCount() > 1) fail("world: stands there twice; one is wanted");
    if (root.WorldCount() == 1) {
      read_world(*root.WorldByIndex(0));
    } else if (root.Model() != nullptr) {
      robot_.name = root.Model()->Name();
      add_model(*root.Model(), pose_of(*root.Model(), ""), "", root.Model()->Static());
    } else {
      fail("world or model: is missing; one is wanted");
    }
    hang();
  }

 private:
  using JointType = sdf::JointType;

  /// A link as it stands in the file, not yet hung on anything.
  struct Standing {
    Robot::Link link;
    Frame place;  // in the world
    bool fixed;   // of a static model
  };
  struct Between {
    Robot::Joint joint;
    std::string parent;  // empty: the world
    std::string child;
    Frame place;
  };

  [[noreturn]] void fail(const std::string& what) const { throw UserError(text_.file + ": " + what); }
  void must(const sdf::Errors& errors) const {
    if (errors.empty()) return;
    // Some only repeat the text.
    const auto tells = [](const sdf::Error& error) {
      return !error.Message().starts_with("Unable to read SDF string");
    };
    const auto first = std::ranges::find_if(errors, tells);
    fail("not SDFormat: " + (first != errors.end()
                                 ? one_line(first->Message(), 300)
                                 : "can not be read; it needs <sdf version=\"1.9\"> with a world or model"));
  }
  /// "1.9" is older than "1.10".
  static std::pair<int, int> number_of(const std::string& version) {
    std::pair<int, int> number{};
    const std::size_t dot = std::min(version.find('.'), version.size());
    std::from_chars(version.data(), version.data() + dot, number.first);
    if (dot < version.size()) std::from_chars(version.data() + dot + 1, version.data() + version.size(), number.second);
    return number;
  }
  static std::string named(const std::string& name) { return one_line(name, 60); }

  void read_world(const sdf::World& world) {
    robot_.name = world.Name();
    const Vec3 gravity = ours(world.Gravity());
    if (gravity[0] != 0 || gravity[1] != 0 || !(gravity[2] <= 0)) {
      fail(fmt::format("gravity = {} {} {}: must be along -z: 0 0 -9.81", gravity[0], gravity[1], gravity[2]));
    }
    robot_.gravity = std::fabs(gravity[2]);
    for (std::uint64_t i = 0; i < world.ModelCount(); ++i) {
      const sdf::Model& model = *world.ModelByIndex(i);
      add_model(model, pose_of(model, ""), model.Name() + "::", model.Static());
    }
    if (world.ModelCount() == 1) prefix_ = world.ModelByIndex(0)->Name() + "::";
    if (const sdf::Physics* physics = world.PhysicsDefault()) read_physics(*physics);
  }

  template <class Posed>
  Frame pose_of(const Posed& what, const std::string& in) const {
    auto pose = what.RawPose();
    must(what.SemanticPose().Resolve(pose, in));
    return frame_of(pose);
  }

  void add_model(const sdf::Model& model, const Frame& place, const std::string& prefix, bool fixed) {
    for (std::uint64_t i = 0; i < model.LinkCount(); ++i) {
      const sdf::Link& link = *model.LinkByIndex(i);
      links_.emplace(prefix + link.Name(),
                     Standing{link_of(link, prefix, fixed), place * pose_of(link, "__model__"), fixed});
      order_.push_back(prefix + link.Name());
    }
    for (std::uint64_t i = 0; i < model.JointCount(); ++i) add_joint(*model.JointByIndex(i), place, prefix);
    for (std::uint64_t i = 0; i < model.ModelCount(); ++i) {
      const sdf::Model& inner = *model.ModelByIndex(i);
      add_model(inner, place * pose_of(inner, "__model__"), prefix + inner.Name() + "::", fixed || inner.Static());
    }
  }

  /// A link of a static model needs no mass.
  Robot::Link link_of(const sdf::Link& link, const std::string& prefix, bool fixed) {
    Robot::Link made{.name = prefix + link.Name()};
    const bool weighed = link.Element() && link.Element()->HasElement("inertial");
    if (!fixed) remark_defaults(link, made.name);
    add_solids(made, link);
    if (!weighed && fixed) return made;
    const auto& inertial = link.Inertial();
    const auto& matrix = inertial.MassMatrix();
    const Vec3 diagonal = ours(matrix.DiagonalMoments());
    const Vec3 products = ours(matrix.OffDiagonalMoments());
    made.mass = Robot::Mass{matrix.Mass(),
                            frame_of(inertial.Pose()),
                            {diagonal[0], diagonal[1], diagonal[2], products[0], products[1], products[2]}};
    return made;
  }

  void remark_defaults(const sdf::Link& link, const std::string& name) {
    if (!link.Element() || !link.Element()->HasElement("inertial")) {
      robot_.remark("links without <inertial>", "1 kg and 1 kg m², as SDFormat has it", name);
      return;
    }
    const sdf::ElementPtr inertial = link.Element()->GetElement("inertial");
    if (!inertial->HasElement("mass")) robot_.remark("links without <mass>", "1 kg, as SDFormat has it", name);
    if (!inertial->HasElement("inertia")) robot_.remark("links without <inertia>", "1 kg m², as SDFormat has it", name);
  }

  void add_solids(Robot::Link& made, const sdf::Link& link) const {
    for (std::uint64_t i = 0; i < link.CollisionCount(); ++i) {
      const sdf::Collision& collision = *link.CollisionByIndex(i);
      if (collision.Geom() == nullptr) continue;
      Robot::Solid solid = solid_of(*collision.Geom());
      auto pose = collision.RawPose();
      must(collision.SemanticPose().Resolve(pose));
      solid.frame = frame_of(pose);
      solid.name = collision.Name();
      made.solids.push_back(std::move(solid));
    }
  }

  static Robot::Solid solid_of(const sdf::Geometry& geometry) {
    const auto round = [](Form form, double radius, double length) {
      return Robot::Solid{.form = form, .frame = {}, .sides_m = {2 * radius, 2 * radius, length}};
    };
    if (const auto* box = geometry.BoxShape()) {
      return {.form = Form::box, .frame = {}, .sides_m = ours(box->Size())};
    }
    if (const auto* ball = geometry.SphereShape()) return round(Form::sphere, ball->Radius(), 2 * ball->Radius());
    if (const auto* cylinder = geometry.CylinderShape()) {
      return round(Form::cylinder, cylinder->Radius(), cylinder->Length());
    }
    if (const auto* capsule = geometry.CapsuleShape()) {
      return round(Form::capsule, capsule->Radius(), capsule->Length() + 2 * capsule->Radius());
    }
    if (const auto* mesh = geometry.MeshShape()) {
      return {.form = Form::mesh, .frame = {}, .file = mesh->Uri(), .scale = ours(mesh->Scale())};
    }
    if (geometry.PlaneShape() != nullptr) return {.form = Form::plane, .frame = {}};
    return {.form = Form::other, .frame = {}};
  }

  void add_joint(const sdf::Joint& said, const Frame& model, const std::string& prefix) {
    Between between;
    Robot::Joint& joint = between.joint;
    joint.name = prefix + said.Name();
    joint.kind = kind_of(said);
    std::string parent;
    std::string child;
    must(said.ResolveParentLink(parent));
    must(said.ResolveChildLink(child));
    if (parent != "world") between.parent = prefix + parent;
    between.child = prefix + child;
    between.place = model * pose_of(said, "__model__");
    if (joint.kind == Kind::hinge || joint.kind == Kind::slider || joint.kind == Kind::universal) {
      joint.axis = axis_of(said, 0);
      take_axis(joint, joint.acting, *said.Axis(0));
    }
    if (joint.kind == Kind::universal) {
      joint.axis2 = axis_of(said, 1);
      take_axis(joint, joint.acting2, *said.Axis(1));
    }
    joints_.push_back(between);
  }

  Kind kind_of(const sdf::Joint& joint) const {
    switch (joint.Type()) {
      case JointType::REVOLUTE:
      case JointType::CONTINUOUS:
        return Kind::hinge;
      case JointType::PRISMATIC:
        return Kind::slider;
      case JointType::BALL:
        return Kind::ball;
      case JointType::UNIVERSAL:
        return Kind::universal;
      case JointType::FIXED:
        return Kind::fixed;
      default:
        break;
    }
    fail(fmt::format("joint '{}': type: must be revolute, continuous, prismatic, ball, universal or fixed",
                     named(joint.Name())));
  }

  /// In the joint's frame.
  Vec3 axis_of(const sdf::Joint& joint, unsigned number) const {
    const sdf::JointAxis* const axis = joint.Axis(number);
    if (axis == nullptr) fail(fmt::format("joint '{}': axis: is missing", named(joint.Name())));
    auto direction = axis->Xyz();
    must(axis->ResolveXyz(direction));
    const Vec3 said = ours(direction);
    if (!(length(said) > 0)) {
      fail(fmt::format("joint '{}': axis = 0 0 0: must have a direction", named(joint.Name())));
    }
    return unit(said);
  }

  void take_axis(const Robot::Joint& joint, Robot::Acting& acting, const sdf::JointAxis& axis) {
    constexpr double none = 1e15;  // SDFormat's own word for no limit is 1e16, or infinity
    if (std::fabs(axis.Lower()) < none && std::fabs(axis.Upper()) < none)
      acting.limits_q = {axis.Lower(), axis.Upper()};
    if (!acting.limits_q && (std::fabs(axis.Lower()) < none || std::fabs(axis.Upper()) < none)) {
      robot_.remark("limits", "not taken: of one end alone", joint.name);
    }
    acting.damping = axis.Damping();
    acting.friction = axis.Friction();
    acting.stiffness = axis.SpringStiffness();
    acting.rest = axis.SpringReference();
    const auto given = [](double limit) { return limit > 0 && std::isfinite(limit) && limit < none; };
    if (given(axis.Effort())) robot_.remark("effort limits", "not taken: nothing drives the joints yet", joint.name);
    if (given(axis.MaxVelocity())) robot_.remark("velocity limits", "not taken: ODE has none", joint.name);
  }

  /// Settings that the file itself gives.
  void read_physics(const sdf::Physics& physics) {
    const sdf::ElementPtr element = physics.Element();
    if (!element) return;
    const auto take = [&](sdf::ElementPtr in, const char* name, const char* key) {
      if (!in || !in->HasElement(name)) return;
      robot_.settings.emplace_back(key, in->GetElement(name)->GetValue()->GetAsString());
    };
    const auto inner = [](sdf::ElementPtr in, const char* name) {
      return in && in->HasElement(name) ? in->GetElement(name) : nullptr;
    };
    take(element, "max_step_size", "step");
    if (physics.EngineType() != "ode") {
      robot_.remark("<physics>", "of another engine: only its step is taken", physics.EngineType());
      return;
    }
    const sdf::ElementPtr ode = inner(element, "ode");
    const sdf::ElementPtr solver = inner(ode, "solver");
    const sdf::ElementPtr constraints = inner(ode, "constraints");
    take(solver, "iters", "ode.iterations");
    take(solver, "sor", "ode.sor_w");
    take(constraints, "erp", "ode.erp");
    take(constraints, "cfm", "ode.cfm");
    take(constraints, "contact_max_correcting_vel", "ode.max_correcting_vel");
    take(constraints, "contact_surface_layer", "ode.surface_layer");
    if (solver && solver->HasElement("type")) {
      const bool world = solver->Get<std::string>("type") == "world";
      robot_.settings.emplace_back("methods", world ? "[\"ode-step-double\"]" : "[\"ode-quickstep-double\"]");
    }
  }

  /// Links from the world outwards, each with what it hangs on.
  void hang() {
    std::map<std::string, const Between*> of_child;
    std::map<std::string, std::vector<const Between*>> of_parent;
    for (const Between& between : joints_) {
      for (const std::string* name : {&between.parent, &between.child}) {
        if (name->empty() || links_.contains(*name)) continue;
        fail(fmt::format("joint '{}': '{}' is the name of no link", named(between.joint.name), named(*name)));
      }
      const auto [first, added] = of_child.emplace(between.child, &between);
      if (!added) {
        fail(fmt::format("joint '{}': child = {}: hangs on joint '{}' already; joints must make a tree",
                         named(between.joint.name), named(between.child), named(first->second->joint.name)));
      }
      of_parent[between.parent].push_back(&between);
    }
    for (const std::string& name : order_) {
      const auto joint = of_child.find(name);
      if (joint != of_child.end() && !joint->second->parent.empty()) continue;
      const Standing& link = links_.at(name);
      if (joint != of_child.end()) {
        put(name, *joint->second, {}, Frame{}, of_parent);
      } else {
        Between alone;
        alone.joint.kind = link.fixed ? Kind::fixed : Kind::free;
        alone.place = link.place;
        put(name, alone, {}, Frame{}, of_parent);
      }
    }
    if (robot_.links.size() != links_.size()) fail("joints close a loop; they must make a tree");
    if (robot_.links.empty()) fail("link: is missing; a model with links is wanted");
  }

  void put(const std::string& name, const Between& on, std::optional<std::size_t> parent, const Frame& place_of_parent,
           const std::map<std::string, std::vector<const Between*>>& of_parent) {
    const Standing& link = links_.at(name);
    Robot::Joint joint = on.joint;
    joint.parent = parent;
    joint.frame = inverse(place_of_parent) * on.place;
    joint.link = inverse(on.place) * link.place;
    robot_.links.push_back(link.link);
    robot_.joints.push_back(joint);
    for (std::string* word : {&robot_.links.back().name, &robot_.joints.back().name}) {
      if (!prefix_.empty() && word->starts_with(prefix_)) word->erase(0, prefix_.size());
    }
    const std::size_t number = robot_.links.size() - 1;
    const auto children = of_parent.find(name);
    if (children == of_parent.end()) return;
    for (const Between* next : children->second) put(next->child, *next, number, link.place, of_parent);
  }

  RobotText& text_;
  Robot& robot_;
  std::map<std::string, Standing> links_;
  std::vector<std::string> order_;  // of links in the file
  std::vector<Between> joints_;
  std::string prefix_;  // of all names, where there is one model
};

}  // namespace

extern "C" __attribute__((visibility("default"))) void odeval_read_sdformat(RobotText* text) try {
  Reading(*text).read();
} catch (const std::exception& error) {
  text->fault = error.what();
}

}  // namespace odeval
