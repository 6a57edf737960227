#include "engines/ode_rk4/tree.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {
namespace {

/// r m r'.
Symmetric turned(const Matrix3d& r, const Symmetric& m) {
  double p[3][3];  // r m
  for (Eigen::Index i = 0; i < 3; ++i) {
    p[i][0] = r(i, 0) * m.xx + r(i, 1) * m.xy + r(i, 2) * m.xz;
    p[i][1] = r(i, 0) * m.xy + r(i, 1) * m.yy + r(i, 2) * m.yz;
    p[i][2] = r(i, 0) * m.xz + r(i, 1) * m.yz + r(i, 2) * m.zz;
  }
  const auto at = [&](Eigen::Index i, Eigen::Index k) {
    return p[i][0] * r(k, 0) + p[i][1] * r(k, 1) + p[i][2] * r(k, 2);
  };
  return {at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(0, 2), at(1, 2)};
}

Vector3d without(const Vector3d& v, const Vector3d& axis) { return v - axis.dot(v) * axis; }

/// 1 / x of a cosine of a small angle, to its sixth power.
double over_almost_one(double x) { return 1 + (1 - x) * (2 - x); }

double farthest(const Vector3d& v) { return std::max(std::max(std::fabs(v[0]), std::fabs(v[1])), std::fabs(v[2])); }

Matrix3d inverse(const Matrix3d& m) { return m.llt().solve(Matrix3d::Identity()); }

}  // namespace

void Tree::look(const State& state) {
  stale_ = true;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    Now& now = now_[i];
    const Now& parent = parent_of(link);
    now.arm.noalias() = parent.turn * link.arm;
    if (link.body == none) {  // goes with its parent, and turns about its parent's axis
      now.turn = parent.turn;
      now.place = parent.place + now.arm;
      now.along.noalias() = parent.turn * link.parent_axis;
      continue;
    }
    const Pose& pose = state[link.body].pose;
    now.turn = rotation(pose.turn);
    now.centre.noalias() = now.turn * link.centre;
    now.place = pose.position - now.centre;
    if (link.kind == Kind::free) continue;
    now.apart = now.place - parent.place - now.arm;
    now.axis.noalias() = now.turn * link.axis;
    now.parent_axis.noalias() = parent.turn * link.parent_axis;
    // The rows of a hinge are square to the axis of its second body; a slider's axis is on its first.
    const bool along_parents = (link.kind == Kind::hinge && link.is_a) || (link.kind == Kind::slider && !link.is_a);
    now.along = along_parents ? now.parent_axis : now.axis;
    if (link.kind == Kind::slider) now.arm += now.apart;
  }
}

JointError Tree::find_gaps() {
  JointError largest;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (!has_joint(links_[i])) continue;
    Offset& found = now_[i].gap;
    gap(links_[i], now_[i], found);
    const double size = std::max(farthest(found.turning), farthest(found.moving));
    const double known = found.turning.sum() + found.moving.sum();
    if (size > largest.size) largest = {size, links_[i].joint};
    if (std::isnan(known)) return {known, links_[i].joint};  // which maxima may pass over
  }
  return largest;
}

/// What closes a joint.
void Tree::gap(const Link& link, const Now& now, Offset& offset) const {
  offset.turning.setZero();
  offset.moving = -now.apart;
  switch (link.kind) {
    case Kind::hinge:
      offset.turning = over_almost_one(now.axis.dot(now.parent_axis)) * now.axis.cross(now.parent_axis);
      break;
    case Kind::universal: {
      const Vector3d across = now.axis.cross(now.parent_axis);
      offset.turning = -now.axis.dot(now.parent_axis) / across.squaredNorm() * across;
      break;
    }
    case Kind::slider:
    case Kind::fixed: {
      const Matrix3d child = now.turn * link.same_turn;
      const Matrix3d parent = parent_of(link).turn * link.parent_same_turn;
      for (Eigen::Index k = 0; k < 3; ++k) offset.turning += 0.5 * child.col(k).cross(parent.col(k));
      if (link.kind == Kind::fixed) break;
      offset.moving = without(offset.moving, now.along);
      if (link.is_a) offset.moving += offset.turning.cross(now.apart);
      break;
    }
    default:
      break;
  }
}

