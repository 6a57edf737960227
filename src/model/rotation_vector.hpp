#pragma once
// From a rotation back to the vector that a file has for it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "odeval/geometry.hpp"

namespace odeval {

/// Of a rotation: its length is the angle, from 0 to pi, its direction the axis. By the quaternion, from its largest
/// element, so that no turn is too small or too large for its digits.
inline Vec3 rotation_vector_of(const Rotation& r) {
  const std::array squares{1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                           1 - r[0] - r[4] + r[8]};
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(squares) - squares.begin());
  const Vec3 odd{r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  std::array<double, 4> q{};
  if (largest == 0) {
    q = {squares[0], odd[0], odd[1], odd[2]};
  } else {
    const std::size_t i = largest - 1;
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    q[0] = odd[i];
    q[i + 1] = squares[largest];
    q[j + 1] = r[3 * i + j] + r[3 * j + i];
    q[k + 1] = r[3 * i + k] + r[3 * k + i];
  }
  if (q[0] < 0) q = {-q[0], -q[1], -q[2], -q[3]};
  const Vec3 part{q[1], q[2], q[3]};
  const double sine = length(part);
  if (sine == 0) return {};
  return (2 * std::atan2(sine, q[0]) / sine) * part;
}

}  // namespace odeval
