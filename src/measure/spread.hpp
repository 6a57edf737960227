#pragma once
// Robust statistics of repeated timings.
#include <algorithm>
#include <cmath>
#include <vector>

namespace odeval {

/// Of at least one value; with an even number of them the mean of the middle two.
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// Median distance from the median.
inline double median_absolute_deviation(const std::vector<double>& values) {
  const double middle = median(values);
  std::vector<double> distances;
  for (const double value : values) distances.push_back(std::fabs(value - middle));
  return median(distances);
}

/// Half width of the median's 95 % interval: 1.96 times its standard error of 1.2533 sigma / sqrt(n) (for normal
/// noise), with sigma = 1.4826 times the median absolute deviation.
inline double median_half_width(const std::vector<double>& values) {
  return 1.96 * 1.2533 * 1.4826 * median_absolute_deviation(values) / std::sqrt(static_cast<double>(values.size()));
}

}  // namespace odeval