/// Of a joint's two bodies.
struct Tree::Speeds {
  Vector3d child_spin, parent_spin;
  Vector3d apart;  // of the child's origin against the joint's place on the parent

  Speeds(const Link& link, const Now& now, const State& state) {
    const Twist& child = state[link.body].twist;
    child_spin = child.angular;
    apart = child.linear - child.angular.cross(now.centre);
    parent_spin.setZero();
    if (link.parent_body == world_body) return;
    const BodyNow& parent = state[link.parent_body];
    parent_spin = parent.twist.angular;
    apart -= parent.twist.linear + parent_spin.cross(now.place - now.apart - parent.pose.position);
  }
  /// Of the body that has a slider's axis.
  const Vector3d& axis_spin(const Link& link) const { return link.is_a ? child_spin : parent_spin; }
};

/// What makes the velocities of a joint's bodies agree.
void Tree::slip(const Link& link, const Now& now, const State& state, Offset& offset) {
  const Speeds speeds(link, now, state);
  const Vector3d spin = speeds.child_spin - speeds.parent_spin;
  offset.turning.setZero();
  offset.moving = -speeds.apart;
  switch (link.kind) {
    case Kind::hinge:
      offset.turning = without(-spin, now.along);
      break;
    case Kind::universal: {
      const Vector3d across = now.axis.cross(now.parent_axis);
      offset.turning = -across.dot(spin) / across.squaredNorm() * across;
      break;
    }
    case Kind::slider:
      offset.turning = -spin;
      offset.moving = without(offset.moving + speeds.axis_spin(link).cross(now.apart), now.along);
      if (link.is_a) offset.moving += offset.turning.cross(now.apart);
      break;
    case Kind::fixed:
      offset.turning = -spin;
      break;
    default:
      break;
  }
}

/// Accelerations of a joint's bodies beside each other that their velocities make.
void Tree::bias(const Link& link, const Now& now, const State& state, Offset& offset) {
  const Vector3d& w = state[link.body].twist.angular;
  const Vector3d& carried = parent_spin(link, state);
  offset.turning = carried.cross(w);
  offset.moving = carried.cross(carried.cross(now.arm));
  switch (link.kind) {
    case Kind::hinge: {
      // Zero where they turn about the axis alone.
      const Vector3d spin = w - carried;
      const Vector3d askew = spin.dot(now.along) * spin - spin.squaredNorm() * now.along;
      const double share = over_almost_one(now.axis.dot(now.parent_axis));
      if (link.is_a) {
        offset.turning -= share * askew.cross(now.axis);
      } else {
        offset.turning += share * askew.cross(now.parent_axis);
      }
      break;
    }
    case Kind::universal: {
      const Vector3d across = now.axis.cross(now.parent_axis);
      const Vector3d rate = w.cross(now.axis).cross(now.parent_axis) + now.axis.cross(carried.cross(now.parent_axis));
      offset.turning = -rate.dot(w - carried) / across.squaredNorm() * across;
      break;
    }
    case Kind::slider: {
      const Speeds speeds(link, now, state);
      const Vector3d& spin = speeds.axis_spin(link);
      offset.moving =
          carried.cross(carried.cross(now.arm - now.apart)) + spin.cross(2 * speeds.apart - spin.cross(now.apart));
      if (link.is_a) offset.moving += offset.turning.cross(now.apart);
      break;
    }
    default:
      break;
  }
}

void Tree::factor() {
  stale_ = false;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    Now& now = now_[i];
    if (link.body == none) {
      now.j = now.m = {};
      now.h.setZero();
      continue;
    }
    now.j = now.inertia = turned(now.turn, link.inertia);
    now.m = {link.mass, link.mass, link.mass};
    const Vector3d r = link.mass * now.centre;
    now.h << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
  }
  for (std::size_t i = links_.size(); i-- > 0;) {
    eliminate(links_[i], now_[i]);
    if (links_[i].parent != none) hand_on(links_[i], now_[i], now_[links_[i].parent]);
  }
}

