#include "engines/ode_rk4/footholds.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "engines/ode_rk4/friction.hpp"
#include "engines/ode_rk4/islands.hpp"

namespace odeval::engine_rk4 {
namespace {

using Geoms = std::pair<const void*, const void*>;
using Group = std::vector<Contact>;

constexpr double still = 1e-7;          // m/s: slower is sticking
constexpr double too_deep = 1e-7;       // m: it has to be pushed out first
constexpr double least_depth = 1e-12;   // m: what an impact is located to, a thousand roundings, is still found
constexpr double astray = 1e-8;         // m, rad: what the user moved, far above what projection leaves
constexpr double thin = 1e-4;           // of the distance between contacts: nearer than this to a line, they are on it
constexpr double on_face = 1 - 1e-12;   // cosine between a normal and a box's axis
constexpr double near_point = 1e-6;     // m: all contacts this near are one
constexpr std::size_t most_pairs = 16;  // more are a heap, which the time-stepping scheme serves better
// Of the force: contacts that bear it leave nothing but rounding of their solution. And m/s^2 of the body, where there
// is none.
constexpr double borne = 1e-9, no_acceleration = 1e-3;

enum class Shape { flat, plane, round };

Shape shape(const void* geom) {
  switch (dGeomGetClass(static_cast<dGeomID>(const_cast<void*>(geom)))) {
    case dPlaneClass:
      return Shape::plane;
    case dBoxClass:
    case dConvexClass:
    case dTriMeshClass:
    case dHeightfieldClass:
      return Shape::flat;
    default:
      return Shape::round;
  }
}

/// The contact's normal takes the joint's first body away.
Vector3d normal_from(const Contact& contact, std::size_t a) {
  return contact.a == a ? contact.normal : -contact.normal;
}

Vector3d centre_of(const Group& group) {
  Vector3d sum = Vector3d::Zero();
  for (const Contact& contact : group) sum += contact.point;
  return sum / static_cast<double>(group.size());
}

/// The directions in which the contacts lie, the widest first, and how wide.
struct Spread {
  Vector3d along = Vector3d::Zero(), across = Vector3d::Zero();
  double length = 0, width = 0;

