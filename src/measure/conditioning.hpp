#pragma once
// How well conditioned the equations are that a formulation solves in each pose of a trace.
#include "odeval/engine.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Fills `trace.condition` with the 1-norm condition number |A|_1 |A^-1|_1 of that matrix at each row's pose, exact to
/// rounding, and `trace.manipulability` with the report's measure (D.4): least over largest eigenvalue of J^T J, where
/// J is the 6 x n geometric Jacobian of the end of the chain. With SystemMatrix::none the condition stays empty.
///
/// Norm    the 1-norm needs one exact inverse a row where the 2-norm needs eigenvalues, several times as dear; for a
///         symmetric matrix of N rows it lies between cond_2 and N cond_2
/// Rows    of a hinge as ODE makes them: 3 that hold the anchors together, 2 that hold the axes parallel, with the
///         bodies' rotations as recorded and the anchors at the links' ends; rows of contacts are left out
/// Shapes  the trace has q and, but for the mass matrix, bodies
/// Needs the scenario's planar view.
void add_conditioning(Trace& trace, const Scenario& scenario, SystemMatrix matrix);

}  // namespace odeval
