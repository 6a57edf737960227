#pragma once
// Tables for a terminal: three digits, aligned.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "output/summary.hpp"

namespace odeval {

/// Rows of cells under a header, padded to the widest cell of each column.
class TextTable {
 public:
  /// `align` has a letter per column: 'l' or 'r'.
  TextTable(std::string_view align, std::vector<std::string> header);

  void add(std::vector<std::string> cells);
  std::string text() const;

 private:
  std::string align_;
  std::vector<std::vector<std::string>> rows_;
};

/// A number to three significant digits; "-" when there is none.
std::string three_digits(const std::optional<double>& number);

/// "0.0089 ± 6e-12"; without the uncertainty only the value.
std::string with_uncertainty(const std::optional<double>& value, const std::optional<double>& uncertainty);

/// One row a run: errors until 1 s, 3 s and the end beside the reference's uncertainty, divergence time, energy drift,
/// gap, impacts, cost, status; where bodies were compared distance and turn instead of angles, and the error of the
/// joint's force or, without one, angular momentum. `ns_per_step` has one number per run, or is empty when nothing was
/// timed.
std::string summary_table(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step);

/// One row an impact, the first `most` of each run; `reference` are the impacts to compare with, number by number.
std::string impacts_table(const std::vector<RunSummary>& runs, const std::vector<Impact>& reference,
                          std::size_t most = 3);

}  // namespace odeval
