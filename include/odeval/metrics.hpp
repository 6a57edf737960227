#pragma once
// The numbers a trace is judged by.
#include <optional>
#include <span>
#include <string_view>

namespace odeval {

/// An angle error above this counts as lost.
inline constexpr double divergence_rad = 0.1;

/// A body on a ground that moves no faster counts as resting.
inline constexpr double rest_m_s = 1e-3;

/// All metrics of one trace up to one time. An optional is empty where the metric has no meaning.
struct Metrics {
  double until_s = 0;
  std::optional<double> max_error_q;
  std::optional<double> rms_error_q;
  std::optional<double> reference_uncertainty;
  std::optional<double> divergence_time;  // s, first sample with an error above 0.1 rad
  std::optional<double>
      reference_lost_at;        // s, first sample where the uncertainty passes 0.1 rad; ends the search above
  double max_energy_drift = 0;  // J, largest |energy - energy at t = 0|
  double rms_energy_drift = 0;
  double final_energy_drift = 0;             // signed
  std::optional<double> max_gap;             // m
  std::optional<double> max_out_of_plane;    // m
  std::optional<double> max_reaction_error;  // N, samples without contact
  std::optional<double> max_error_position;  // m
  std::optional<double> max_error_turn;      // rad
  std::optional<double> position_uncertainty;
  std::optional<double> turn_uncertainty;
  std::optional<double> max_angular_momentum_drift;  // N m s
  std::optional<double> max_long_axis_spin;          // rad/s
  std::optional<double> spin_uncertainty;
  std::optional<double> max_penetration;  // m
  std::optional<double> rest_time;        // s, from when on no body on a ground moves faster than rest_m_s
  std::optional<double> time_shift;       // s, by which the trace runs ahead; empty once it is lost
  std::optional<double> time_shift_uncertainty;
  std::optional<double> error_q_after_shift;         // rad
  std::optional<double> error_position_after_shift;  // m
};

struct MetricRow {
  std::string_view name;
  std::string_view unit;
  std::string_view meaning;
  std::optional<double> (*value)(const Metrics&);  // empty: no meaning here, or never happened
  std::string_view uncertainty =
      {};  // the metric that bounds how far the reference itself is off; empty: no error against it
};

// clang-format off
inline constexpr MetricRow metric_rows[] = {
  {"max_error_q",           "rad", "largest angle error",                              [](const Metrics& m) { return m.max_error_q; }, "reference_uncertainty"},
  {"rms_error_q",           "rad", "root mean square of the angle errors",             [](const Metrics& m) { return m.rms_error_q; }, "reference_uncertainty"},
  {"reference_uncertainty", "rad", "bound on the reference's own angle error",         [](const Metrics& m) { return m.reference_uncertainty; }},
  {"divergence_time",       "s",   "first sample with an angle error above 0.1 rad",   [](const Metrics& m) { return m.divergence_time; }},
  {"max_energy_drift",      "J",   "largest difference from the energy at t = 0",      [](const Metrics& m) { return std::optional(m.max_energy_drift); }},
  {"rms_energy_drift",      "J",   "root mean square of that difference",              [](const Metrics& m) { return std::optional(m.rms_energy_drift); }},
  {"final_energy_drift",    "J",   "that difference at the end, with its sign",        [](const Metrics& m) { return std::optional(m.final_energy_drift); }},
  {"max_gap",               "m",   "largest distance between the anchors of a joint",  [](const Metrics& m) { return m.max_gap; }},
  {"max_out_of_plane",      "m",   "largest distance of a body from the plane",        [](const Metrics& m) { return m.max_out_of_plane; }},
  {"max_reaction_error",    "N",   "largest joint force error at samples without contact", [](const Metrics& m) { return m.max_reaction_error; }},
  {"max_error_position",    "m",   "largest distance of a body from the reference",    [](const Metrics& m) { return m.max_error_position; }, "position_uncertainty"},
  {"max_error_turn",        "rad", "largest angle between a body's attitude and the reference's", [](const Metrics& m) { return m.max_error_turn; }, "turn_uncertainty"},
  {"position_uncertainty",  "m",   "bound on the reference's own distance",            [](const Metrics& m) { return m.position_uncertainty; }},
  {"turn_uncertainty",      "rad", "bound on the reference's own angle of attitude",   [](const Metrics& m) { return m.turn_uncertainty; }},
  {"max_angular_momentum_drift", "N m s", "largest change of the angular momentum about the centres", [](const Metrics& m) { return m.max_angular_momentum_drift; }},
  {"max_long_axis_spin",    "rad/s", "largest spin about a body's longest side that the reference does not have", [](const Metrics& m) { return m.max_long_axis_spin; }, "spin_uncertainty"},
  {"spin_uncertainty",      "rad/s", "bound on the error of the reference's own spin", [](const Metrics& m) { return m.spin_uncertainty; }},
  {"max_penetration",       "m",   "deepest overlap of a body with the ground",        [](const Metrics& m) { return m.max_penetration; }},
  {"rest_time",             "s",   "from when on no body on a ground moves faster than 1 mm/s", [](const Metrics& m) { return m.rest_time; }},
  {"time_shift",            "s",   "how far the trace's clock runs ahead, for the best fit until an impact", [](const Metrics& m) { return m.time_shift; }, "time_shift_uncertainty"},
  {"time_shift_uncertainty", "s",  "bound on what the reference's own error does to it", [](const Metrics& m) { return m.time_shift_uncertainty; }},
  {"error_q_after_shift",   "rad", "largest angle error that this shift leaves",       [](const Metrics& m) { return m.error_q_after_shift; }, "reference_uncertainty"},
  {"error_position_after_shift", "m", "largest error of a coordinate of a body that this shift leaves", [](const Metrics& m) { return m.error_position_after_shift; }, "position_uncertainty"},
};
// clang-format on

/// The one table of metrics; tolerances, help and summaries read it.
inline std::span<const MetricRow> metric_table() { return metric_rows; }

}  // namespace odeval
