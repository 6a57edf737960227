#pragma once
// From the positions and turns of bodies to the report's coordinates, energies and joint errors.
#include "odeval/method.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Shapes  `rows` holds a BodyState per link, then the number of contacts; the trace has a row for each
/// Angles  atan2 of the link's direction, on the branch of BodyState::angle
/// Energy  from all of the body's motion: out-of-plane movement and rotation about any axis count
/// error_q stays empty
Trace cartesian_trace(const Scenario& scenario, const SampleGrid& grid, const Rows& rows);

}  // namespace odeval
