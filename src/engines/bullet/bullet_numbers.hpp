#pragma once
// Vectors and turns as Bullet has them.
#include <btBulletDynamicsCommon.h>

#include "engines/tree/hanging.hpp"
#include "engines/tree/principal.hpp"

namespace odeval::engine_bullet {

inline btVector3 bullet(const Vec3& v) { return {btScalar(v[0]), btScalar(v[1]), btScalar(v[2])}; }
inline Vec3 ours(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }

inline btMatrix3x3 bullet(const std::array<double, 9>& m) {
  btMatrix3x3 made;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      made[row][column] = btScalar(m[3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)]);
    }
  }
  return made;
}
inline Rotation ours(const btMatrix3x3& m) {
  Rotation made{};
  for (std::size_t k = 0; k < 9; ++k) made[k] = m[static_cast<int>(k / 3)][static_cast<int>(k % 3)];
  return made;
}

/// Bullet's bodies stand along their principal axes, ours along their own.
struct Principal {
  btMatrix3x3 axes;   // by columns, in the body
  btVector3 moments;  // kg m², along them
  btMatrix3x3 start;  // the same axes in the world at t = 0
  btVector3 centre;   // of mass, likewise

  Principal(const Body& body, const engine_tree::Place& place) : centre(bullet(place.position_m)) {
    const engine_tree::Principal found = engine_tree::principal_of(engine_tree::inertia_of(body));
    axes = bullet(found.axes);
    moments = bullet(found.moments_kgm2);
    start = bullet(place.rotation) * axes;
  }

  /// A direction of the world at t = 0 along them.
  btVector3 along(const Vec3& direction) const { return start.transpose() * bullet(direction); }
  /// A point of the world at t = 0, from the centre.
  btVector3 from_centre(const Vec3& point_m) const { return start.transpose() * (bullet(point_m) - centre); }
  /// Our rotation of a body whose principal axes stand so.
  Rotation rotation(const btMatrix3x3& now) const { return ours(now * axes.transpose()); }
};

}  // namespace odeval::engine_bullet
