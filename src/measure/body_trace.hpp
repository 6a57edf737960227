#pragma once
// The motion of bodies in space, read as a trace.
#include "odeval/motion.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Columns t, kinetic, potential, contacts and those of the bodies; the drift of angular momentum where nothing but
/// gravity acts, the overlap with the ground where there is one, the largest gap where there are joints.
Trace body_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion);

/// Fills `error_position` and `error_turn`. The times of trace and reference agree and the reference has the rows.
void compare_bodies(Trace& trace, const Reference& reference);

}  // namespace odeval
