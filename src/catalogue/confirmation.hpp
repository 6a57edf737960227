#pragma once
// The reference of mechanisms, held to a second formulation that shares no code with the first: the accurate step in
// Cartesian coordinates beside generalized ones.
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"

namespace odeval::catalogue {

/// Steps of one body that the second formulation may take, all its runs together: a few seconds.
inline constexpr double most_steps_to_confirm = 2e6;

/// Holds a reference of bodies to the accurate step of order 8: runs on the scenario's own rows with 1, 2, 4 and 8
/// steps in each of the scenario's, extrapolated two by two until they agree with the reference or have taken all the
/// steps they may. In each row the uncertainty is then no less than the difference. The origin says how it went, and
/// why not where the accurate step can not do the mechanism.
void confirm(Reference& reference, const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::catalogue
