#pragma once
// Recorded rows of bodies in space, read as a trace.
#include "odeval/method.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Columns t, kinetic, potential, contacts and those of the bodies; the drift of angular momentum where nothing but
/// gravity acts, the overlap with the ground where there is one, the gap where there is a joint.
///
/// Shapes  `rows` holds a BodyState per body, then the number of contacts; the trace has a row for each
Trace body_trace(const Scenario& scenario, const SampleGrid& grid, const Rows& rows);

/// Fills `error_position` and `error_turn`. The times of trace and reference agree and the reference has the rows.
void compare_bodies(Trace& trace, const Reference& reference);

}  // namespace odeval
