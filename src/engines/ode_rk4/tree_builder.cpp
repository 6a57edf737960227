// From a mechanism to the links of its trees.
#include <algorithm>
#include <optional>
#include <utility>

#include "engines/ode_rk4/tree.hpp"

namespace odeval::engine_rk4 {

/// Walks from the world, then from a first body of each tree that is left, and makes a link of each joint.
class TreeBuilder {
 public:
  explicit TreeBuilder(const Mechanism& mechanism) : mechanism_(mechanism), joints_at_(mechanism.bodies.size()) {
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
      const Joint& joint = mechanism.joints[j];
      if (joint.rows() == 0) continue;
      (joint.b == world_body ? joints_at_world_ : joints_at_[joint.b]).push_back(j);
      joints_at_[joint.a].push_back(j);
    }
  }

  std::optional<Tree> build() {
    const auto known = [](const Body& body) { return body.inverse_mass > 0 && !body.damped(); };
    if (mechanism_.joints.empty() || !std::ranges::all_of(mechanism_.bodies, known)) return std::nullopt;
    tree_.link_of_.assign(mechanism_.joints.size(), Tree::none);
    link_of_body_.assign(mechanism_.bodies.size(), Tree::none);
    for (const std::size_t joint : joints_at_world_) {
      if (!hang(joint, world_body)) return std::nullopt;
    }
    for (std::size_t body = 0; body < mechanism_.bodies.size(); ++body) {
      if (link_of_body_[body] == Tree::none && !add({Tree::Kind::free}, body)) return std::nullopt;
    }
    Tree::Now& world = tree_.world_;
    world.turn.setIdentity();
    for (Vector3d* const v : {&world.place, &world.centre, &world.n, &world.f, &world.turning, &world.moving}) {
      v->setZero();
    }
    tree_.now_.resize(tree_.links_.size());
    return std::move(tree_);
  }

 private:
  using Kind = Tree::Kind;

  /// The link of a joint's other body, and of all that hangs on it.
  bool hang(std::size_t j, std::size_t parent) {
    const Joint& joint = mechanism_.joints[j];
    Tree::Link link{};
    link.is_a = joint.a != parent;
    const std::size_t child = link.is_a ? joint.a : joint.b;
    if (child == world_body || link_of_body_[child] != Tree::none) return false;  // a loop
    if (!joint.motors.empty() || !read_kind(joint, link.kind)) return false;
    link.joint = j;
    link.parent_body = parent;
    link.parent = parent == world_body ? Tree::none : link_of_body_[parent];
    tree_.floats_ = tree_.floats_ || (link.parent != Tree::none && tree_.links_[link.parent].kind == Kind::free);
    const Vector3d from = parent == world_body ? Vector3d(Vector3d::Zero()) : origin_of_[link.parent];
    link.centre = -point(joint, link.is_a);
    link.arm = point(joint, !link.is_a) - from;
    if (link.kind == Kind::fixed || link.kind == Kind::slider) {
      link.same_turn = same_turn(joint, link.is_a);
      link.parent_same_turn = same_turn(joint, !link.is_a);
    }
    // A slider has its axis on its first body alone.
    if (link.kind != Kind::slider || link.is_a) link.axis = axis(joint, link.is_a);
    if (link.kind != Kind::slider || !link.is_a) link.parent_axis = axis(joint, !link.is_a);
    if (link.kind == Kind::universal) {
      Tree::Link between = link;
      between.joint = Tree::none;
      link.parent = push(between, Vector3d::Zero());
      link.arm.setZero();
    }
    return add(link, child);
  }

  bool add(Tree::Link link, std::size_t body) {
    const Body& of = mechanism_.bodies[body];
    link.body = body;
    link.mass = 1 / of.inverse_mass;
    const Vector3d& r = link.centre;
    link.inertia = Symmetric::of(of.inertia + link.mass * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose()));
    link_of_body_[body] = push(link, -r);
    if (link.joint != Tree::none) tree_.link_of_[link.joint] = link_of_body_[body];
    for (const std::size_t joint : joints_at_[body]) {
      if (joint != link.joint && !hang(joint, body)) return false;
    }
    return true;
  }

  std::size_t push(const Tree::Link& link, const Vector3d& origin) {
    tree_.links_.push_back(link);
    origin_of_.push_back(origin);
    return tree_.links_.size() - 1;
  }

  static bool read_kind(const Joint& joint, Kind& kind) {
    if (joint.id == nullptr) {  // a foothold, or a stop beside the joint itself
      if (joint.points.empty()) return false;
      kind = joint.squares.empty() ? Kind::ball : joint.squares.size() == 2 ? Kind::hinge : Kind::fixed;
      return true;
    }
    switch (dJointGetType(joint.id)) {
      case dJointTypeBall:
        kind = Kind::ball;
        return true;
      case dJointTypeHinge:
        kind = Kind::hinge;
        return true;
      case dJointTypeUniversal:
        kind = Kind::universal;
        return true;
      case dJointTypeSlider:
        kind = Kind::slider;
        return true;
      case dJointTypeFixed:
        kind = Kind::fixed;
        return true;
      default:
        return false;
    }
  }

  static Vector3d point(const Joint& joint, bool of_a) {
    if (!joint.slides.empty()) return of_a ? joint.slides[0].on_a : joint.slides[0].on_b;
    return of_a ? joint.points[0].on_a : joint.points[0].on_b;
  }
  static Vector3d axis(const Joint& joint, bool of_a) {
    if (!joint.slides.empty()) return joint.slides[0].p.cross(joint.slides[1].p);
    if (joint.squares.size() == 1) return of_a ? joint.squares[0].p : joint.squares[0].n;
    if (joint.squares.size() == 2) return of_a ? joint.squares[0].p.cross(joint.squares[1].p) : joint.squares[0].n;
    return Vector3d::Zero();
  }
  /// The axes that the world had when the joint was read, which its three squares keep together.
  static Matrix3d same_turn(const Joint& joint, bool of_a) {
    Matrix3d axes;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Square& square = joint.squares[static_cast<std::size_t>(k)];
      axes.col(of_a ? k : (k + 1) % 3) = of_a ? square.p : square.n;
    }
    return axes;
  }

  const Mechanism& mechanism_;
  std::vector<std::vector<std::size_t>> joints_at_;  // by body
  std::vector<std::size_t> joints_at_world_;
  std::vector<std::size_t> link_of_body_;
  std::vector<Vector3d> origin_of_;  // of each link, in its body's frame
  Tree tree_;
};

std::optional<Tree> Tree::of(const Mechanism& mechanism) { return TreeBuilder(mechanism).build(); }

}  // namespace odeval::engine_rk4
