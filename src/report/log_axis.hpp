#pragma once
// Where a logarithmic axis begins, so that a few values of rounding's size do not take most of it.
#include <cstddef>
#include <string>

#include "report/document.hpp"

namespace odeval::report {

struct LogAxis {
  double least = 0;        // a power of ten; 0: no series has a value above zero
  double greatest = 0;     // the same; above the least
  std::size_t zeros = 0;   // values that have no place: zero, or less
  std::size_t below = 0;   // values above zero that lie below the axis
  std::size_t values = 0;  // all of them that are finite
};

/// The y axis of a panel. Of each curve the lowest hundredth, and one of fewer values, may lie below it where they are
/// two decades below the rest: an error begins as rounding, and passes zero where it changes its sign. Series that are
/// drawn with points, and those of less than ten values, are on it whole.
LogAxis log_axis_of(const Panel& panel);

/// "not drawn: 1 value of 0, 2 below 1e-12, of 1001"; empty where all are.
std::string left_out_text(const LogAxis& axis);

}  // namespace odeval::report
