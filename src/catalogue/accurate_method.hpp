#pragma once
// Methods ode-rk4-double and ode-rk8-double: the ODE adapter's world, moved by the accurate step.
#include "odeval/engine.hpp"

namespace odeval::catalogue {

/// Cartesian rows. Throws MachineError when ODE or the step refuses the scenario.
std::unique_ptr<Simulation> make_accurate_4(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_accurate_8(const Scenario& scenario, const SampleGrid& grid);

/// Of order 8 again, each step of the grid taken in 1, 2, 4 or 8 steps. Controllers that look once a step look once a
/// step of the grid.
std::unique_ptr<Simulation> make_accurate_8_in_parts(const Scenario& scenario, const SampleGrid& grid, int parts);

}  // namespace odeval::catalogue
