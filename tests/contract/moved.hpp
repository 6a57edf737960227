#pragma once
// Runs and scenes that tests of mechanisms in their methods share.
#include <utility>

#include "catalogue/methods.hpp"
#include "tests/check.hpp"
#include "tests/recorded.hpp"

namespace odeval::test {

/// All rows of a method's run, which it has to be able to do and to end.
inline Motion moved(const Scenario& scenario, const char* method) {
  const catalogue::Method& row = catalogue::find_method(method);
  CHECK(catalogue::does(row, scenario));
  Recorded run = recorded(row.make, scenario, sample_grid(scenario));
  CHECK(!run.outcome.diverged);
  CHECK_EQUAL(run.motion.size(), static_cast<std::size_t>(sample_grid(scenario).rows));
  return std::move(run.motion);
}

/// A floor, for bodies with names; the gravity of a scenario that says none.
inline Scenario on_a_floor(double duration_s) {
  Scenario scenario;
  scenario.name = scenario.file = "floor";
  scenario.named = true;
  scenario.step_s = 1e-3;
  scenario.duration_s = duration_s;
  scenario.mechanism.obstacles = {{HalfSpace{}, "floor"}};
  return scenario;
}

}  // namespace odeval::test
