#pragma once
// Who knows the true motion of a scenario.
#include <functional>
#include <span>

#include "odeval/engine.hpp"
#include "odeval/reference.hpp"

namespace odeval::reference {

/// All of them, the better first: exact, then integrated.
std::span<const ReferenceProvider> providers();

/// The first that supports the scenario. Throws UserError when none does.
const ReferenceProvider& provider_for(const Scenario& scenario);

/// That provider's motion for rows at any times, integrated once for all of them. Empty where its motion hangs on the
/// step, or each grid is solved as fast.
std::function<Reference(const SampleGrid&)> follow(const Scenario& scenario);

/// Method mechanism-cvode; null in a build without Simbody, whose equations it integrates.
extern const MakeSimulation mechanism_cvode;

/// Bodies in space with the velocities that they had half a step before the start, by the mathematics of that
/// reference. Throws UserError when nobody knows them.
Scenario half_a_step_earlier(const Scenario& scenario);

}  // namespace odeval::reference
