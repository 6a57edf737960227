#include "measure/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "measure/body_trace.hpp"
#include "measure/time_shift.hpp"
#include "odeval/error.hpp"

namespace odeval {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding_s = 1e-9;  // far below the least step, far above the rounding of times

// A time may come from another step, as another product.
bool same_time(double a, double b) { return std::fabs(a - b) <= 4 * std::numeric_limits<double>::epsilon() * a; }

double size_of(double error) { return std::isnan(error) ? infinity : std::fabs(error); }

// Rows with t <= until.
std::size_t rows_until(const Column& t, double until_s) {
  return static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), until_s + rounding_s) - t.begin());
}

/// Largest and root mean square of values; not-a-number counts as infinite.
class Spread {
 public:
  void add(double value) {
    const double size = size_of(value);
    max_ = std::max(max_, size);
    squares_ += size * size;
    ++count_;
  }
  double max() const { return max_; }
  double rms() const { return count_ == 0 ? 0 : std::sqrt(squares_ / static_cast<double>(count_)); }

 private:
  double max_ = 0;
  double squares_ = 0;
  std::size_t count_ = 0;
};

double largest(const Column& column, std::size_t rows) {
  double max = 0;
  for (std::size_t k = 0; k < rows; ++k) max = std::max(max, size_of(column[k]));
  return max;
}

/// The same of a column that a trace may lack.
std::optional<double> largest_of(const Column& column, std::size_t rows) {
  return column.empty() ? std::nullopt : std::optional(largest(column, rows));
}

void measure_body_errors(const Trace& trace, const Reference& reference, std::size_t rows, Metrics& metrics) {
  const auto largest_error = [rows](const std::vector<Column>& errors) {
    double error = 0;
    for (const Column& body : errors) error = std::max(error, largest(body, rows));
    return error;
  };
  metrics.max_error_position = largest_error(trace.error_position);
  metrics.max_error_turn = largest_error(trace.error_turn);
  const std::size_t known = rows_until(reference.trace.t, metrics.until_s);
  metrics.position_uncertainty = largest(reference.uncertainty_position, known);
  metrics.turn_uncertainty = largest(reference.uncertainty_turn, known);
}

// From the row after the last one in which a body moves; nothing when that is the last row of all.
std::optional<double> rest_time(const Trace& trace, std::size_t rows) {
  if (trace.penetration.empty()) return std::nullopt;
  std::size_t first = rows;
  for (; first > 0; --first) {
    double fastest = 0;
    for (const BodyColumns& body : trace.bodies) {
      const auto& [x, y, z] = body.velocity;
      fastest = std::max(fastest, size_of(std::hypot(x[first - 1], y[first - 1], z[first - 1])));
    }
    if (fastest > rest_m_s) break;
  }
  return first == rows ? std::nullopt : std::optional(trace.t[first]);
}

void measure_errors(const Trace& trace, const Reference& reference, std::size_t rows, Metrics& metrics) {
  // From the first sample that the reference does not know to the angle of divergence, nobody can tell who is lost.
  const Column& unknown = reference.uncertainty_q;
  const auto reference_lost =
      std::find_if(unknown.begin(), unknown.end(), [](double u) { return !(u <= divergence_rad); });
  const std::size_t known = std::min(rows, static_cast<std::size_t>(reference_lost - unknown.begin()));
  if (known < rows) metrics.reference_lost_at = trace.t[known];

  Spread spread;
  std::size_t first_lost = known;
  for (const Column& error : trace.error_q) {
    for (std::size_t k = 0; k < rows; ++k) {
      spread.add(error[k]);
      if (size_of(error[k]) > divergence_rad) first_lost = std::min(first_lost, k);
    }
  }
  metrics.max_error_q = spread.max();
  metrics.rms_error_q = spread.rms();
  metrics.reference_uncertainty = largest(reference.uncertainty_q, rows_until(reference.trace.t, metrics.until_s));
  if (first_lost < known) metrics.divergence_time = trace.t[first_lost];
}

