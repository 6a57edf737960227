#pragma once
// An evaluation with all that a summary says around it.
#include "catalogue/evaluation.hpp"
#include "output/summary.hpp"

namespace odeval::catalogue {

/// What a run is told to do: its settings in effect, and the versions of all that does it.
RunSummary settings_of(const Method& method, const Scenario& scenario);

/// The same with what it did.
RunSummary summarise(const Evaluation& run, Evaluator& evaluator);

}  // namespace odeval::catalogue
