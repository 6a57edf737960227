#include "engines/ode_rk4/collider.hpp"

#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

/// How far from the origin geoms may be, m: hash spaces count cells of at least 2^level m in an int, and abort where
/// that overflows (dxHashSpace::collide).
double reach(dSpaceID space) {
  double smallest = INFINITY;
  if (dSpaceGetClass(space) == dHashSpaceClass) {
    int least = 0, most = 0;
    dHashSpaceGetLevels(space, &least, &most);
    smallest = std::ldexp(1, 31 + least);
  }
  for (int i = 0; i < dSpaceGetNumGeoms(space); ++i) {
    const dGeomID geom = dSpaceGetGeom(space, i);
    if (dGeomIsSpace(geom) != 0) smallest = std::min(smallest, reach(reinterpret_cast<dSpaceID>(geom)));
  }
  return smallest;
}

void survey(dSpaceID space, std::vector<double>& ground) {
  for (int i = 0; i < dSpaceGetNumGeoms(space); ++i) {
    const dGeomID geom = dSpaceGetGeom(space, i);
    if (dGeomIsSpace(geom) != 0) {
      survey(reinterpret_cast<dSpaceID>(geom), ground);
    } else if (dGeomGetBody(geom) == nullptr) {
      dReal found[6]{};
      if (dGeomGetClass(geom) == dPlaneClass) {
        dGeomPlaneGetParams(geom, found);
      } else {
        dGeomGetAABB(geom, found);
      }
      ground.insert(ground.end(), found, found + 6);
    }
  }
}

constexpr int most_contacts = 64;                     // of a pair of geoms
constexpr double parallel = 1e-9, turned_by = 1e-10;  // rad

/// Sides of two boxes that lie along each other.
bool are_parallel(dGeomID one, dGeomID other) {
  if (dGeomGetClass(one) != dBoxClass || dGeomGetClass(other) != dBoxClass) return false;
  const dReal *const r = dGeomGetRotation(one), *const s = dGeomGetRotation(other);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double cosine = std::fabs(r[i] * s[k] + r[4 + i] * s[4 + k] + r[8 + i] * s[8 + k]);
      if (cosine > parallel && cosine < 1 - parallel) return false;
    }
  }
  return true;
}

/// Whether its normal lies along an axis of the box.
bool is_square_to_face(const dContactGeom& contact, dGeomID box) {
  const dReal *const r = dGeomGetRotation(box), *const n = contact.normal;
  double most = 0;
  for (int i = 0; i < 3; ++i) most = std::max(most, std::fabs(r[i] * n[0] + r[4 + i] * n[1] + r[8 + i] * n[2]));
  return most > 1 - parallel;
}

/// The same, with a copy of a box in its place that is turned a little about none of its axes.
int collide_turned(dGeomID one, dGeomID box, dContactGeom* found) {
  dVector3 sides;
  dGeomBoxGetLengths(box, sides);
  const dGeomID copy = dCreateBox(nullptr, sides[0], sides[1], sides[2]);
  const dReal* const at = dGeomGetPosition(box);
  dGeomSetPosition(copy, at[0], at[1], at[2]);
  const dQuaternion little = {1, 0.26 * turned_by, 0.54 * turned_by, 0.80 * turned_by};
  dQuaternion turn, turned;
  dGeomGetQuaternion(box, turn);
  dQMultiply0(turned, turn, little);
  dGeomSetQuaternion(copy, turned);
  const int count = dCollide(one, copy, most_contacts, found, sizeof(dContactGeom));
  dGeomDestroy(copy);
  for (int i = 0; i < count; ++i) (found[i].g1 == copy ? found[i].g1 : found[i].g2) = box;
  return count;
}

/// Where boxes are parallel to rounding ODE takes that for the direction of an edge: in 2 % of poses it finds nothing
/// of what overlaps, or an edge in a wrong place. Turned by less than what rests is deep they show where they touch;
/// what is no deeper than rest is left to `arrive`.
int collide(dGeomID one, dGeomID other, dContactGeom* found) {
  const int count = dCollide(one, other, most_contacts, found, sizeof(dContactGeom));
  if (!are_parallel(one, other) || (count > 0 && is_square_to_face(found[0], other))) return count;
  const int again = collide_turned(one, other, found);
  const auto is_deep = [](const dContactGeom& contact) { return contact.depth > 2 * rest_depth; };
  return std::any_of(found, found + again, is_deep) ? again : 0;
}

}  // namespace

Collider::Collider(dSpaceID space, Ask ask) : space_(space), ask_(std::move(ask)) {}

void Collider::survey_ground(std::vector<double>& ground) const {
  ground.clear();
  if (space_ != nullptr && ask_) survey(space_, ground);
}

void Collider::look(const Mechanism& mechanism, const State& state, std::vector<Contact>& contacts) {
  contacts.clear();
  stop(mechanism, state, contacts);
  if (space_ == nullptr || !ask_) return;
  show_poses(mechanism, state);
  check_reach(mechanism);
  pairs_.clear();
  pair_up(space_);
  for (const auto& [one, other] : pairs_) meet(mechanism, one, other, contacts);
}

