#pragma once
// Bodies that hang together, and the motion that they would share if they were one.
#include <numeric>
#include <span>
#include <vector>

#include "engines/ode_rk4/mechanism.hpp"

namespace odeval::engine_rk4 {

/// Bodies that joints and contacts connect. What does not move, the world or a kinematic body, connects nothing: it
/// holds.
class Islands {
 public:
  /// `pairs`: anything with bodies a and b.
  template <class Pairs>
  Islands(const Mechanism& mechanism, const Pairs& pairs)
      : mechanism_(mechanism), up_(mechanism.bodies.size()), held_(mechanism.bodies.size(), 0) {
    std::iota(up_.begin(), up_.end(), std::size_t{0});
    for (const Joint& joint : mechanism.joints) {
      join(joint);
      // Wheels that do not mesh where they touch, as on a belt, turn what they connect.
      if (!joint.gears.empty() && moves(joint.a)) held_[joint.a] = 1;
    }
    for (const auto& pair : pairs) join(pair);
  }

  /// The number of a pair's island.
  template <class Pair>
  std::size_t of(const Pair& pair) {
    return top(moves(pair.a) ? pair.a : pair.b);
  }
  /// Those of two bodies or more that nothing holds.
  std::vector<std::vector<std::size_t>> afloat();

 private:
  bool moves(std::size_t body) const { return body != world_body && mechanism_.bodies[body].inverse_mass > 0; }
  std::size_t top(std::size_t body) {
    while (up_[body] != body) body = up_[body] = up_[up_[body]];
    return body;
  }
  template <class Pair>
  void join(const Pair& pair) {
    if (moves(pair.a) && moves(pair.b)) {
      up_[top(pair.a)] = top(pair.b);
    } else if (moves(pair.a) || moves(pair.b)) {
      held_[moves(pair.a) ? pair.a : pair.b] = 1;
    }
  }

  const Mechanism& mechanism_;
  std::vector<std::size_t> up_;
  std::vector<char> held_;
};

/// Of one body: m, m/s and rad/s, in the world frame.
struct RigidMotion {
  Vector3d centre, velocity, spin;
  Twist at(const Vector3d& position) const { return {velocity + spin.cross(position - centre), spin}; }
};

/// With the masses and the momenta of bodies that move.
RigidMotion shared_motion(const Mechanism& mechanism, const State& state, std::span<const std::size_t> bodies);

}  // namespace odeval::engine_rk4
