#pragma once
// The numbers a trace is judged by.
#include <algorithm>
#include <array>
#include <optional>

#include "odeval/quantity.hpp"

namespace odeval {

/// An angle error above this counts as lost, rad: a tenth of a radian is what a plot of the motion shows.
inline constexpr double divergence_rad = 0.1;

/// A body on a ground that moves no faster counts as resting, m/s: far above the rounding of a body at rest in single
/// precision, far below any motion that one would see.
inline constexpr double rest_m_s = 1e-3;

/// The values of all quantities of one trace up to one time, each in its row's unit. One is empty where the quantity
/// has no meaning for the run, or what it dates never happened.
class Metrics {
 public:
  double until_s = 0;                       // taken over the samples with t <= this
  std::optional<double> reference_lost_at;  // s, first sample where the reference's own uncertainty passes 0.1 rad:
                                            // from there on nothing is called lost

  /// By the row's id. To write: the functions that take quantities.
  std::optional<double>& operator[](quantity::Id id) { return values_[id]; }
  /// To read, in the row's unit.
  const std::optional<double>& operator[](quantity::Id id) const { return values_[id]; }

 private:
  std::array<std::optional<double>, quantity::count> values_;  // in the order of the table
};

/// What the reference may be off by in that quantity, in its unit; empty when it is no error against the reference, or
/// the reference has no bound on it.
inline std::optional<double> uncertainty_of(quantity::Id id, const Metrics& metrics) {
  const std::optional<quantity::Id> bound = quantities[id].uncertainty;
  return bound ? metrics[*bound] : std::nullopt;
}

/// Whether the run stands beside a reference in that scope: an error in it is known, and so is its bound. Tells a run
/// that has angles from one of bodies in space; links in Cartesian coordinates have errors of bodies, but no bounds.
inline bool compared(const Metrics& metrics, Scope scope) {
  return std::ranges::any_of(quantities, [&](const Quantity& row) {
    return row.scope == scope && metrics[row.id] && uncertainty_of(row.id, metrics);
  });
}

}  // namespace odeval
