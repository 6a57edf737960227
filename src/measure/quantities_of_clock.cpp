// How much of an error is only a clock that is wrong.
#include "measure/measurement.hpp"

namespace odeval::extract {
namespace {

std::optional<double> left_by_shift(const Measurement& of) {
  return of.time_shift() ? std::optional(of.time_shift()->max_left) : std::nullopt;
}

}  // namespace

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
