#pragma once
// Recorded rows of a run in generalized coordinates, and what ends a run that blew up.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>

#include "odeval/method.hpp"

namespace odeval::reference {

/// The state at t = 0. State is (q1..qN, qd1..qdN).
template <std::size_t Numbers>
std::array<double, Numbers> start_state(const Scenario& scenario) {
  std::array<double, Numbers> y;
  std::copy_n(scenario.q0.begin(), Numbers / 2, y.begin());
  std::copy_n(scenario.qd0.begin(), Numbers / 2, y.begin() + Numbers / 2);
  return y;
}

template <std::size_t Numbers>
void record(Rows* rows, const std::array<double, Numbers>& y) {
  if (rows != nullptr) std::copy(y.begin(), y.end(), rows->append());
}

template <std::size_t Numbers>
bool finite(const std::array<double, Numbers>& y) {
  bool all = true;
  for (const double value : y) all &= std::isfinite(value);
  return all;
}

/// Marks the run as diverged at a state that is not finite, reached at time t by the step of that number.
template <std::size_t Numbers>
void set_not_finite(Outcome& outcome, const std::array<double, Numbers>& y, double t) {
  constexpr std::size_t n = Numbers / 2;
  std::size_t worst = 0;
  while (worst + 1 < Numbers && std::isfinite(y[worst])) ++worst;
  outcome.diverged = true;
  std::ostringstream text;
  text << (worst < n ? "q" : "qd") << worst % n + 1 << " is not finite after step " << outcome.steps << " (t = " << t
       << " s)";
  outcome.reason = text.str();
}

}  // namespace odeval::reference
