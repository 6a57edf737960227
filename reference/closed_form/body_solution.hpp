#pragma once
// A true motion of bodies at the times of a trace.
#include "odeval/engine.hpp"
#include "odeval/reference.hpp"
#include "reference/closed_form/body_motion.hpp"

namespace odeval::reference {

/// Throws UserError as `make_body_motion`.
Reference solve_body_reference(const Scenario& scenario, const SampleGrid& grid);

// How a reference of bodies is filled: a row and the uncertainty of each time, and once all rows are there, the forces
// of joints.
void append_row(Reference& reference, const Mechanism& mechanism, double t, const Sample& sample);
void append_uncertainty(Reference& reference, const BodyUncertainty& uncertainty);
void tell_joint_forces(Reference& reference, const Mechanism& mechanism);

/// The same as a method: samples of bodies and joints.
std::unique_ptr<Simulation> make_body_analytic(const Scenario& scenario, const SampleGrid& grid);

/// The scenario with the velocities that its bodies had half a step before the start.
Scenario bodies_half_a_step_earlier(const Scenario& scenario);

}  // namespace odeval::reference
