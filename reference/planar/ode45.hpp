#pragma once
// Dormand-Prince 5(4) with variable steps on the Lagrangian equations, as MATLAB's ode45 takes them.
//
// The formulas and the dense output are Boost.odeint's runge_kutta_dopri5. Its controllers scale the error by the
// step's start alone and aim at other factors, so the control of the step is the published one of ode45: a step is
// accepted when every component's error estimate is within max(atol, rtol max(|y|, |y_new|)); the first step and the
// factors for the next (0.8, at most 5, at least 0.1, halved after a second failure, no growth right after one) are
// ode45's as well, and so are the longest step, a tenth of the duration, and the stretch of the last one.
//
// What differs from MATLAB: rows and touches come from odeint's dense output, another interpolant of the same order
// (4); a step in which the link turns is searched for a touch in both directions, where MATLAB's events look at the
// ends of the step only. A touch ends the step and the method starts afresh from it, as the report's D.5 does.
#include <memory>

#include "odeval/engine.hpp"

namespace odeval::reference {

inline constexpr double ode45_rtol = 1e-3;  // MATLAB's defaults, overridden by Scenario::rtol and Scenario::atol
inline constexpr double ode45_atol = 1e-6;

/// In joint coordinates. The last step ends at the grid's last time exactly; Scenario::step_s is not used.
std::unique_ptr<Simulation> make_ode45(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