  explicit Spread(const Group& group) {
    const Vector3d& first = group.front().point;
    for (const Contact& contact : group) {
      const Vector3d way = contact.point - first;
      if (way.norm() > length) along = way, length = way.norm();
    }
    if (length > 0) along /= length;
    for (const Contact& contact : group) {
      const Vector3d way = contact.point - first, off = way - along.dot(way) * along;
      if (off.norm() > width) across = off, width = off.norm();
    }
    if (width > 0) across /= width;
  }
};

Vector3d in_frame(const State& state, std::size_t body, const Vector3d& direction) {
  return body == world_body ? direction : Vector3d(rotation(state[body].pose.turn).transpose() * direction);
}
Vector3d in_frame_point(const State& state, std::size_t body, const Vector3d& point) {
  return body == world_body ? point : in_frame(state, body, point - state[body].pose.position);
}

/// One more equation for a joint that lies against a stop.
Joint lock(const Contact& contact, const State& state) {
  const auto [a, b] = std::pair(contact.a, contact.b);
  Joint joint{nullptr, a, b, {}, {}, {}, {}, {}, {}, {}, {}};
  const Vector3d& n = contact.normal;
  const double deeper = std::clamp(contact.depth, least_depth, rest_depth) - contact.depth;
  if (contact.turns) {
    const Vector3d p = n.unitOrthogonal(), across = n.cross(p);
    joint.squares.push_back({in_frame(state, a, p), in_frame(state, b, across - deeper * n.cross(across))});
  } else {
    joint.slides.push_back({in_frame(state, a, n), in_frame_point(state, a, contact.point + deeper * n),
                            in_frame_point(state, b, contact.point)});
  }
  return joint;
}

/// One that rolls and sticks is held as well where it has a plane of the world, or a face of a box, to itself.
bool can_roll(const Mechanism& mechanism, const Contact& contact) {
  const std::size_t body = contact.a == world_body ? contact.b : contact.a;
  if ((contact.a != world_body && contact.b != world_body) || mechanism.bodies[body].inverse_mass == 0) return false;
  const auto is_its = [&](const Joint& joint) { return joint.a == body || joint.b == body; };
  if (std::ranges::any_of(mechanism.joints, is_its)) return false;
  const auto geom = [](const void* of) { return static_cast<dGeomID>(const_cast<void*>(of)); };
  dGeomID one = geom(contact.geoms.first), other = geom(contact.geoms.second);
  if (dGeomGetBody(one) == nullptr) std::swap(one, other);
  if (dGeomGetClass(one) != dSphereClass) return false;
  if (dGeomGetClass(other) != dBoxClass) return dGeomGetClass(other) == dPlaneClass;
  const dReal* const r = dGeomGetRotation(other);
  const Vector3d& n = contact.normal;
  double along = 0;
  for (int k = 0; k < 3; ++k) along = std::max(along, std::fabs(n[0] * r[k] + n[1] * r[4 + k] + n[2] * r[8 + k]));
  return along > on_face;
}

Joint rolling(const Contact& contact) {
  const std::size_t a = contact.a == world_body ? contact.b : contact.a;
  dGeomID sphere = static_cast<dGeomID>(const_cast<void*>(contact.geoms.first));
  if (dGeomGetBody(sphere) == nullptr) sphere = static_cast<dGeomID>(const_cast<void*>(contact.geoms.second));
  Joint joint{nullptr, a, world_body, {}, {}, {}, {}, {}, {}, {}, {}};
  const dReal* const offset = dGeomGetOffsetPosition(sphere);
  const double wanted = std::clamp(contact.depth, least_depth, rest_depth);
  const Vector3d n = normal_from(contact, a);
  joint.rolls.push_back({{offset[0], offset[1], offset[2]},
                         n,
                         dGeomSphereGetRadius(sphere),
                         n.dot(contact.point) + contact.depth - wanted});
  return joint;
}

/// That holds the contacts of one pair of geoms as they are, as deep as what rests; nothing for what may roll.
std::optional<Joint> joint_of(const Mechanism& mechanism, const Group& group, const State& state) {
  const Contact& first = group.front();
  if (first.is_stop) return lock(first, state);
  if (can_roll(mechanism, first)) return rolling(first);
  const auto moves = [&](std::size_t body) { return body != world_body && mechanism.bodies[body].inverse_mass > 0; };
  const std::size_t a = moves(first.a) ? first.a : first.b, b = a == first.a ? first.b : first.a;
  const Spread spread(group);
  const Shape one = shape(first.geoms.first), other = shape(first.geoms.second);
  const bool corner = spread.length < near_point;
  if (is_round(first)) return std::nullopt;
  if (corner && one != Shape::plane && other != Shape::plane) return std::nullopt;  // perhaps two edges that cross
  Joint joint{nullptr, a, b, {}, {}, {}, {}, {}, {}, {}, {}};
  double depth = 0;
  for (const Contact& contact : group) depth += contact.depth / static_cast<double>(group.size());
  const double wanted = std::clamp(depth, least_depth, rest_depth);
  const Vector3d at = centre_of(group), deeper = at - (wanted - depth) * normal_from(first, a);
  joint.points.push_back({in_frame_point(state, a, at), in_frame_point(state, b, deeper)});
  const auto square = [&](const Vector3d& p, const Vector3d& n) {
    joint.squares.push_back({in_frame(state, a, p), in_frame(state, b, n)});
  };
  if (corner) return joint;
  if (spread.width < thin * spread.length) {
    const Vector3d p = spread.along.unitOrthogonal();
    square(p, spread.along);
    square(spread.along.cross(p), spread.along);
  } else {
    const Matrix3d e = Matrix3d::Identity();
    for (Eigen::Index k = 0; k < 3; ++k) square(e.col(k), e.col((k + 1) % 3));
  }
  return joint;
}

bool is_face(const Joint& joint) { return joint.squares.size() == 3; }

bool sticks(const Mechanism& mechanism, const Contact& contact, const State& state) {
  const auto sleeps = [&](std::size_t body) { return body != world_body && mechanism.bodies[body].asleep; };
  const bool turns = contact.rho > 0 || contact.rhoN > 0;  // against torques that a corner's joint does not bear
  const bool fast = contact.is_stop || (contact.friction > 0 && !turns && slip(contact, state, state).norm() < still);
  return fast && contact.depth < too_deep && !sleeps(contact.a) && !sleeps(contact.b);
}

}  // namespace

bool is_round(const Contact& contact) {
  if (contact.is_stop) return false;
  return shape(contact.geoms.first) == Shape::round || shape(contact.geoms.second) == Shape::round;
}

bool is_only_one(const Contact& contact) {
  if (contact.is_stop) return false;
  const auto class_of = [](const void* geom) { return dGeomGetClass(static_cast<dGeomID>(const_cast<void*>(geom))); };
  const int one = class_of(contact.geoms.first), other = class_of(contact.geoms.second);
  const auto is_convex = [](int of) { return of <= dPlaneClass; };
  return (one == dSphereClass && is_convex(other)) || (other == dSphereClass && is_convex(one));
}

std::optional<Footholds> Footholds::of(const Mechanism& mechanism, const AccurateStepOptions& options,
                                       std::span<const Contact> contacts, const State& state, bool struck) {
  std::vector<Contact> resting;
  std::ranges::copy_if(contacts, std::back_inserter(resting),
                       [&](const Contact& contact) { return normal_speed(contact, state) <= options.rest_speed; });
  Islands islands(mechanism, resting);
  std::map<Geoms, std::size_t> numbers;  // pairs keep the order in which they are met: that of addresses may change
  std::vector<Group> groups;
  std::set<std::size_t> loose;  // islands
  for (const Contact& contact : resting) {
    const auto [at, is_new] = numbers.emplace(contact.geoms, groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].push_back(contact);
    const bool comes = normal_speed(contact, state) < -options.rest_speed;
    if (comes || !sticks(mechanism, contact, state)) loose.insert(islands.of(contact));
  }
  std::vector<std::optional<Joint>> joints;
  for (const Group& group : groups) {
    const bool free = !loose.contains(islands.of(group.front()));
    joints.push_back(free ? joint_of(mechanism, group, state) : std::nullopt);
    if (joints.back() && struck && is_face(*joints.back())) joints.back().reset();
    if (!joints.back()) loose.insert(islands.of(group.front()));
  }
  Mechanism held = mechanism;
  std::vector<Foothold> footholds;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (loose.contains(islands.of(groups[i].front()))) continue;
    footholds.push_back({groups[i].front().geoms, held.joints.size()});
    add(held, *joints[i]);
  }
  if (footholds.empty() || footholds.size() > most_pairs) return std::nullopt;
  return Footholds(std::move(held), options.order, std::move(footholds));
}

