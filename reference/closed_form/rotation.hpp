#pragma once
// Rotation matrices, as a BodyState holds them.
#include <array>

#include "odeval/geometry.hpp"

namespace odeval::reference {

using Rotation = std::array<double, 9>;  // by rows; body to world

/// Of a rotation vector: its length is the angle, its direction the axis (Rodrigues).
Rotation rotation_of(const Vec3& turn_rad);

Rotation product(const Rotation& a, const Rotation& b);
Rotation transposed(const Rotation& r);
/// From the world into the body; `turned` (geometry.hpp) is the other way.
Vec3 turned_back(const Rotation& r, const Vec3& v);

}  // namespace odeval::reference
