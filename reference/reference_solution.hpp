#pragma once
// The reference motion with a bound on its own error at every sample.
//
// The equations are integrated twice, at tight and at a hundred times looser tolerances. The bound for the tight run is
//
//   U(t) = max(floor, max over s <= t of |tight - loose|(s) / spread(s) / gain) * spread(t)
//
// where spread (error_spread.hpp) is the standard deviation that errors of one tolerance in every step would have grown
// to. So a difference seen at any time s is carried on by spread(t) / spread(s), the motion's own growth: where the two
// runs happen to cross, the bound does not dip. `gain` allows for the tight run being the better one, by less than the
// ratio of the tolerances; `floor` holds where both runs are at the level of rounding. Near a wall the bound also holds
// that a graze may be a miss: an angle known to u leaves the speed at the wall unknown by sqrt(2 a u).
// Once the bound passes 1 rad it never falls again: from there on nothing is known.
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
