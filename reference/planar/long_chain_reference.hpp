#pragma once
// The reference motion of a chain of any number of links, with a bound on its own error at every sample.
//
// The ellipsoids of reference_solution.hpp cost n^3 a step, so the bound is a simpler one: CVODE runs at the two
// tolerances, and
//
//   U(t) = 10 max over s <= t and all angles of |tight - loose|(s), + 1e-15 rad
//
// The runs take other steps, so they round differently; truncation is 33 times as large in the loose run as in the
// tight one. What neither shows is a drift that both have in common, which the 10 is for: chain_test.cpp holds the
// bound against quad precision (3 to 5 links) and a double pendulum's own reference.
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "reference/cvode_solver.hpp"

namespace odeval::reference {

/// `origin` is left to the caller. Throws MachineError when CVODE gives up.
Reference solve_long_chain(const Scenario& scenario, const SampleGrid& grid, Tolerances tight, Tolerances loose);

}  // namespace odeval::reference