/// Before anything is touched: an impact bends what a shift would move.
double first_impact(const Trace& trace, const Reference& reference) {
  double first = reference.impacts.empty() ? infinity : reference.impacts.front().t;
  for (std::size_t k = 0; k < trace.contacts.size() && trace.t[k] < first; ++k) {
    if (trace.contacts[k] > 0) first = trace.t[k];
  }
  return first;
}

// Of a trace that is lost, or ends early, it says nothing, nor where nothing moves.
void measure_time_shift(const Trace& trace, const Reference& reference, std::size_t rows, Metrics& metrics) {
  constexpr double rows_searched = 2;
  const bool angles = !trace.error_q.empty();
  const std::optional<double>& error = angles ? metrics.max_error_q : metrics.max_error_position;
  if (rows < 2 || !error || !std::isfinite(*error) || metrics.divergence_time || metrics.reference_lost_at) return;
  const double spacing_s = trace.t[1] - trace.t[0];
  const double until_s = std::min(trace.t[rows - 1], first_impact(trace, reference) - (rows_searched + 1) * spacing_s);
  const double most_s = rows_searched * spacing_s;
  const auto shift = best_time_shift(trace, reference.trace, until_s, most_s);
  if (!shift || std::fabs(shift->shift_s) >= most_s) return;
  const double uncertainty = (angles ? metrics.reference_uncertainty : metrics.position_uncertainty).value_or(0);
  metrics.time_shift = shift->shift_s;
  metrics.time_shift_uncertainty = uncertainty / shift->sensitivity;
  (angles ? metrics.error_q_after_shift : metrics.error_position_after_shift) = shift->max_left;
}

void measure_energy(const Trace& trace, std::size_t rows, Metrics& metrics) {
  if (rows == 0) return;
  const double start = trace.kinetic[0] + trace.potential[0];
  const auto drift = [&trace, start](std::size_t k) { return trace.kinetic[k] + trace.potential[k] - start; };
  Spread spread;
  for (std::size_t k = 0; k < rows; ++k) spread.add(drift(k));
  metrics.max_energy_drift = spread.max();
  metrics.rms_energy_drift = spread.rms();
  const double last = drift(rows - 1);
  metrics.final_energy_drift = std::isnan(last) ? infinity : last;
}

void measure_reactions(const Trace& trace, const Reference& reference, std::size_t rows, Metrics& metrics) {
  if (trace.bodies.empty() || reference.joint_force.size() != trace.bodies.size()) return;
  double max_squared = 0;
  for (std::size_t i = 0; i < trace.bodies.size(); ++i) {
    const std::array<Column, 3>& force = trace.bodies[i].joint_force;
    const std::array<Column, 3>& wanted = reference.joint_force[i];
    for (std::size_t k = 1; k < rows; ++k) {
      if (trace.contacts[k] > 0) continue;
      double squared = 0;
      for (std::size_t d = 0; d < 3; ++d) squared += (force[d][k] - wanted[d][k]) * (force[d][k] - wanted[d][k]);
      max_squared = std::max(max_squared, size_of(squared));
    }
  }
  metrics.max_reaction_error = std::sqrt(max_squared);
}

// Links swing in a plane, so that their reference has no spin about their length; free bodies may have one.
void measure_long_axis_spin(const Trace& trace, const Reference& reference, std::size_t rows, Metrics& metrics) {
  if (trace.long_axis_spin.empty()) return;
  const std::vector<Column>& wanted = reference.trace.long_axis_spin;
  double most = 0;
  for (std::size_t i = 0; i < trace.long_axis_spin.size(); ++i) {
    for (std::size_t k = 0; k < rows; ++k) {
      most = std::max(most, size_of(trace.long_axis_spin[i][k] - (wanted.empty() ? 0 : wanted[i][k])));
    }
  }
  metrics.max_long_axis_spin = most;
  if (!reference.uncertainty_spin.empty()) {
    metrics.spin_uncertainty = largest(reference.uncertainty_spin, rows_until(reference.trace.t, metrics.until_s));
  }
}

