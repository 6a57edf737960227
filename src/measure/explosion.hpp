#pragma once
// Runs that blew up while their numbers stayed finite.
#include <cstddef>
#include <optional>

#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// The first row in which bodies move as nothing in the mechanism could make them: together they have a hundred times
/// the kinetic energy (ten times the speed) that the true motion ever has and that a free fall for as long as the run
/// could add, and within one step a body goes farther than its longest side or turns by more than a radian.
///
/// What an inaccurate step adds is of the size of the motion. What an unstable one adds grows by a factor a step, so
/// that how large the hundred is makes a difference of a few steps. No row where the reference has no bodies.
std::optional<std::size_t> explosion(const Scenario& scenario, const SampleGrid& grid, const Trace& trace,
                                     const Reference& reference);

}  // namespace odeval