bool Footholds::can_hold(const Mechanism& mechanism, const Contact& contact) {
  if (contact.is_stop) return true;
  return contact.friction > 0 && (!is_round(contact) || can_roll(mechanism, contact));
}

bool Footholds::have(const Contact& contact) const {
  return std::ranges::any_of(footholds_, [&](const Foothold& foothold) { return foothold.geoms == contact.geoms; });
}

bool Footholds::stand_on(const Contact& contact, const State& state) const {
  return std::ranges::any_of(footholds_, [&](const Foothold& foothold) {
    if (foothold.geoms != contact.geoms) return false;
    const Joint& joint = motion_.mechanism().joints[foothold.joint];
    if (contact.is_stop || is_face(joint) || !joint.rolls.empty()) return true;
    Vector3d off = in_frame_point(state, joint.a, contact.point) - joint.points.front().on_a;
    if (!joint.squares.empty()) {
      const Vector3d edge = joint.squares[0].p.cross(joint.squares[1].p);
      off -= edge.dot(off) * edge;
    }
    return off.norm() < near_point;
  });
}

bool Footholds::fit(const State& state) const {
  std::vector<Matrix3d> turns(state.size());
  return std::ranges::all_of(footholds_, [&](const Foothold& foothold) {
    const Joint& joint = motion_.mechanism().joints[foothold.joint];
    JointRows rows{Matrix6::Zero(), Matrix6::Zero(), Vector6::Zero(), Vector6::Zero()};
    turns[joint.a] = rotation(state[joint.a].pose.turn);
    if (joint.b != world_body) turns[joint.b] = rotation(state[joint.b].pose.turn);
    constrain(joint, state, turns, rows);
    const auto of = [&](const Matrix6& row, std::size_t body) -> Vector6 {
      if (body == world_body) return Vector6::Zero();
      return row * (Vector6() << state[body].twist.linear, state[body].twist.angular).finished();
    };
    const Vector6 speeds = of(rows.of_a, joint.a) + of(rows.of_b, joint.b);
    return rows.error.cwiseAbs().maxCoeff() < astray && speeds.cwiseAbs().maxCoeff() < still;
  });
}

