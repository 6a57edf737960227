#pragma once
// From the positions and turns of bodies to the report's coordinates, energies and joint errors.
#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Needs the scenario's planar view.
///
/// Angles  atan2 of the link's direction, on the branch of BodyState::angle
/// Energy  from all of the body's motion: out-of-plane movement and rotation about any axis count
/// error_q stays empty
Trace cartesian_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion);

}  // namespace odeval
