#pragma once
// Recorded rows of a run in generalized coordinates, and what ends a run that blew up.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>

#include "odeval/method.hpp"

namespace odeval::reference {

/// Gives a vector its size; an array has it.
template <class State>
void resize(State& y, std::size_t numbers) {
  if constexpr (requires { y.resize(numbers); }) y.resize(numbers);
}

/// The state at t = 0. State is (q1..qN, qd1..qdN).
template <std::size_t Numbers>
std::array<double, Numbers> start_state(const Scenario& scenario) {
  std::array<double, Numbers> y;
  std::copy_n(scenario.q0.begin(), Numbers / 2, y.begin());
  std::copy_n(scenario.qd0.begin(), Numbers / 2, y.begin() + Numbers / 2);
  return y;
}

/// The same as a State of any size, an array or a vector.
template <class State>
State start_state_as(const Scenario& scenario) {
  State y{};
  resize(y, 2 * scenario.q0.size());
  std::ranges::copy(scenario.qd0, std::ranges::copy(scenario.q0, y.begin()).out);
  return y;
}

template <class State>
void record(Rows* rows, const State& y) {
  if (rows != nullptr) std::copy(y.begin(), y.end(), rows->append());
}

template <class State>
bool finite(const State& y) {
  bool all = true;
  for (const double value : y) all &= std::isfinite(value);
  return all;
}

/// Marks the run as diverged at a state that is not finite, reached at time t by the step of that number.
template <class State>
void set_not_finite(Outcome& outcome, const State& y, double t) {
  const std::size_t n = y.size() / 2;
  std::size_t worst = 0;
  while (worst + 1 < y.size() && std::isfinite(y[worst])) ++worst;
  outcome.diverged = true;
  std::ostringstream text;
  text << (worst < n ? "q" : "qd") << worst % n + 1 << " is not finite after step " << outcome.steps << " (t = " << t
       << " s)";
  outcome.reason = text.str();
}

}  // namespace odeval::reference
