#pragma once
// Where bodies may meet: each place as one distance that falls to 0.
#include <optional>
#include <vector>

#include "odeval/mechanism.hpp"
#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {

/// A ball, an end of a capsule or a corner of a box, and the plane or the ball that it may meet.
struct ContactPoint {
  std::size_t body = 0;
  Vec3 corner_m{};                   // from the centre of mass, in the body's own frame
  double radius_m = 0;               // of a ball about that
  HalfSpace plane{};                 // that it may meet
  std::optional<std::size_t> other;  // or the ball that it may meet in the place of a plane
  double other_radius_m = 0;
  double restitution = 0;
};

/// How a contact point stands.
struct Meeting {
  double apart_m = 0;  // below 0 they overlap
  double rate_m_s = 0;
  Vec3 normal{};   // unit, from the other to the body
  Vec3 point_m{};  // where they are the nearest, in the world
};
Meeting meeting(const ContactPoint& point, const std::vector<Placed>& bodies);

/// All of a mechanism: of balls, boxes and capsules with planes, and of balls with each other. Nothing where anything
/// else may touch, or anything rubs or is a spring.
std::optional<std::vector<ContactPoint>> contact_points(const Mechanism& mechanism);

}  // namespace odeval::reference
