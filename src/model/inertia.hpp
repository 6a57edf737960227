#pragma once
// Which inertia tensors are those of bodies.
#include <algorithm>
#include <array>

namespace odeval {

/// Whether masses can be spread to give xx, yy, zz, xy, xz, yz: no moment about any axis is larger than the other two
/// together. With `turns` none may be zero either, as one may be of a part of a body; there 1e-18 kg m² are rounding.
inline bool is_inertia(const std::array<double, 6>& inertia, bool turns) {
  const double xx = inertia[0], yy = inertia[1], zz = inertia[2];
  const double xy = inertia[3], xz = inertia[4], yz = inertia[5];
  const auto least_minors = [&](double a, double b, double c, double sign) {
    const double de = sign * xy;
    const double df = sign * xz;
    const double ef = sign * yz;
    return std::array{std::min({a, b, c}), std::min({a * b - de * de, a * c - df * df, b * c - ef * ef}),
                      a * b * c + 2 * de * df * ef - a * ef * ef - b * df * df - c * de * de};
  };
  // The second moments of the mass, half the trace minus the tensor, are no less than zero in any direction.
  const double half = (xx + yy + zz) / 2;
  const auto spread = least_minors(half - xx, half - yy, half - zz, -1);
  const auto turning = least_minors(xx, yy, zz, 1);
  bool possible = true;
  double size = 1;
  const double whole = turns ? half : half + 1e-6;
  for (std::size_t k = 0; k < 3; ++k) {
    size *= whole;
    constexpr double rounding = 1e-12;  // of the numbers in a file
    possible = possible && spread[k] >= -rounding * size && (!turns || turning[k] > rounding * size);
  }
  return possible;
}

}  // namespace odeval
