// Quantities of bodies in space, by themselves and beside the reference's.
#include "measure/measurement.hpp"

namespace odeval::extract {
namespace {

double largest_of_each(const std::vector<Column>& errors, std::size_t rows) {
  double most = 0;
  for (const Column& of_body : errors) most = std::max(most, largest(of_body, rows));
  return most;
}

double fastest_body(const Trace& trace, std::size_t row) {
  double fastest = 0;
  for (const BodyColumns& body : trace.bodies) {
    const auto& [x, y, z] = body.velocity;
    fastest = std::max(fastest, size_of(std::hypot(x[row], y[row], z[row])));
  }
  return fastest;
}

}  // namespace

std::optional<double> max_error_position(const Measurement& of) {
  if (!of.has_body_errors()) return std::nullopt;
  return of.unless_early(largest_of_each(of.trace.error_position, of.rows));
}

std::optional<double> max_error_turn(const Measurement& of) {
  if (!of.has_body_errors()) return std::nullopt;
  return of.unless_early(largest_of_each(of.trace.error_turn, of.rows));
}

std::optional<double> position_uncertainty(const Measurement& of) {
  if (!of.has_body_errors()) return std::nullopt;
  return largest(of.reference->uncertainty_position, of.reference_rows);
}

std::optional<double> turn_uncertainty(const Measurement& of) {
  if (!of.has_body_errors()) return std::nullopt;
  return largest(of.reference->uncertainty_turn, of.reference_rows);
}

std::optional<double> max_long_axis_spin(const Measurement& of) {
  if (of.reference == nullptr || of.trace.long_axis_spin.empty()) return std::nullopt;
  const std::vector<Column>& wanted = of.reference->trace.long_axis_spin;
  double most = 0;
  for (std::size_t i = 0; i < of.trace.long_axis_spin.size(); ++i) {
    for (std::size_t k = 0; k < of.rows; ++k) {
      most = std::max(most, size_of(of.trace.long_axis_spin[i][k] - (wanted.empty() ? 0 : wanted[i][k])));
    }
  }
  return of.unless_early(most);
}

std::optional<double> spin_uncertainty(const Measurement& of) {
  if (of.reference == nullptr || of.trace.long_axis_spin.empty()) return std::nullopt;
  return largest_of(of.reference->uncertainty_spin, of.reference_rows);
}

std::optional<double> max_out_of_plane(const Measurement& of) { return largest_of(of.trace.out_of_plane, of.rows); }

std::optional<double> max_penetration(const Measurement& of) {
  return of.unless_early(largest_of(of.trace.penetration, of.rows));
}

// From the row after the last one in which a body moves.
std::optional<double> rest_time(const Measurement& of) {
  if (of.trace.penetration.empty() || of.ended_early()) return std::nullopt;
  std::size_t first = of.rows;
  while (first > 0 && fastest_body(of.trace, first - 1) <= rest_m_s) --first;
  return first == of.rows ? std::nullopt : std::optional(of.trace.t[first]);
}

}  // namespace odeval::extract
