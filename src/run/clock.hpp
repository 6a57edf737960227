#pragma once
#include <ctime>

namespace odeval::run {

/// Seconds that go on whatever anybody does to the clock.
inline double steady_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace odeval::run
