#pragma once
// The state of a run in joint coordinates, (q1..qn, qd1..qdn): how it starts, is recorded, and blows up.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// Gives a vector its size; an array has it.
template <class State>
void resize(State& y, std::size_t numbers) {
  if constexpr (requires { y.resize(numbers); }) y.resize(numbers);
}

/// The state at t = 0. State is an array of 2n numbers, or a vector.
template <class State>
State start_state(const PlanarView& view) {
  State y{};
  resize(y, 2 * view.q0.size());
  std::ranges::copy(view.qd0, std::ranges::copy(view.q0, y.begin()).out);
  return y;
}

/// Fills the recorder's next sample, if it records.
template <class State>
void record(Recorder recorder, const State& y) {
  if (!recorder) return;
  const Sample sample = recorder.next();
  const auto* const rates = y.data() + sample.q.size();
  const auto number = [](const auto& value) { return static_cast<double>(value); };
  std::transform(y.data(), rates, sample.q.begin(), number);
  std::transform(rates, y.data() + y.size(), sample.qd.begin(), number);
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
