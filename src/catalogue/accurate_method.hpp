#pragma once
// Method ode-rk4-double: the ODE adapter's world, moved by the fourth-order step.
#include "odeval/engine.hpp"

namespace odeval::catalogue {

/// Cartesian rows. Throws MachineError when ODE or the step refuses the scenario.
std::unique_ptr<Simulation> make_accurate(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::catalogue
