#pragma once
// The greater of two numbers, of which one may be none.
#include <cmath>

namespace odeval {

/// Not-a-number wins, so that a broken sample never looks sound.
inline double greater(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

}  // namespace odeval
