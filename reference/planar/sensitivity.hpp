#pragma once
// How a motion depends on its start: forward sensitivities by SUNDIALS CVODES.
//
// The state-transition matrix P(t) = d(q, qd)(t) / d(q, qd)(0) obeys P' = J P with the exact Jacobian J of the
// equations of motion. A small error d of the start has become P(t) d at time t.
#include <vector>

#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"
#include "reference/cvode_solver.hpp"

namespace odeval::reference {

struct Sensitivity {
  Column t;                                     // s
  std::vector<Column> q;                        // n columns, rad: the motion that P belongs to
  std::vector<std::vector<double>> transition;  // P, 2n x 2n by rows, one per time; s is the unit of time
  Column growth;    // largest singular value of P: the most that an error of the start, in rad and rad/s, has grown by
  Column exponent;  // 1/s, ln(growth) / t, the finite-time Lyapunov exponent; 0 at t = 0
};

/// Tighter, CVODES refuses for the sensitivities, which are as large as the growth.
inline constexpr Tolerances sensitivity_tolerances{1e-13, 1e-14};

/// At the grid's times. Throws UserError for a scenario with a wall, MachineError when CVODES gives up.
Sensitivity solve_sensitivity(const Scenario& scenario, const SampleGrid& grid,
                              Tolerances tolerances = sensitivity_tolerances);

}  // namespace odeval::reference
