// Times: how much of an error is only a clock that is wrong, and when impacts come.
#include "measure/measurement.hpp"

namespace odeval::extract {
namespace {

std::optional<double> left_by_shift(const Measurement& of) {
  return of.time_shift() ? std::optional(of.time_shift()->max_left) : std::nullopt;
}

/// How far in time the impact is from the nearest of the others, of the same link; from the end, if that is nearer.
double away_from(const Impact& impact, const std::vector<Impact>& others, double end_s) {
  double nearest = end_s - impact.t;
  for (const Impact& other : others) {
    if (other.link == impact.link) nearest = std::min(nearest, std::fabs(other.t - impact.t));
  }
  return nearest;
}

double farthest_away(const std::vector<Impact>& impacts, const std::vector<Impact>& others, double end_s) {
  double most = 0;
  for (const Impact& impact : impacts) {
    if (impact.t <= end_s) most = std::max(most, away_from(impact, others, end_s));
  }
  return most;
}

bool has_impact_errors(const Measurement& of) {
  return of.reference != nullptr && of.impacts != nullptr && !of.reference->impacts.empty() && of.reference_rows > 0;
}

}  // namespace

std::optional<double> max_impact_error(const Measurement& of) {
  if (!has_impact_errors(of)) return std::nullopt;
  const std::vector<Impact>& wanted = of.reference->impacts;
  const double end_s = of.reference->trace.t[of.reference_rows - 1];
  return of.unless_early(
      std::max(farthest_away(*of.impacts, wanted, end_s), farthest_away(wanted, *of.impacts, end_s)));
}

std::optional<double> impact_uncertainty(const Measurement& of) {
  if (!has_impact_errors(of)) return std::nullopt;
  const std::vector<Impact>& wanted = of.reference->impacts;
  if (of.reference->impact_uncertainty_s.size() != wanted.size()) return std::nullopt;  // a closed form
  const double end_s = of.reference->trace.t[of.reference_rows - 1];
  double most = 0;
  for (std::size_t i = 0; i < wanted.size() && wanted[i].t <= end_s; ++i) {
    most = std::max(most, size_of(of.reference->impact_uncertainty_s[i]));
  }
  return most;
}

std::optional<double> time_shift(const Measurement& of) {
  return of.time_shift() ? std::optional(of.time_shift()->shift_s) : std::nullopt;
}

std::optional<double> time_shift_uncertainty(const Measurement& of) {
  if (!of.time_shift()) return std::nullopt;
  const quantity::Id error = of.has_angle_errors() ? quantity::max_error_q : quantity::max_error_position;
  return uncertainty_of(error, of.taken).value_or(0) / of.time_shift()->sensitivity;
}

std::optional<double> error_q_after_shift(const Measurement& of) {
  return of.has_angle_errors() ? left_by_shift(of) : std::nullopt;
}

std::optional<double> error_position_after_shift(const Measurement& of) {
  return of.has_angle_errors() ? std::nullopt : left_by_shift(of);
}

}  // namespace odeval::extract