// The trace ends where the reference still has rows: it is lost at the first row it lacks.
void count_as_lost(const Trace& trace, const Reference& reference, Metrics& metrics) {
  if (!trace.error_q.empty()) {
    metrics.max_error_q = metrics.rms_error_q = infinity;
    if (!metrics.divergence_time && !metrics.reference_lost_at)
      metrics.divergence_time = reference.trace.t[trace.rows()];
  }
  metrics.max_energy_drift = metrics.rms_energy_drift = metrics.final_energy_drift = infinity;
  for (std::optional<double>* metric :
       {&metrics.max_reaction_error, &metrics.max_error_position, &metrics.max_error_turn,
        &metrics.max_angular_momentum_drift, &metrics.max_long_axis_spin, &metrics.max_penetration}) {
    if (*metric) *metric = infinity;
  }
  metrics.rest_time.reset();
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

Metrics measure(const Trace& trace, const Reference* reference, double until_s) {
  Metrics metrics;
  metrics.until_s = until_s;
  const std::size_t rows = rows_until(trace.t, until_s);
  measure_energy(trace, rows, metrics);
  metrics.max_gap = largest_of(trace.gap, rows);
  metrics.max_out_of_plane = largest_of(trace.out_of_plane, rows);
  metrics.max_angular_momentum_drift = largest_of(trace.angular_momentum_drift, rows);
  metrics.max_penetration = largest_of(trace.penetration, rows);
  metrics.rest_time = rest_time(trace, rows);
  if (reference != nullptr) {
    if (!trace.error_q.empty()) measure_errors(trace, *reference, rows, metrics);
    if (!trace.error_position.empty()) measure_body_errors(trace, *reference, rows, metrics);
    measure_reactions(trace, *reference, rows, metrics);
    measure_long_axis_spin(trace, *reference, rows, metrics);
    if (rows_until(reference->trace.t, until_s) == rows) measure_time_shift(trace, *reference, rows, metrics);
    if (rows_until(reference->trace.t, until_s) > rows) count_as_lost(trace, *reference, metrics);
  }
  return metrics;
}

const MetricRow* metric_named(std::string_view name) {
  const auto table = metric_table();
  const auto row = std::find_if(table.begin(), table.end(), [name](const auto& r) { return r.name == name; });
  return row == table.end() ? nullptr : &*row;
}

std::optional<double> judged_value(const Tolerance& tolerance, const Metrics& metrics) {
  const MetricRow* row = metric_named(tolerance.metric);
  if (row == nullptr) throw UserError("no metric named '" + tolerance.metric + "'");
  const std::optional<double> value = row->value(metrics);
  const bool never_lost = row->name == "divergence_time" && !value && metrics.max_error_q;
  return never_lost ? infinity : value;
}

std::optional<double> uncertainty_of(const Tolerance& tolerance, const Metrics& metrics) {
  const MetricRow* row = metric_named(tolerance.metric);
  return row == nullptr || row->uncertainty.empty() ? std::nullopt : metric_named(row->uncertainty)->value(metrics);
}

Judgement judge(const Tolerance& tolerance, const Metrics& metrics) {
  const std::optional<double> value = judged_value(tolerance, metrics);
  if (!value || (!std::isfinite(*value) && tolerance.metric != "divergence_time")) return Judgement::failed;
  const double uncertainty = uncertainty_of(tolerance, metrics).value_or(0);
  const double at_most = tolerance.at_most.value_or(infinity);
  const double at_least = tolerance.at_least.value_or(-infinity);
  if (*value - uncertainty > at_most || *value + uncertainty < at_least) return Judgement::failed;
  return *value + uncertainty <= at_most && *value - uncertainty >= at_least ? Judgement::kept : Judgement::undecided;
}

}  // namespace odeval
