#include "cli/run_files.hpp"

#include "output/file.hpp"
#include "output/trace_csv.hpp"

namespace odeval::cli {

RunSummary write_run(const catalogue::Evaluation& run, catalogue::Evaluator& evaluator,
                     const std::filesystem::path& folder) {
  RunSummary summary = catalogue::summarise(run, evaluator);
  const std::string name(run.method->name);
  write_whole(folder / (name + ".csv"), trace_csv(run.trace));
  write_whole(folder / (name + ".json"), summary_json(summary));
  return summary;
}

void write_summaries(const std::vector<RunSummary>& summaries, const std::filesystem::path& folder) {
  write_whole(folder / "summary.csv", summary_csv(summaries));
}

}  // namespace odeval::cli
