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
  std::vector<double> distances;
  for (const double value : values) distances.push_back(std::fabs(value - median(values)));
  return median(distances);
}

}  // namespace odeval
