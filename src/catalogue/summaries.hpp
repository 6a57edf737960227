#pragma once
// An evaluation with all that a summary says around it.
#include "catalogue/evaluation.hpp"
#include "output/summary.hpp"

namespace odeval::catalogue {

RunSummary summarise(const Evaluation& run, Evaluator& evaluator);

}  // namespace odeval::catalogue
