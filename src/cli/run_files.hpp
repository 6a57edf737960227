#pragma once
// The files of a run, as `odeval run` and `odeval report` write them.
#include <filesystem>

#include "catalogue/summaries.hpp"

namespace odeval::cli {

/// Writes FOLDER/METHOD.csv, the trace, and FOLDER/METHOD.json, the summary, which it returns.
RunSummary write_run(const catalogue::Evaluation& run, catalogue::Evaluator& evaluator,
                     const std::filesystem::path& folder);

/// Writes FOLDER/summary.csv.
void write_summaries(const std::vector<RunSummary>& summaries, const std::filesystem::path& folder);

}  // namespace odeval::cli
