#pragma once
// Rows of generalized coordinates, read as a trace.
#include <vector>

#include "odeval/method.hpp"
#include "odeval/trace.hpp"

namespace odeval::reference {

/// Columns t, q, qd, kinetic and potential of K rows of (q1..qn, qd1..qdn); no gap, nothing out of plane, no contacts.
///
/// Shapes  rows.width() = 2n; K = rows.count() <= grid.rows, row k at grid.time(k)
Trace generalized_trace(const Scenario& scenario, const SampleGrid& grid, const Rows& rows);

/// Joint accelerations at a state of n joints, rad/s².
std::vector<double> joint_accelerations(const Scenario& scenario, const std::vector<double>& q,
                                        const std::vector<double>& qd);

}  // namespace odeval::reference
