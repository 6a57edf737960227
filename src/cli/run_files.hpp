#pragma once
// The files of a run, as `odeval run` and `odeval report` write them.
#include <filesystem>
#include <span>
#include <string>

#include "catalogue/summaries.hpp"

namespace odeval::cli {

/// DIR/SCENARIO, with the results of one set of settings, written by one process at a time.
class ResultFolder {
 public:
  /// Makes the folder and locks it for the life of this. Throws MachineError where another process writes there.
  explicit ResultFolder(std::filesystem::path folder);
  ~ResultFolder();  // a folder that nothing was written into goes
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  /// Writes METHOD.csv, the trace, and METHOD.json, the summary, which it returns.
  RunSummary write(const catalogue::Evaluation& run, catalogue::Evaluator& evaluator) const;

  /// Writes summary.csv: a row a method, and below the rows that are there of methods that ran before with the same
  /// settings.
  void write_summaries(const std::vector<RunSummary>& summaries) const;

 private:
  std::filesystem::path folder_;
  int lock_ = -1;
};

/// The first method with results of other settings or versions in the folder that these methods would leave there, and
/// what is other: "lagrange-rk4 with step = 0.01, not 0.001". Empty: none.
std::string results_of_another_run(const std::filesystem::path& folder, const Scenario& scenario,
                                   std::span<const catalogue::Method* const> methods);

}  // namespace odeval::cli
