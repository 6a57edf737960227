#pragma once
// A pendulum in Cartesian coordinates with Lagrange multipliers, moved by fixed steps.
#include <memory>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// Samples of bodies and joints. Each sample's joint forces are those of its own state. Scenarios without a wall. Obeys
/// [maximal].
std::unique_ptr<Simulation> make_maximal_euler(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_maximal_rk4(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
