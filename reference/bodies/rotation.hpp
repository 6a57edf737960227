#pragma once
// Rotation matrices, by rows.
#include <array>

#include "odeval/problem.hpp"

namespace odeval::reference {

using Rotation = std::array<Vec3, 3>;  // rows; body to world

/// Of a rotation vector: its length is the angle, its direction the axis (Rodrigues).
Rotation rotation_of(const Vec3& turn_rad);

Rotation product(const Rotation& a, const Rotation& b);
Vec3 turned(const Rotation& r, const Vec3& v);       // body to world
Vec3 turned_back(const Rotation& r, const Vec3& v);  // world to body

/// Into the nine numbers of a BodyState.
void put(const Rotation& r, double (&rows)[9]);

}  // namespace odeval::reference
