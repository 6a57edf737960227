#pragma once
// Random trees of bodies and joints.
#include <random>

#include "tests/accurate/worlds.hpp"

namespace odeval::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double within(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int upto(int most) { return std::uniform_int_distribution<int>(0, most)(engine_); }
  Vector3d vector(double size) { return {within(-size, size), within(-size, size), within(-size, size)}; }
  Vector3d axis() { return vector(1).normalized(); }
  Quaterniond turn() { return Quaterniond(Eigen::AngleAxisd(within(0, 3), axis())); }

 private:
  std::mt19937 engine_;
};

/// A tree of 2 to 9 boxes; each hangs on an earlier one or, when `anchored`, the first also on the world. The start
/// turns rigidly, which keeps every joint's velocities, and the joints are free to move from there on.
inline void grow(World& world, Random& random, bool anchored) {
  const int bodies = 2 + random.upto(7);
  for (int i = 0; i < bodies; ++i) {
    const Vector3d sides(random.within(0.1, 0.6), random.within(0.1, 0.6), random.within(0.1, 0.6));
    const dBodyID body = world.box(random.within(0.3, 3), sides, random.vector(1.5), random.turn());
    const dBodyID parent = i == 0 ? nullptr : world.bodies[static_cast<std::size_t>(random.upto(i - 1))];
    if (parent == nullptr && !anchored) continue;
    const Vector3d near = vec(dBodyGetPosition(body)) + random.vector(0.5);
    const Vector3d axis = random.axis();
    const bool first = random.upto(1) == 0;
    const dBodyID a = first ? body : parent;
    const dBodyID b = first ? parent : body;
    switch (random.upto(parent == nullptr ? 3 : 4)) {  // fixed to the world nothing would move
      case 0:
        world.hinge(a, b, near, axis);
        break;
      case 1:
        world.ball(a, b, near);
        break;
      case 2:
        world.slider(a, b, axis);
        break;
      case 3:
        world.universal(a, b, near, axis, axis.unitOrthogonal());
        break;
      default:
        world.fixed(a, b);
        break;
    }
  }
  const Vector3d spin = anchored ? Vector3d::Zero() : random.vector(2);
  const Vector3d velocity = anchored ? Vector3d::Zero() : random.vector(1);
  for (const dBodyID body : world.bodies) {
    World::move(body, velocity + spin.cross(vec(dBodyGetPosition(body))), spin);
  }
}

}  // namespace odeval::test
