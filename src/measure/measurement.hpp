#pragma once
// What a quantity is taken from, and the function that takes it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "measure/time_shift.hpp"
#include "odeval/metrics.hpp"
#include "odeval/reference.hpp"
#include "odeval/trace.hpp"

namespace odeval {

/// A trace up to one time, beside the reference that `compare` compared it with.
class Measurement {
 public:
  Measurement(const Trace& trace, const Reference* reference, double until_s, const std::vector<Impact>* impacts);

  const Trace& trace;
  const Reference* const reference;          // null: none
  const std::vector<Impact>* const impacts;  // of the run that made the trace; null: nobody knows
  const std::size_t rows;                    // of the trace, with t <= until_s
  const std::size_t reference_rows;          // of the reference until then; 0 without one
  Metrics taken;  // by the table's rows above the one at work, and when the reference is lost

  bool has_angle_errors() const { return reference != nullptr && !trace.error_q.empty(); }
  bool has_body_errors() const { return reference != nullptr && !trace.error_position.empty(); }

  /// Whether the trace ends before the reference does. What a run did not survive it did not do well.
  bool ended_early() const { return reference_rows > rows; }

  /// The value, infinite for a trace that ended early; empty stays empty.
  std::optional<double> unless_early(std::optional<double> value) const {
    return value && ended_early() ? std::numeric_limits<double>::infinity() : value;
  }

  /// Of the whole clock; fitted when it is first asked for. Empty when the run is lost, ends early or does not move.
  const std::optional<TimeShift>& time_shift() const;

 private:
  mutable std::optional<std::optional<TimeShift>> time_shift_;
};

/// Of the quantity that has its name: its value, empty where it has no meaning for the run. A value that is not finite
/// counts as infinite.
namespace extract {
#define ODEVAL_DECLARATION(name, ...) std::optional<double> name(const Measurement&);
ODEVAL_QUANTITIES(ODEVAL_DECLARATION)
#undef ODEVAL_DECLARATION
}  // namespace extract

/// The size of an error; not-a-number is infinite.
inline double size_of(double error) {
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : std::fabs(error);
}

/// The largest size in the first rows of a column.
inline double largest(const Column& column, std::size_t rows) {
  double max = 0;
  for (std::size_t k = 0; k < rows; ++k) max = std::max(max, size_of(column[k]));
  return max;
}

/// The same of a column that a trace may lack.
inline std::optional<double> largest_of(const Column& column, std::size_t rows) {
  return column.empty() ? std::nullopt : std::optional(largest(column, rows));
}

/// Largest and root mean square size of values.
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

}  // namespace odeval
