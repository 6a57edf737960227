#pragma once
// The reference motion with a bound on its own error at every sample.
//
// The equations are integrated twice, at tight tolerances and at thirty times looser ones. The bound for the tight run
// is
//
//   U(t) = max over s <= t of (|tight - loose|(s) / I(s)) / 2 * I(t)  +  A(t) / 5
//
// I and A say how far errors as large as the tight tolerance, one in every step, would have carried the angles by then
// (error_spread.hpp): I if they owe nothing to each other, A if all of them conspire.
//
// - First term: a difference seen at any time s is carried on by I(t) / I(s), the motion's own growth, so the bound
//   does not dip where the two runs happen to cross. Half of it, since the tight run is the better one by far more.
// - Second term: rounding drifts one way for a long time, and drifts as much in both runs, so their difference does
//   not show it. A fifth of a tolerance a step is more than was ever seen.
// - Near a wall: an angle known to u leaves the speed at the wall unknown by sqrt(2 a u), so a graze may be a miss.
// - Once the bound has passed 1 rad it never falls again: from there on nothing is known.
//
// tests/oracle/reference_test.cpp holds it against lagrange-quad on random chains and against the closed form through
// impacts, tests/oracle/certified_test.cpp against the certified trajectories: at every sample.
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "reference/cvode_solver.hpp"

namespace odeval::reference {

/// For the run that only shows how large the error is.
inline constexpr Tolerances loose_tolerances{1e-13, 1e-14};

/// The scenario's own rtol and atol do not matter here: they are for the methods that are compared.
/// Contacts are 1 where the link rests on the wall; the joint force there is that of joint and wall together.
/// Throws UserError when the link starts inside the wall, MachineError when CVODE gives up.
Reference solve_reference(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
