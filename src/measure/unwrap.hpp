#pragma once
// Angles without a cut at +-pi.
#include <cmath>

namespace odeval {

/// The angle plus the multiple of 2 pi that brings it nearest to `near`, rad. Not finite if either is not.
inline double unwrap(double angle, double near) {
  constexpr double turn = 6.28318530717958647692;
  return angle + turn * std::round((near - angle) / turn);
}

}  // namespace odeval
