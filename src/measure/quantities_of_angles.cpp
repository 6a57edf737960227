// Quantities of joint coordinates beside the reference's.
#include "measure/measurement.hpp"

namespace odeval::extract {
namespace {

Spread angle_errors(const Measurement& of) {
  Spread spread;
  for (const Column& error : of.trace.error_q) {
    for (std::size_t k = 0; k < of.rows; ++k) spread.add(error[k]);
  }
  return spread;
}

/// The first row in which any joint is lost; none: the number of rows.
std::size_t first_lost_row(const Measurement& of) {
  std::size_t first = of.rows;
  for (const Column& error : of.trace.error_q) {
    const auto lost = std::find_if(error.begin(), error.begin() + static_cast<std::ptrdiff_t>(first),
                                   [](double e) { return size_of(e) > divergence_rad; });
    first = static_cast<std::size_t>(lost - error.begin());
  }
  return first;
}

}  // namespace

std::optional<double> max_error_q(const Measurement& of) {
  if (!of.has_angle_errors()) return std::nullopt;
  return of.unless_early(angle_errors(of).max());
}

std::optional<double> rms_error_q(const Measurement& of) {
  if (!of.has_angle_errors()) return std::nullopt;
  return of.unless_early(angle_errors(of).rms());
}

std::optional<double> reference_uncertainty(const Measurement& of) {
  if (!of.has_angle_errors()) return std::nullopt;
  return largest(of.reference->uncertainty_q, of.reference_rows);
}

// A trace that ended early is lost in the first row it lacks.
std::optional<double> divergence_time(const Measurement& of) {
  if (!of.has_angle_errors()) return std::nullopt;
  const std::optional<double>& unknown_from = of.taken.reference_lost_at;
  const std::size_t row = first_lost_row(of);
  if (row < of.rows && !(unknown_from && of.trace.t[row] >= *unknown_from)) return of.trace.t[row];
  if (!of.ended_early() || unknown_from) return std::nullopt;
  return of.reference->trace.t[of.rows];
}

}  // namespace odeval::extract
