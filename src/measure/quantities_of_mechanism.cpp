// Quantities of the whole mechanism: its energy and momentum, and what its joints do.
#include "measure/measurement.hpp"

namespace odeval::extract {
namespace {

double energy_drift(const Trace& trace, std::size_t row) {
  return trace.kinetic[row] + trace.potential[row] - (trace.kinetic[0] + trace.potential[0]);
}

Spread energy_drifts(const Measurement& of) {
  Spread spread;
  for (std::size_t k = 0; k < of.rows; ++k) spread.add(energy_drift(of.trace, k));
  return spread;
}

double squared_difference(const std::array<Column, 3>& a, const std::array<Column, 3>& b, std::size_t row) {
  double squared = 0;
  for (std::size_t d = 0; d < 3; ++d) squared += (a[d][row] - b[d][row]) * (a[d][row] - b[d][row]);
  return squared;
}

}  // namespace

std::optional<double> max_energy_drift(const Measurement& of) { return of.unless_early(energy_drifts(of).max()); }

std::optional<double> rms_energy_drift(const Measurement& of) { return of.unless_early(energy_drifts(of).rms()); }

std::optional<double> final_energy_drift(const Measurement& of) {
  const double last = of.rows == 0 ? 0 : energy_drift(of.trace, of.rows - 1);
  return of.unless_early(std::isnan(last) ? size_of(last) : last);
}

std::optional<double> max_angular_momentum_drift(const Measurement& of) {
  return of.unless_early(largest_of(of.trace.angular_momentum_drift, of.rows));
}

std::optional<double> max_unaccounted_energy(const Measurement& of) {
  return of.unless_early(largest_of(of.trace.unaccounted, of.rows));
}

std::optional<double> max_gap(const Measurement& of) { return largest_of(of.trace.gap, of.rows); }

std::optional<double> max_reaction_error(const Measurement& of) {
  const std::vector<BodyColumns>& bodies = of.trace.bodies;
  if (of.reference == nullptr || bodies.empty() || of.reference->joint_force.size() != bodies.size()) return {};
  double most = 0;  // squared
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t k = 1; k < of.rows; ++k) {
      if (of.trace.contacts[k] > 0) continue;
      most = std::max(most, size_of(squared_difference(bodies[i].joint_force, of.reference->joint_force[i], k)));
    }
  }
  return of.unless_early(std::sqrt(most));
}

}  // namespace odeval::extract
