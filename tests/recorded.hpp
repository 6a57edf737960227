#pragma once
// A motion recorded for tests.
#include <cstddef>

#include "odeval/engine.hpp"

namespace odeval::test {

struct Recorded {
  Outcome outcome;
  Motion motion;  // as many samples as the run has left
};

inline Recorded recorded(MakeSimulation make, const Scenario& scenario, const SampleGrid& grid) {
  const auto simulation = make(scenario, grid);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid.rows));
  Outcome outcome = simulation->run(Recorder(motion));
  return {std::move(outcome), std::move(motion)};
}

}  // namespace odeval::test
