#pragma once
// A motion recorded for tests.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "odeval/engine.hpp"

namespace odeval::test {

struct Recorded {
  Outcome outcome;
  Motion motion;
};

inline Recorded recorded(Simulation& simulation, const SampleGrid& grid) {
  Motion motion(simulation.shape(), static_cast<std::size_t>(grid.rows));
  Outcome outcome = simulation.run(Recorder(motion));
  return {std::move(outcome), std::move(motion)};
}
inline Recorded recorded(MakeSimulation make, const Scenario& scenario, const SampleGrid& grid) {
  return recorded(*make(scenario, grid), grid);
}

/// Of joint coordinates, rad, over the first `samples` or as many as both have.
inline double largest_difference(const Motion& a, const Motion& b, std::size_t samples) {
  double most = 0;
  for (std::size_t k = 0; k < std::min({a.size(), b.size(), samples}); ++k) {
    for (std::size_t i = 0; i < a[k].q.size(); ++i) most = std::max(most, std::fabs(a[k].q[i] - b[k].q[i]));
  }
  return most;
}

}  // namespace odeval::test
