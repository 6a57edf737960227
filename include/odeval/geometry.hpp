#pragma once
// Points and directions in space: the one place that says how they are added, turned and measured.
//
// Sums stand in a fixed order, x before y before z, and no product is fused: the same numbers give the same bits in
// every folder. (Eigen's own dot product of three adds y and z first, so points that are recorded are not Eigen's.)
#include <array>
#include <cmath>

namespace odeval {

/// x, y, z, in m, m/s, rad/s, N as the name says. World frame unless it says otherwise: z points up, gravity along -z.
using Vec3 = std::array<double, 3>;

/// Body to world, nine numbers by rows: column k is the body's axis k in the world.
using Rotation = std::array<double, 9>;

/// a . b
constexpr double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
/// a x b, right-handed.
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// Element by element, in the unit that both have.
constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
/// From b to a.
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
/// A vector of another length, or the other way round for s < 0; s may have a unit of its own.
constexpr Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }

/// Euclidean, without protection against overflow: infinite where a square is.
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
/// Between two points, in their unit.
inline double distance(const Vec3& a, const Vec3& b) { return length(a - b); }

/// The direction of a vector: length 1 to rounding. Not a number of a vector that has none.
/// Divides once and multiplies three times, which is not the same in the last bit as three divisions.
inline Vec3 unit(const Vec3& a) { return (1 / length(a)) * a; }

/// A direction that is fixed in a body, in the world. Any nine numbers by rows do, so that it is a matrix times a
/// vector.
constexpr Vec3 turned(const Rotation& rotation, const Vec3& v) {
  return {dot({rotation[0], rotation[1], rotation[2]}, v), dot({rotation[3], rotation[4], rotation[5]}, v),
          dot({rotation[6], rotation[7], rotation[8]}, v)};
}

/// One of a body's own axes (0, 1, 2) in the world, unit: a column of its rotation.
constexpr Vec3 axis_of(const Rotation& rotation, std::size_t axis) {
  return {rotation[axis], rotation[3 + axis], rotation[6 + axis]};
}

}  // namespace odeval
