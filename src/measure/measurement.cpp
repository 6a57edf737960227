#include "measure/measurement.hpp"

namespace odeval {
namespace {

std::size_t rows_until(const Column& t, double until_s) {
  constexpr double rounding_s = 1e-9;  // far below the least step, far above the rounding of times
  return static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), until_s + rounding_s) - t.begin());
}

/// The first sample that the reference does not know to the angle of divergence: from there on no run can be
/// called lost.
std::optional<double> reference_lost_at(const Measurement& of) {
  if (!of.has_angle_errors()) return std::nullopt;
  const Column& known_to = of.reference->uncertainty_q;
  const auto lost = std::ranges::find_if(known_to, [](double u) { return !(u <= divergence_rad); });
  const auto row = static_cast<std::size_t>(lost - known_to.begin());
  return row < of.rows ? std::optional(of.trace.t[row]) : std::nullopt;
}

/// Before anything is touched: an impact bends what a shift would move.
double first_impact(const Trace& trace, const Reference& reference) {
  double first = reference.impacts.empty() ? std::numeric_limits<double>::infinity() : reference.impacts.front().t;
  for (std::size_t k = 0; k < trace.contacts.size() && trace.t[k] < first; ++k) {
    if (trace.contacts[k] > 0) first = trace.t[k];
  }
  return first;
}

/// Whether the run is known to stay near the reference to its last row.
bool keeps_up(const Measurement& of) {
  const std::optional<double>& error =
      of.taken[of.has_angle_errors() ? quantity::max_error_q : quantity::max_error_position];
  return of.reference_rows == of.rows && error && std::isfinite(*error) && !of.taken[quantity::divergence_time] &&
         !of.taken.reference_lost_at;
}

std::optional<TimeShift> fitted_shift(const Measurement& of) {
  constexpr double rows_searched = 2;
  if (of.reference == nullptr || of.rows < 2 || !keeps_up(of)) return std::nullopt;
  const Column& t = of.trace.t;
  const double spacing_s = t[1] - t[0];
  const double most_s = rows_searched * spacing_s;
  const double before_impact_s = first_impact(of.trace, *of.reference) - (rows_searched + 1) * spacing_s;
  const auto shift = best_time_shift(of.trace, of.reference->trace, std::min(t[of.rows - 1], before_impact_s), most_s);
  return shift && std::fabs(shift->shift_s) < most_s ? shift : std::nullopt;
}

}  // namespace

Measurement::Measurement(const Trace& measured, const Reference* beside, double until_s,
                         const std::vector<Impact>* of_run)
    : trace(measured),
      reference(beside),
      impacts(of_run),
      rows(rows_until(trace.t, until_s)),
      reference_rows(reference == nullptr ? 0 : rows_until(reference->trace.t, until_s)) {
  taken.until_s = until_s;
  taken.reference_lost_at = reference_lost_at(*this);
}

const std::optional<TimeShift>& Measurement::time_shift() const {
  if (!time_shift_) time_shift_ = fitted_shift(*this);
  return *time_shift_;
}

}  // namespace odeval
