#pragma once
// The reference motion with a bound on its own error at every sample.
//
// CVODE runs twice, at a tight tolerance and at one 33 times looser. With the tight run two ellipsoids of errors are
// carried on (error_spread.hpp), to which every step adds one tolerance and one rounding of each component. How far
// they reach in the angle or rate i is
//
//   I_i(t)   if the errors of the steps owe nothing to each other,
//   A_i(t)   if they all may point the same way.
//
// The bound is the largest, over the angles i, of
//
//   U_i(t) = f(t) I_i(t) + A_i(t) / 5
//   f(t)   = the largest of 1 and |tight - loose|_i(s) / (2 I_i(s)) over s <= t and all angles and rates i
//
// - First term: what the runs differ by at a time s is carried on by the motion's own growth, so the bound does not dip
//   where they happen to cross. Half of it, since the tight run is the better one by far more than that.
// - Second term: rounding drifts one way for a long time, and as much in both runs, so their difference does not show
//   it.
// - Inside a step: the larger of the bounds at its two ends, and what one step may add.
// - Near a wall: an angle known to u leaves the speed at the wall unknown by sqrt(2 a u), so a graze may be a touch and
//   a touch a graze.
// - Once the bound has passed 1 rad it never falls again: from there on nothing is known.
//
// A chain of more than two links has a simpler bound (long_chain_reference.hpp).
//
// The half and the fifth are experience, at the tolerances below. certified_test.cpp and reference_test.cpp check that
// the bound covers; check_terms and check_grazes in the latter fail without either term, or without the uncertainty
// about a graze.
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
/// The same at tolerances of choice: for tests, which see the bound at work
/// where rounding does not hide it.
Reference solve_reference(const Scenario& scenario, const SampleGrid& grid, Tolerances tight, Tolerances loose);

/// Reference::origin of two runs of CVODE.
std::string origin_of(Tolerances tight, Tolerances loose);

}  // namespace odeval::reference
