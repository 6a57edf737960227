#pragma once
// What runs cost. The only files whose bytes change from run to run.
#include <string>
#include <utility>
#include <vector>

namespace odeval {

/// One scenario in one method, repeated.
struct TimingRow {
  std::string scenario;
  std::string method;
  double step_s = 0;
  long steps = 0;
  double simulated_s = 0;
  int repeats = 0;
  double median_s = 0;
  double mad_s = 0;  // median absolute deviation
  double min_s = 0;
  double ns_per_step = 0;      // of the median
  double realtime_factor = 0;  // simulated over median
};

/// For a terminal.
std::string timing_table(const std::vector<TimingRow>& rows);

std::string timing_csv(const std::vector<TimingRow>& rows);

/// An object with "environment" (machine, compiler, flags, library versions) and "rows".
std::string timing_json(const std::vector<TimingRow>& rows,
                        const std::vector<std::pair<std::string, std::string>>& environment);

}  // namespace odeval