/// A joint beyond one of its stops, which is a contact with a depth of its own kind.
void Collider::stop(const Mechanism& mechanism, const State& state, std::vector<Contact>& contacts) {
  for (const Joint& joint : mechanism.joints) {
    for (const Stop& stop : joint.stops) {
      const Pose& a = state[joint.a].pose;
      const Matrix3d turn_a = rotation(a.turn);
      const Matrix3d turn_b = joint.b == world_body ? Matrix3d::Identity() : rotation(state[joint.b].pose.turn);
      const Vector3d x_b = joint.b == world_body ? Vector3d::Zero() : state[joint.b].pose.position;
      const Vector3d axis = turn_a * stop.axis, of_a = turn_a * stop.of_a, of_b = turn_b * stop.of_b;
      const double at = stop.slides ? stop.at_start + axis.dot(a.position + of_a - x_b - of_b)
                                    : std::atan2(axis.dot(of_b.cross(of_a)), of_b.dot(of_a));
      const auto touch = [&](double depth, double way_out) {
        if (depth < 0) return;
        contacts.push_back({joint.a, joint.b, x_b + of_b, way_out * axis, depth, stop.bounce,
                            std::pair<const void*, const void*>(joint.id, &stop), !stop.slides});
        contacts.back().is_stop = true;
      };
      touch(stop.low - at, 1);
      touch(at - stop.high, -1);
    }
  }
}

/// ODE leaves it to the caller to look inside the spaces of a space.
void Collider::pair_up(dSpaceID space) {
  dSpaceCollide(space, &pairs_, &near);
  for (int i = 0; i < dSpaceGetNumGeoms(space); ++i) {
    const dGeomID geom = dSpaceGetGeom(space, i);
    if (dGeomIsSpace(geom) != 0) pair_up(reinterpret_cast<dSpaceID>(geom));
  }
}

void Collider::near(void* pairs, dGeomID one, dGeomID other) {
  if (dGeomIsSpace(one) != 0 || dGeomIsSpace(other) != 0) {
    dSpaceCollide2(one, other, pairs, &near);
    return;
  }
  const dBodyID a = dGeomGetBody(one);
  const dBodyID b = dGeomGetBody(other);
  const auto moves = [](dBodyID body) { return body != nullptr && dBodyIsKinematic(body) == 0; };
  if (a == b || (!moves(a) && !moves(b)) || (a != nullptr && b != nullptr && dAreConnected(a, b) != 0)) return;
  static_cast<std::vector<std::pair<dGeomID, dGeomID>>*>(pairs)->emplace_back(one, other);
}

void Collider::check_reach(const Mechanism& mechanism) const {
  const double limit = reach(space_);
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    const dBodyID body = mechanism.bodies[i].id;
    for (dGeomID geom = dBodyGetFirstGeom(body); geom != nullptr; geom = dBodyGetNextGeom(geom)) {
      dReal box[6];
      dGeomGetAABB(geom, box);
      if (std::ranges::all_of(box, [limit](dReal at) { return std::fabs(at) < limit; })) continue;
      refuse("body " + std::to_string(i) + " comes farther from the origin than ODE's collision detection reaches (" +
                 shown(limit) + " m); take a smaller step",
             body);
    }
  }
}

void Collider::meet(const Mechanism& mechanism, dGeomID one, dGeomID other, std::vector<Contact>& contacts) const {
  const auto bounce = ask_(one, other);
  if (!bounce) return;
  if (!(bounce->restitution >= 0 && bounce->restitution <= 1)) {
    refuse("a restitution must be 0 to 1, not " + shown(bounce->restitution));
  }
  if (!(bounce->friction >= 0 && std::isfinite(bounce->friction))) {
    refuse("a coefficient of friction must be 0 or more and finite, not " + shown(bounce->friction));
  }
  if (!(bounce->rho >= 0 && std::isfinite(bounce->rho))) {
    refuse("a coefficient of rolling friction must be 0 m or more and finite, not " + shown(bounce->rho));
  }
  if (!(bounce->rhoN >= 0 && std::isfinite(bounce->rhoN))) {
    refuse("a coefficient of spinning friction must be 0 m or more and finite, not " + shown(bounce->rhoN));
  }
  dContactGeom found[most_contacts];
  const int count = collide(one, other, found);
  const auto number = [&](dGeomID geom) {
    const auto at = mechanism.numbers.find(dGeomGetBody(geom));
    return at == mechanism.numbers.end() ? world_body : at->second;
  };
  for (int i = 0; i < count; ++i) {
    const dContactGeom& geom = found[i];
    // The normal takes the first geom of the contact out of the second.
    contacts.push_back({number(geom.g1),
                        number(geom.g2),
                        {geom.pos[0], geom.pos[1], geom.pos[2]},
                        {geom.normal[0], geom.normal[1], geom.normal[2]},
                        geom.depth,
                        bounce->restitution,
                        std::minmax<const void*>(one, other),
                        false,
                        false,
                        bounce->friction,
                        bounce->rho,
                        bounce->rhoN});
  }
}

}  // namespace odeval::engine_rk4
