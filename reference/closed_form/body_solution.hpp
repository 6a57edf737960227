#pragma once
// A true motion of bodies at the times of a trace.
#include "odeval/engine.hpp"
#include "odeval/reference.hpp"

namespace odeval::reference {

/// Throws UserError as `make_body_motion`.
Reference solve_body_reference(const Scenario& scenario, const SampleGrid& grid);

/// The same as a method: samples of bodies and joints.
std::unique_ptr<Simulation> make_body_analytic(const Scenario& scenario, const SampleGrid& grid);

/// The scenario with the velocities that its bodies had half a step before the start.
Scenario half_a_step_earlier(const Scenario& scenario);

}  // namespace odeval::reference
