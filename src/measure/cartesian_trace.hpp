#pragma once
// From the positions and turns of bodies to the report's coordinates, energies and joint errors.
#include "odeval/method.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Shapes  `rows` holds a BodyState per link, then the number of contacts; the trace has a row for each
/// Angles  atan2 of the link's direction, carried on from row to row with the measured rate, so that a link may turn
///         by up to half a turn more or less between rows than its mean rate says; row 0 is nearest to the scenario's
///         q0
/// Energy  from all of the body's motion: out-of-plane movement and rotation about any axis count
/// error_q stays empty
Trace cartesian_trace(const Scenario& scenario, const SampleGrid& grid, const Rows& rows);

}  // namespace odeval
