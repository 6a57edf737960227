#pragma once
// The reference where nobody else knows the motion: what ODE itself tends to as its step goes to 0.
#include <string_view>

#include "odeval/origin.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"

namespace odeval::catalogue {

/// Bodies on joints that touch something, without controllers that look once a step: another step is another motion
/// with them.
bool can_self_converge(const Scenario& scenario);

/// Runs of dWorldStep at h, h/2, h/4 and h/8 on the scenario's rows, extrapolated as the audit of a program does it,
/// with the spread of the extrapolations until then as the uncertainty. ERP and CFM stay the spring and damper that
/// they are at h, or as the scenario asks for it their numbers. Throws UserError when a run blows up.
Reference self_converged(const Scenario& scenario, const SampleGrid& grid);

/// "self-converged" of such a reference, for tables of numbers that are measured against it; empty of others.
std::string_view mark_of(const Reference& reference);

/// Who knows the true motion: as reference::provider_for, and ODE itself where that knows nobody.
const ReferenceProvider& provider_of(const Scenario& scenario);

}  // namespace odeval::catalogue