/// Its inertia, to its parent's: of an arm a, h grows by a x m, and j by c + c', c = a x (h + a x m / 2)'; less what
/// the joint leaves free, which waits for a division, and all else does not wait for it.
void Tree::hand_on(const Link& link, const Now& now, Now& parent) {
  const Vector3d& a = now.arm;
  const double m[3][3] = {
      {now.m.xx, now.m.xy, now.m.xz}, {now.m.xy, now.m.yy, now.m.yz}, {now.m.xz, now.m.yz, now.m.zz}};
  double c[3][3];
  for (Eigen::Index k = 0; k < 3; ++k) {
    // Row k of a x m, which is column k of m x a.
    const Eigen::Index u = (k + 1) % 3, v = (k + 2) % 3;
    double half[3];
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double more = a[u] * m[v][i] - a[v] * m[u][i];
      half[i] = now.h(k, i) + 0.5 * more;
      parent.h(k, i) += now.h(k, i) + more;
    }
    c[0][k] = a[1] * half[2] - a[2] * half[1];
    c[1][k] = a[2] * half[0] - a[0] * half[2];
    c[2][k] = a[0] * half[1] - a[1] * half[0];
  }
  parent.j.add(now.j);
  parent.j.add({2 * c[0][0], 2 * c[1][1], 2 * c[2][2], c[0][1] + c[1][0], c[0][2] + c[2][0], c[1][2] + c[2][1]});
  parent.m.add(now.m);
  if (!has_s(link)) return;
  parent.j.take(now.load_n, now.answer_n);
  parent.m.take(now.load_f, now.answer_f);
  for (Eigen::Index k = 0; k < 3; ++k) {
    for (Eigen::Index i = 0; i < 3; ++i) parent.h(i, k) -= now.answer_n[i] * now.load_f[k];
  }
}

void Tree::eliminate(const Link& link, Now& now) {
  // Loads about the link's own origin, by a unit of s.
  const auto free_along = [&](const Vector3d& n, const Vector3d& f, const Vector3d& along_s) {
    const double inverse = 1 / now.along.dot(along_s);
    now.load_n = n + now.arm.cross(f);
    now.load_f = f;
    now.answer_n = inverse * now.load_n;
    now.answer_f = inverse * now.load_f;
    now.share = inverse * now.along;
  };
  switch (link.kind) {
    case Kind::hinge:
    case Kind::universal: {
      const Vector3d n = now.j * now.along;
      free_along(n, now.h.transpose() * now.along, n);
      break;
    }
    case Kind::slider: {
      const Vector3d f = now.m * now.along;
      free_along(now.h * now.along, f, f);
      break;
    }
    case Kind::ball:
      now.inverse_j = inverse(now.j.full());
      now.coupling.noalias() = now.inverse_j * now.h;
      now.m = Symmetric::of(now.m.full() - now.h.transpose() * now.coupling);
      now.j = {};
      now.h.setZero();
      break;
    case Kind::free:
      now.inverse_m = inverse(now.m.full());
      now.coupling.noalias() = now.inverse_m * now.h.transpose();
      now.inverse_j = inverse(now.j.full() - now.h * now.coupling);
      break;
    case Kind::fixed:
      break;
  }
}

void Tree::accelerate(const State& state, const std::vector<Wrench>& forces, std::vector<Twist>& accelerations) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    Now& now = now_[i];
    if (link.body == none) {
      const Vector3d& carried = parent_spin(link, state);
      unload(now);
      now.offset.moving = carried.cross(carried.cross(now.arm));
      continue;
    }
    const Wrench& force = forces[link.body];
    const Vector3d& w = state[link.body].twist.angular;
    now.n = w.cross(now.inertia * w) - now.centre.cross(force.force) - force.torque;
    now.centripetal = w.cross(w.cross(now.centre));
    now.f = link.mass * now.centripetal - force.force;
    bias(link, now, state, now.offset);
  }
  solve(accelerations);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (links_[i].body != none) accelerations[links_[i].body].linear += now_[i].centripetal;
  }
}

void Tree::respond(const std::vector<Wrench>& impulses, std::vector<Twist>& changes) {
  refresh();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    Now& now = now_[i];
    unload(now);
    if (links_[i].body == none) continue;
    const Wrench& impulse = impulses[links_[i].body];
    now.n = -now.centre.cross(impulse.force) - impulse.torque;
    now.f = -impulse.force;
  }
  solve(changes);
}

void Tree::close(std::vector<Twist>& displacements) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    unload(now_[i]);
    if (has_joint(links_[i])) now_[i].offset = now_[i].gap;
  }
  solve(displacements);
}

