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

/// The first row from which on no body moves, of so many; that many: one still moves in the last.
std::size_t first_at_rest(const Trace& trace, std::size_t rows) {
  std::size_t first = rows;
  while (first > 0 && fastest_body(trace, first - 1) <= rest_m_s) --first;
  return first;
}

double distance_between(const BodyColumns& body, std::size_t from, std::size_t to) {
  const auto& [x, y, z] = body.position;
  return size_of(std::hypot(x[to] - x[from], y[to] - y[from], z[to] - z[from]));
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

std::optional<double> rest_time(const Measurement& of) {
  if (of.trace.penetration.empty() || of.ended_early()) return std::nullopt;
  const std::size_t first = first_at_rest(of.trace, of.rows);
  return first == of.rows ? std::nullopt : std::optional(of.trace.t[first]);
}

std::optional<double> max_creep(const Measurement& of) {
  if (of.reference == nullptr || of.trace.penetration.empty() || of.reference->trace.bodies.empty())
    return std::nullopt;
  const std::size_t rests = first_at_rest(of.reference->trace, of.reference_rows);
  if (rests == of.reference_rows) return std::nullopt;
  double farthest = 0;
  for (const BodyColumns& body : of.trace.bodies) {
    for (std::size_t k = rests; k < of.rows; ++k) farthest = std::max(farthest, distance_between(body, rests, k));
  }
  return of.unless_early(farthest);
}

}  // namespace odeval::extract
