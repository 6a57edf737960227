#pragma once
// The numbers a trace is judged by.
#include <optional>

namespace odeval {

/// All metrics of one trace up to one time. An optional is empty where the metric has no meaning.
struct Metrics {
  double until_s = 0;
  std::optional<double> max_error_q;
  std::optional<double> rms_error_q;
  std::optional<double> reference_uncertainty;
  std::optional<double> divergence_time;  // s, first sample with an error above 0.1 rad
  double max_energy_drift = 0;            // J, largest |energy - energy at t = 0|
  double rms_energy_drift = 0;
  double final_energy_drift = 0;             // signed
  double max_gap = 0;                        // m
  double max_out_of_plane = 0;               // m
  std::optional<double> max_reaction_error;  // N, samples without contact
};

}  // namespace odeval