void Tree::agree(const State& state, std::vector<Twist>& changes) {
  if (floats_) refresh();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    unload(now_[i]);
    if (has_joint(links_[i])) slip(links_[i], now_[i], state, now_[i].offset);
  }
  solve(changes);
}

void Tree::unload(Now& now) {
  for (Vector3d* const v : {&now.n, &now.f, &now.offset.turning, &now.offset.moving}) v->setZero();
}

const Vector3d& Tree::parent_spin(const Link& link, const State& state) {
  static const Vector3d none_at_all = Vector3d::Zero();
  return link.parent_body == world_body ? none_at_all : state[link.parent_body].twist.angular;
}

/// From loads and offsets to the motion of origins, and of bodies.
void Tree::solve(std::vector<Twist>& twists) {
  load_parents();
  follow_parents(twists);
}

// Here and below in local variables what would else be written and read again, on the way that each link waits for.
void Tree::load_parents() {
  for (std::size_t i = links_.size(); i-- > 0;) {
    const Link& link = links_[i];
    Now& now = now_[i];
    if (link.kind == Kind::free) continue;
    const auto& [turning, moving] = now.offset;
    Now& parent = link.parent == none ? world_ : now_[link.parent];  // which nobody asks for its loads
    // What a ball's torque does to it, it does not hand on, and its turning is none of its parent's.
    if (link.kind == Kind::ball) {
      now.f += now.m * moving - now.coupling.transpose() * now.n;
      parent.n += now.arm.cross(now.f);
      parent.f += now.f;
      continue;
    }
    const Vector3d n = now.n + now.j * turning + now.h * moving;
    const Vector3d f = now.f + now.h.transpose() * turning + now.m * moving;
    now.n = n;
    now.f = f;
    if (has_s(link)) {
      const double s = -now.share.dot(link.kind == Kind::slider ? f : n);
      now.push = s;
      parent.n += n + now.arm.cross(f) + s * now.load_n;
      parent.f += f + s * now.load_f;
    } else {
      parent.n += n + now.arm.cross(f);
      parent.f += f;
    }
  }
}

void Tree::follow_parents(std::vector<Twist>& twists) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    Now& now = now_[i];
    const Now& parent = parent_of(link);
    Vector3d turning = parent.turning + now.offset.turning;
    Vector3d moving = parent.moving + parent.turning.cross(now.arm) + now.offset.moving;
    switch (link.kind) {
      case Kind::hinge:
      case Kind::universal:
      case Kind::slider: {
        const double s = now.push - (now.answer_n.dot(parent.turning) + now.answer_f.dot(parent.moving));
        (link.kind == Kind::slider ? moving : turning) += s * now.along;
        break;
      }
      case Kind::ball:
        turning = -(now.inverse_j * now.n + now.coupling * moving);
        break;
      case Kind::free: {
        const Vector3d pushed = now.inverse_m * now.f;
        turning = now.inverse_j * (now.h * pushed - now.n);
        moving = -(pushed + now.coupling * turning);
        break;
      }
      case Kind::fixed:
        break;
    }
    now.turning = turning;
    now.moving = moving;
    if (link.body == none) continue;
    Twist& twist = twists[link.body];
    twist.linear = moving + turning.cross(now.centre);
    twist.angular = turning;
  }
}

Wrench Tree::force(std::size_t joint, bool on_a) const {
  if (link_of_[joint] == none) return {Vector3d::Zero(), Vector3d::Zero()};
  const Link& link = links_[link_of_[joint]];
  const Now& now = now_[link_of_[joint]];
  const Vector3d turning = now.turning - now.offset.turning, moving = now.moving - now.offset.moving;
  const Vector3d force = now.f + now.h.transpose() * turning + now.m * moving;
  // About the origin; of a ball joint there is none, and n is what was left to the ball itself.
  Vector3d torque = Vector3d::Zero();
  if (link.kind != Kind::ball) torque = now.n + now.j * turning + now.h * moving;
  if (link.is_a == on_a) return {force, torque - now.centre.cross(force)};
  const Link& first = link.kind == Kind::universal ? links_[link.parent] : link;
  Vector3d from_parent = now.arm;  // from its centre
  if (link.kind == Kind::universal) from_parent += now_[link.parent].arm;
  if (link.parent_body != world_body) from_parent -= now_[first.parent].centre;
  return {-force, -torque - from_parent.cross(force)};
}

}  // namespace odeval::engine_rk4
