#pragma once
// Any scenario as a simulation in ODE.
#include "engines/ode/world_stepper.hpp"
#include "odeval/engine.hpp"

namespace odeval::engine_ode {

/// Samples of bodies and joints. Throws MachineError when ODE refuses the scenario.
std::unique_ptr<Simulation> make_step(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_quickstep(const Scenario& scenario, const SampleGrid& grid);

/// The same world, moved by another stepper. Its impacts are those that it locates.
std::unique_ptr<Simulation> make_stepped(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper);

}  // namespace odeval::engine_ode