bool Footholds::bear(const State& state, Forces& forces, double t, std::span<const Contact> contacts) {
  motion_.find_forces(state, forces, t);
  if (motion_.redundant()) return false;  // what each of them does is not known
  for (const Contact& contact : contacts) {
    if (!contact.is_stop) continue;
    const auto at = std::ranges::find(footholds_, contact.geoms, &Foothold::geoms);
    if (at == footholds_.end()) continue;
    motion_.add_force(contact.geoms.first, motion_.force_on_a(at->joint), motion_.force_on_b(at->joint));
  }
  return std::ranges::all_of(footholds_, [&](const Foothold& foothold) {
    Group group;
    std::ranges::copy_if(contacts, std::back_inserter(group),
                         [&](const Contact& contact) { return contact.geoms == foothold.geoms; });
    const auto pressed_in = [](const Contact& contact) { return contact.depth >= too_deep; };
    if (group.empty() || std::ranges::any_of(group, pressed_in)) return false;
    const std::size_t a = motion_.mechanism().joints[foothold.joint].a;
    const Wrench& needed = motion_.force_on_a(foothold.joint);
    const double no_force = no_acceleration / motion_.mechanism().bodies[a].inverse_mass;
    if (const Contact& stop = group.front(); stop.is_stop) {
      return stop.normal.dot(stop.turns ? needed.torque : needed.force) >= -borne * no_force;
    }
    // The forces that leave a body of unit mass, as wide as the contacts, at rest.
    for (const Roll& roll : motion_.mechanism().joints[foothold.joint].rolls) {
      if (group.size() != 1 || normal_from(group.front(), a).dot(roll.normal) < on_face) return false;
    }
    const Vector3d centre = centre_of(group);
    const double width = std::max(Spread(group).length, near_point);
    const auto count = static_cast<Eigen::Index>(group.size());
    Eigen::MatrixXd g(6, 3 * count);
    Rubbing rubbing;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Contact& contact = group[static_cast<std::size_t>(i)];
      const Vector3d n = normal_from(contact, a), across = n.unitOrthogonal(), arm = contact.point - centre;
      const auto column = [&](const Vector3d& way) {
        return (Eigen::Matrix<double, 6, 1>() << way, arm.cross(way) / width).finished();
      };
      g.col(i) = column(n);
      g.col(count + 2 * i) = column(across);
      g.col(count + 2 * i + 1) = column(n.cross(across));
      rubbing.contact.push_back(i);
      rubbing.coefficient.push_back(contact.friction);
    }
    Eigen::Matrix<double, 6, 1> w;
    w << needed.force, (needed.torque - (centre - state[a].pose.position).cross(needed.force)) / width;
    const Eigen::VectorXd v = -g.transpose() * w;
    const Eigen::MatrixXd response = g.transpose() * g;
    double work = friction_work;
    const Eigen::VectorXd left = v + response * hold(response, v, rubbing, Eigen::VectorXd::Zero(v.size()), work);
    return left.cwiseAbs().maxCoeff() <= borne * (w.cwiseAbs().maxCoeff() + no_force);
  });
}

}  // namespace odeval::engine_rk4
