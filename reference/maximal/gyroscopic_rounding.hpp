#pragma once
// What rounding makes of ODE's gyroscopic torque in single precision, by the order of its operations.
#include "odeval/scenario.hpp"

namespace odeval::reference {

/// The same linearly implicit step (C. Lacoursiere, Stabilizing gyroscopic forces in rigid multibody simulations, 2006)
/// with w* = (I - h [L]x)^-1 L, L = I w, in other orders.
enum class GyroscopicForm {
  as_ode,         // torque (I (I - h [L]x)^-1 - 1) L / h, in the world's axes
  solved,         // w* first: torque (I w* - L) / h, in the world's axes
  in_body_frame,  // w* in the body's axes, where I is diagonal, and it is the new spin
};

/// ODE's step of a free body rebuilt in single precision.
///
/// Units    rad/s
/// Returns  the largest spin about the body's longest side in so many steps; infinite when it blew up
double long_axis_spin_in_single(const Body& body, double step_s, long steps, GyroscopicForm form);

}  // namespace odeval::reference
