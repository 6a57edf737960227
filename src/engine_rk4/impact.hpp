#pragma once
// What contacts do to velocities and poses: complementarity, solved for the whole mechanism.
#include <vector>

#include "engine_rk4/motion.hpp"

namespace odeval::engine_rk4 {

/// A point where body a meets body b. World frame.
struct Contact {
  std::size_t a, b;  // one of them may be world_body
  Vector3d point;    // m
  Vector3d normal;   // unit; moving a along it takes the bodies apart
  double depth;      // m
  double restitution;
  std::size_t pair;  // which two geoms
};

/// Normal speed of a against b at a contact, m/s; negative: they approach.
double normal_speed(const Contact& contact, const State& state);

/// Newton's law with complementarity: after it every contact has v+ >= -e v- (e = 0 where it approaches slower than
/// `rest_speed`, or does not approach), impulses only push, and where one pushes its contact has exactly that speed.
/// All bodies feel the impulses through the joints. Uses the pose of the motion's last step or projection.
void strike(Motion& motion, const std::vector<Contact>& contacts, double rest_speed, State& state);

/// Moves the bodies apart, mass-weighted and with joints kept, until no contact is deeper than `depth`.
void push_out(Motion& motion, const std::vector<Contact>& contacts, double depth, State& state);

}  // namespace odeval::engine_rk4
