#include "reference/closed_form/rotation.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::reference {

// R = cos(a) 1 + sin(a)/a [v]x + (1 - cos(a))/a^2 v v^T
Rotation rotation_of(const Vec3& turn_rad) {
  const double angle = length(turn_rad);
  const double half = angle == 0 ? 0.5 : std::sin(angle / 2) / angle;  // so that nothing cancels
  const double sine = 2 * half * std::cos(angle / 2);
  const double rest = 2 * half * half;
  const auto [x, y, z] = turn_rad;
  const double c = std::cos(angle);
  return {c + rest * x * x,        rest * x * y - sine * z, rest * x * z + sine * y,
          rest * x * y + sine * z, c + rest * y * y,        rest * y * z - sine * x,
          rest * x * z - sine * y, rest * y * z + sine * x, c + rest * z * z};
}

Rotation product(const Rotation& a, const Rotation& b) {
  Rotation c{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 row = turned_back(b, {a[3 * i], a[3 * i + 1], a[3 * i + 2]});
    std::ranges::copy(row, c.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return c;
}

Rotation transposed(const Rotation& r) { return {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}; }

Vec3 turned_back(const Rotation& r, const Vec3& v) {
  Vec3 sum{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) sum[j] += r[3 * i + j] * v[i];
  }
  return sum;
}

}  // namespace odeval::reference
