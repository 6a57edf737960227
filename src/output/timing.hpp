#pragma once
// What runs cost. The only files whose bytes change from run to run.
#include <optional>
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

/// A row of the report's Table 5.2 beside what stands for it today; or, without a number, what the report did not have.
struct Table52Row {
  std::optional<int> number;
  std::string equations;
  std::string solver;
  std::optional<int> steps_2010;
  std::optional<double> seconds_2010;
  std::string method;
  std::optional<long> steps;  // absent: the method was not timed
  std::optional<double> median_s;
  std::optional<double> mad_s;
};

/// A method at the cheapest setting that keeps an error.
struct EqualErrorRow {
  std::string scenario;
  std::string method;
  std::string knob;  // "h", "rtol" or none
  std::optional<double> setting;
  double error = 0;        // rad; where nothing keeps the error, the least seen
  double uncertainty = 0;  // rad, of the reference
  std::string why_not;     // empty: reached
  long steps = 0;
  long evaluations = 0;  // 0: an engine that does not say
  int repeats = 0;       // 0: not timed, since nothing was reached
  double median_s = 0;
  double mad_s = 0;
};

/// For a terminal.
std::string timing_table(const std::vector<TimingRow>& rows);
std::string table_5_2_text(const std::vector<Table52Row>& rows);
std::string equal_error_table(const std::vector<EqualErrorRow>& rows);

std::string timing_csv(const std::vector<TimingRow>& rows);

std::string equal_error_csv(const std::vector<EqualErrorRow>& rows, double max_error, double until_s);

/// An object with "environment" (machine, compiler, flags, library versions) and "rows"; and "table_5_2" where there is
/// one.
std::string timing_json(const std::vector<TimingRow>& rows, const std::vector<Table52Row>& table_5_2,
                        const std::vector<std::pair<std::string, std::string>>& environment);

/// An object with "environment", "max_error", "until" and "rows".
std::string equal_error_json(const std::vector<EqualErrorRow>& rows, double max_error, double until_s,
                             const std::vector<std::pair<std::string, std::string>>& environment);

}  // namespace odeval
