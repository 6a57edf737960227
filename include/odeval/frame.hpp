#pragma once
// Frames in frames.
#include <cmath>
#include <cstddef>

#include "odeval/geometry.hpp"

namespace odeval {

/// A frame in another: where its origin stands there, and how it is turned.
struct Frame {
  Vec3 position_m{};
  Rotation rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// One after the other: a frame in a frame.
constexpr Rotation operator*(const Rotation& a, const Rotation& b) {
  Rotation ab{};
  for (std::size_t column = 0; column < 3; ++column) {
    const Vec3 turned_axis = turned(a, axis_of(b, column));
    for (std::size_t row = 0; row < 3; ++row) ab[3 * row + column] = turned_axis[row];
  }
  return ab;
}
constexpr Frame operator*(const Frame& a, const Frame& b) {
  return {a.position_m + turned(a.rotation, b.position_m), a.rotation * b.rotation};
}
constexpr Rotation transposed(const Rotation& r) { return {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}; }
/// The other frame in this one.
constexpr Frame inverse(const Frame& frame) {
  const Rotation back = transposed(frame.rotation);
  return {-1.0 * turned(back, frame.position_m), back};
}

/// Of a quaternion of any length but 0.
inline Rotation rotation_of_quaternion(double w, double x, double y, double z) {
  const double s = 2 / (w * w + x * x + y * y + z * z);
  return {1 - s * (y * y + z * z), s * (x * y - w * z),     s * (x * z + w * y),
          s * (x * y + w * z),     1 - s * (x * x + z * z), s * (y * z - w * x),
          s * (x * z - w * y),     s * (y * z + w * x),     1 - s * (x * x + y * y)};
}
/// A turn about a unit vector.
inline Rotation rotation_about(const Vec3& axis, double angle_rad) {
  const double half = std::sin(angle_rad / 2);
  return rotation_of_quaternion(std::cos(angle_rad / 2), half * axis[0], half * axis[1], half * axis[2]);
}
/// Of a rotation vector: its length is the angle, its direction the axis.
inline Rotation rotation_of_vector(const Vec3& turn_rad) {
  const double angle = length(turn_rad);
  return angle == 0 ? Frame{}.rotation : rotation_about((1 / angle) * turn_rad, angle);
}

}  // namespace odeval
