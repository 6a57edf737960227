#pragma once
// The motion of bodies in space, read as a trace.
#include "odeval/motion.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Columns t, kinetic, potential, contacts and those of the bodies; the drift of angular momentum where nothing but
/// gravity acts, the overlap with the ground where there is one, the largest gap where there are joints, the works
/// where the motion has them, and those of `add_joint_columns`.
Trace body_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion);

/// Adds the names and the columns of joints to the trace of a mechanism that is told by names, from those of its
/// bodies; nothing of others.
void add_joint_columns(const Scenario& scenario, Trace& trace);

/// Fills `error_position` and `error_turn`, and `error_q` of joints that both have. The times of trace and reference
/// agree and the reference has the rows.
void compare_bodies(Trace& trace, const Reference& reference);

}  // namespace odeval
