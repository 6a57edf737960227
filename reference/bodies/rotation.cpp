#include "reference/bodies/rotation.hpp"

#include <cmath>

namespace odeval::reference {

// R = cos(a) 1 + sin(a)/a [v]x + (1 - cos(a))/a^2 v v^T
Rotation rotation_of(const Vec3& turn_rad) {
  const double angle = std::sqrt(dot(turn_rad, turn_rad));
  const double half = angle == 0 ? 0.5 : std::sin(angle / 2) / angle;  // so that nothing cancels
  const double sine = 2 * half * std::cos(angle / 2);
  const double rest = 2 * half * half;
  const auto [x, y, z] = turn_rad;
  const double c = std::cos(angle);
  return {Vec3{c + rest * x * x, rest * x * y - sine * z, rest * x * z + sine * y},
          Vec3{rest * x * y + sine * z, c + rest * y * y, rest * y * z - sine * x},
          Vec3{rest * x * z - sine * y, rest * y * z + sine * x, c + rest * z * z}};
}

Rotation product(const Rotation& a, const Rotation& b) {
  Rotation c{};
  for (std::size_t i = 0; i < 3; ++i) c[i] = turned_back(b, a[i]);
  return c;
}

Vec3 turned(const Rotation& r, const Vec3& v) { return {dot(r[0], v), dot(r[1], v), dot(r[2], v)}; }

Vec3 turned_back(const Rotation& r, const Vec3& v) {
  Vec3 sum{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) sum[j] += r[i][j] * v[i];
  }
  return sum;
}

void put(const Rotation& r, double (&rows)[9]) {
  for (std::size_t k = 0; k < 9; ++k) rows[k] = r[k / 3][k % 3];
}

}  // namespace odeval::reference
