#pragma once
// How much of an error is only a clock that is wrong.
#include <optional>

#include "odeval/trace.hpp"

namespace odeval {

struct TimeShift {
  double shift_s = 0;   // the trace runs ahead of the other by this much; negative: behind
  double rms_left = 0;  // rad or m, what the shift does not explain
  double max_left = 0;
  double sensitivity =
      0;  // rad/s or m/s, root mean square of the rates: an error e shifts the answer by up to e / this
};

/// The s that minimises the root mean square of q(t) - wanted q(t + s) over all angles, of bodies over all coordinates
/// of their centres, and over the samples with t <= until_s for which t - most_s and t + most_s lie within `wanted`.
///
/// Between its samples `wanted` is the cubic through values and rates (Hermite), so impacts are not for it; far from
/// its samples neither are coarse ones. |s| stays below most_s. Empty when no sample is left, nothing moves, or the
/// search does not settle.
std::optional<TimeShift> best_time_shift(const Trace& trace, const Trace& wanted, double until_s, double most_s);

}  // namespace odeval
