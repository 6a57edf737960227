#include "cli/run_files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <sstream>

#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/trace_csv.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;

fs::path summary_of(const fs::path& folder, std::string_view method) {
  return folder / (std::string(method) + ".json");
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

/// The rows of a summary.csv of the same columns that are of other methods whose results stand in the folder in the
/// same settings.
std::string kept_rows(const fs::path& folder, const std::vector<RunSummary>& summaries) {
  const fs::path file = folder / "summary.csv";
  if (summaries.empty() || !is_there(file)) return "";
  std::istringstream before(read_whole(file));
  std::string line;
  std::getline(before, line);
  if (line + '\n' != summary_csv({})) return "";
  std::string kept;
  while (std::getline(before, line)) {
    const std::size_t begin = line.find(',') + 1;
    const std::string name = line.substr(begin, line.find(',', begin) - begin);
    if (std::ranges::find(summaries, name, &RunSummary::method) != summaries.end()) continue;
    const auto all = catalogue::methods();
    const auto method = std::ranges::find(all, name, &catalogue::Method::name);
    if (method == all.end() || !is_there(summary_of(folder, name))) continue;
    const RunSummary same = catalogue::settings_of(*method, summaries.front().scenario);
    if (unlike(read_whole(summary_of(folder, name)), same).empty()) kept += line + '\n';
  }
  return kept;
}

}  // namespace

ResultFolder::ResultFolder(fs::path folder) : folder_(std::move(folder)) {
  make_folder(folder_);
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A file system without locks has none to respect.
  if (lock_ < 0 || ::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(lock_);
  throw MachineError(folder_.string() + ": another odeval is at work in it; wait for it, or give another --out");
}

ResultFolder::~ResultFolder() {
  std::error_code ignored;
  fs::remove(folder_, ignored);  // only when it is empty
  if (lock_ >= 0) ::close(lock_);
}

RunSummary ResultFolder::write(const catalogue::Evaluation& run, catalogue::Evaluator& evaluator) const {
  RunSummary summary = catalogue::summarise(run, evaluator);
  WholeFile trace(folder_ / (std::string(run.method->name) + ".csv"));
  put_trace_csv(run.trace, [&](std::string_view line) { trace.write(line); });
  trace.finish();
  write_whole(summary_of(folder_, run.method->name), summary_json(summary));
  return summary;
}

void ResultFolder::write_summaries(const std::vector<RunSummary>& summaries) const {
  write_whole(folder_ / "summary.csv", summary_csv(summaries) + kept_rows(folder_, summaries));
}

std::string results_of_another_run(const fs::path& folder, const Scenario& scenario,
                                   std::span<const catalogue::Method* const> methods) {
  for (const catalogue::Method& method : catalogue::methods()) {
    const fs::path file = summary_of(folder, method.name);
    if (std::ranges::find(methods, &method) != methods.end() || !is_there(file)) continue;
    const std::string other = unlike(read_whole(file), catalogue::settings_of(method, scenario));
    if (!other.empty()) return std::string(method.name) + " with " + other;
  }
  return "";
}

}  // namespace odeval::cli
