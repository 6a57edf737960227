#include "measure/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "measure/body_trace.hpp"
#include "measure/measurement.hpp"
#include "odeval/error.hpp"

namespace odeval {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A time may come from another step, as another product.
bool same_time(double a, double b) { return std::fabs(a - b) <= 4 * std::numeric_limits<double>::epsilon() * a; }

#define ODEVAL_FUNCTION(name, ...) extract::name,
constexpr std::optional<double> (*extractors[])(const Measurement&) = {ODEVAL_QUANTITIES(ODEVAL_FUNCTION)};
#undef ODEVAL_FUNCTION

/// Throws UserError for an unknown metric.
const Quantity& limited_by(const Tolerance& tolerance) {
  const Quantity* const row = quantity_named(tolerance.metric);
  if (row == nullptr) throw UserError("no metric named '" + tolerance.metric + "'");
  return *row;
}

}  // namespace

void compare(Trace& trace, const Reference& reference) {
  const Trace& wanted = reference.trace;
  if (wanted.q.size() != trace.q.size()) {
    throw MachineError("the reference has " + std::to_string(wanted.q.size()) + " angles, the trace " +
                       std::to_string(trace.q.size()));
  }
  if (wanted.rows() < trace.rows() || !std::equal(trace.t.begin(), trace.t.end(), wanted.t.begin(), same_time)) {
    throw MachineError("the reference does not stand at the times of the trace");
  }
  if (!reference.uncertainty_position.empty()) compare_bodies(trace, reference);
  trace.error_q.assign(trace.q.size(), Column(trace.rows()));
  for (std::size_t i = 0; i < trace.q.size(); ++i) {
    for (std::size_t k = 0; k < trace.rows(); ++k) trace.error_q[i][k] = trace.q[i][k] - wanted.q[i][k];
  }
}

Metrics measure(const Trace& trace, const Reference* reference, double until_s, const std::vector<Impact>* impacts) {
  Measurement measurement(trace, reference, until_s, impacts);
  for (const Quantity& row : quantities) measurement.taken[row.id] = extractors[row.id](measurement);
  return measurement.taken;
}

std::optional<double> judged_value(const Tolerance& tolerance, const Metrics& metrics) {
  const Quantity& row = limited_by(tolerance);
  const std::optional<double>& value = metrics[row.id];
  const bool never_lost = row.id == quantity::divergence_time && !value && metrics[quantity::max_error_q];
  return never_lost ? infinity : value;
}

std::optional<double> uncertainty_of(const Tolerance& tolerance, const Metrics& metrics) {
  return uncertainty_of(limited_by(tolerance).id, metrics);
}

bool may_be_missing(quantity::Id id) {
  using namespace quantity;
  switch (id) {
    case divergence_time:
    case rest_time:
    case time_shift:
    case time_shift_uncertainty:
    case error_q_after_shift:
    case error_position_after_shift:
      return true;
    default:
      return false;
  }
}

Judgement judge(const Tolerance& tolerance, const Metrics& metrics) {
  const std::optional<double> value = judged_value(tolerance, metrics);
  const bool may_be_infinite = limited_by(tolerance).id == quantity::divergence_time;
  if (!value || (!std::isfinite(*value) && !may_be_infinite)) return Judgement::failed;
  const double uncertainty = uncertainty_of(tolerance, metrics).value_or(0);
  const double at_most = tolerance.at_most.value_or(infinity);
  const double at_least = tolerance.at_least.value_or(-infinity);
  if (*value - uncertainty > at_most || *value + uncertainty < at_least) return Judgement::failed;
  return *value + uncertainty <= at_most && *value - uncertainty >= at_least ? Judgement::kept : Judgement::undecided;
}

}  // namespace odeval
