#pragma once
// A motion in joint coordinates, read as a trace.
#include <vector>

#include "odeval/engine.hpp"
#include "odeval/trace.hpp"

namespace odeval::reference {

/// Columns t, q, qd, kinetic and potential of K samples; no gap, nothing out of plane, no contacts.
///
/// Shapes  n joint coordinates; K = motion.size() <= grid.rows, sample k at grid.time(k)
Trace generalized_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion);

/// Joint accelerations at a state of n joints, rad/s².
std::vector<double> joint_accelerations(const Scenario& scenario, const std::vector<double>& q,
                                        const std::vector<double>& qd);

}  // namespace odeval::reference
