#pragma once
// A trace beside the reference: errors, drift, gaps, divergence.
#include <optional>
#include <span>
#include <string_view>

#include "odeval/metrics.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// Fills `trace.error_q` with q - reference q, rad; of bodies `trace.error_position` and `trace.error_turn`.
/// Throws MachineError when the reference has fewer rows, other times or another number of angles: nothing is
/// resampled.
void compare(Trace& trace, const Reference& reference);

/// Every quantity of the table over the samples with t <= until_s. Errors are those of `compare`, so without it, or
/// without a reference, they stay empty.
///
/// A value that is not finite counts as infinite. So does every error and drift of a trace that ends before a
/// reference does: what a run did not survive it did not do well. Times of impacts are judged where the run's own are
/// given.
Metrics measure(const Trace& trace, const Reference* reference, double until_s,
                const std::vector<Impact>* impacts = nullptr);

/// What a tolerance is held against: the metric's value, where a run that was compared and never lost is lost at
/// infinity. Empty when the metric has no meaning for the run. Throws UserError for an unknown metric.
std::optional<double> judged_value(const Tolerance& tolerance, const Metrics& metrics);

/// What the reference may be off by in that metric; empty when it is no error against the reference. Throws as above.
std::optional<double> uncertainty_of(const Tolerance& tolerance, const Metrics& metrics);

/// Whether a run may lack the quantity though its scenario has it: what it dates never happened, or there is nothing to
/// fit.
bool may_be_missing(quantity::Id id);

enum class Judgement { kept, failed, undecided };

/// Whether the metrics, taken until the tolerance's time, keep it. An error is judged with the reference's uncertainty
/// on top: where a bound lies within it, the verdict is undecided. A metric without a value fails.
Judgement judge(const Tolerance& tolerance, const Metrics& metrics);

}  // namespace odeval
