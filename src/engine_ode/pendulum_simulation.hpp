#pragma once
// Pendulums stepped by ODE.
#include "odeval/method.hpp"

namespace odeval::engine_ode {

/// Cartesian rows. Throws MachineError when ODE refuses the scenario.
std::unique_ptr<Simulation> make_step(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_quickstep(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::engine_ode
