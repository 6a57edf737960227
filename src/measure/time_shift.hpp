#pragma once
// How much of an error is only a clock that is wrong.
#include "odeval/trace.hpp"

namespace odeval {

struct TimeShift {
  double shift_s = 0;   // the trace runs ahead of the other by this much; negative: behind
  double rms_left = 0;  // rad, what the shift does not explain
  double max_left = 0;  // rad
  double sensitivity =
      0;  // rad/s, root mean square of the rates: an error of e rad shifts the answer by up to e / this
};

/// The s that minimises the root mean square of q(t) - wanted q(t + s) over all angles and over the samples with
/// t <= until_s for which t - most_s and t + most_s lie within `wanted`.
///
/// Between its samples `wanted` is the cubic through angles and rates (Hermite), so neither impacts nor coarse samples
/// are for it. |s| stays below most_s. Throws MachineError when no sample is left or the search does not settle.
TimeShift best_time_shift(const Trace& trace, const Trace& wanted, double until_s, double most_s);

}  // namespace odeval
