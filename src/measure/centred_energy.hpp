#pragma once
// The energy of a motion whose stored velocities belong to the middles of the steps.
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Kinetic energy with the mean of the velocities of rows k and k + 1, J: one value fewer than the trace has rows.
///
/// ODE moves a body from x_k to x_{k+1} with the velocity v_{k+1}, which it stores in row k + 1. So v_{k+1} belongs to
/// t_k + h/2, and the velocity at t_k, where x_k is, is (v_k + v_{k+1}) / 2 to second order. The motion stays as it is.
///
/// Needs a trace in Cartesian coordinates with a row every step. Counts rotation about the axis of the plane only.
Column centred_kinetic(const Scenario& scenario, const Trace& trace);

/// Potential energy plus that, minus the energy of the trace at t = 0, J.
Column centred_energy_drift(const Scenario& scenario, const Trace& trace);

}  // namespace odeval
