#include "engines/tree/hanging.hpp"

#include <cmath>
#include <variant>

#include "odeval/error.hpp"

namespace odeval::engine_tree {
namespace {

Place place_of(const Body& body) {
  const Vec3 vector = rotation_vector(body.attitude);
  const double angle = length(vector);
  const double part = angle == 0 ? 0.5 : std::sin(angle / 2) / angle;
  const double w = std::cos(angle / 2);
  const auto [x, y, z] = part * vector;
  return {body.position_m,
          {w, x, y, z},
          {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
           2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),  //
           2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
}

/// What the kinds leave, as the body that hangs sees it.
struct Leave {
  Hanging& hanging;
  bool body_is_first;  // of the joint
  Vec3 speed;          // of the body against its parent, at the anchor

  void operator()(const BallJoint&) const { hanging.ball = true; }
  void operator()(const HingeJoint& hinge) const { turn(counted(hinge.axis)); }
  void operator()(const SliderJoint& slider) const {
    const Vec3 axis = counted(slider.axis);
    hanging.degrees.push_back({false, axis, dot(axis, speed)});
  }
  void operator()(const UniversalJoint& joint) const {
    turn(body_is_first ? joint.axis2 : joint.axis1);
    turn(body_is_first ? joint.axis1 : joint.axis2);
  }
  void operator()(const FixedJoint&) const {}
  void operator()(const PistonJoint&) const { refuse(); }
  void operator()(const SlidingHingeJoint&) const { refuse(); }
  void operator()(const SlidingUniversalJoint&) const { refuse(); }
  void operator()(const Hinge2Joint&) const { refuse(); }
  void operator()(const PlaneJoint&) const { refuse(); }

 private:
  [[noreturn]] static void refuse() {
    throw MachineError("a joint of a kind that engines in joint coordinates do not have");
  }
  /// A joint counts the first body against the second.
  Vec3 counted(const Vec3& axis) const { return body_is_first ? axis : -1.0 * axis; }
  // The axes of one joint stand at right angles at t = 0.
  void turn(const Vec3& axis) const { hanging.degrees.push_back({true, axis, dot(axis, hanging.spin_rad_s)}); }
};

class Growth {
 public:
  explicit Growth(const Mechanism& mechanism)
      : mechanism_(mechanism), hangs_(mechanism.bodies.size()), used_(mechanism.joints.size()) {}

  std::vector<Hanging> grow(std::vector<std::size_t>* closing) {
    hang_on({});
    follow();
    for (std::size_t body = 0; body < hangs_.size(); ++body) {
      if (hangs_[body]) continue;
      add(body, {}, {});
      follow();
    }
    for (std::size_t j = 0; j < used_.size(); ++j) {
      if (used_[j]) continue;
      if (closing == nullptr) throw MachineError("joints that close a loop are not for this engine");
      closing->push_back(j);
    }
    return std::move(tree_);
  }

 private:
  void follow() {
    for (; next_ < tree_.size(); ++next_) hang_on(tree_[next_].body);
  }

  void hang_on(const std::optional<std::size_t>& parent) {
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
      const Joint& joint = mechanism_.joints[j];
      if (used_[j] || (joint.second != parent && parent != joint.first)) continue;
      const std::size_t child = joint.second == parent ? joint.first : *joint.second;
      if (hangs_[child]) continue;
      used_[j] = true;
      add(child, j, parent);
    }
  }

  void add(std::size_t number, std::optional<std::size_t> number_of_joint, std::optional<std::size_t> parent) {
    hangs_[number] = true;
    const Body& body = mechanism_.bodies[number];
    Hanging& hanging = tree_.emplace_back();
    hanging.body = number;
    hanging.joint = number_of_joint;
    hanging.parent = parent;
    hanging.place = place_of(body);
    hanging.spin_rad_s = body.spin_rad_s;
    if (!number_of_joint) return;
    const Joint& joint = mechanism_.joints[*number_of_joint];
    hanging.anchor_m = anchor_m(joint.kind);
    const auto velocity = [&](const Body& of) {
      return of.velocity_m_s + cross(of.spin_rad_s, hanging.anchor_m - of.position_m);
    };
    Vec3 speed = velocity(body);
    if (parent) {
      const Body& carrier = mechanism_.bodies[*parent];
      hanging.parent_place = place_of(carrier);
      hanging.spin_rad_s = hanging.spin_rad_s - carrier.spin_rad_s;
      speed = speed - velocity(carrier);
    }
    std::visit(Leave{hanging, joint.first == number, speed}, joint.kind);
  }

  const Mechanism& mechanism_;
  std::vector<bool> hangs_;  // of each body
  std::vector<bool> used_;   // of each joint
  std::vector<Hanging> tree_;
  std::size_t next_ = 0;  // whose children are looked for
};

}  // namespace

Vec3 Place::in_body(const Vec3& direction) const {
  return {dot(axis_of(rotation, 0), direction), dot(axis_of(rotation, 1), direction),
          dot(axis_of(rotation, 2), direction)};
}

std::vector<Hanging> hang(const Mechanism& mechanism, std::vector<std::size_t>* closing) {
  return Growth(mechanism).grow(closing);
}

std::array<double, 9> inertia_of(const Body& body) {
  const Vec3 moments = body.uniform_moments_kgm2();
  return body.inertia_kgm2.value_or(std::array{moments[0], 0.0, 0.0, 0.0, moments[1], 0.0, 0.0, 0.0, moments[2]});
}

}  // namespace odeval::engine_tree
