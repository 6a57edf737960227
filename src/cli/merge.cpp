// odeval merge: the shards of one sweep as one table.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/settings.hpp"
#include "cli/sweep_answer.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;
using sweep::Journal;

struct Options {
  std::vector<std::string> folders;
  std::string out;
  AnswerOptions answer;
};

struct Part {
  std::string folder;
  std::unique_ptr<Journal> journal;
};

fs::path journal_in(const std::string& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(folder) / "sweep", error)) {
    if (entry.path().extension() == ".journal") found.push_back(entry.path());
  }
  if (error)
    throw UserError(folder + "/sweep: cannot be read: " + error.message() + "; give the --out folder of a shard");
  if (found.size() != 1) {
    throw UserError(fmt::format("{}/sweep: has {} journals; a shard of one sweep has one", folder, found.size()));
  }
  return found.front();
}

std::vector<Part> open_parts(const Options& options) {
  std::vector<Part> parts;
  for (const std::string& folder : options.folders) {
    std::error_code ignored;
    if (fs::equivalent(folder, options.out, ignored)) {
      throw UserError("--out " + options.out + ": is one of the shards; give a folder of its own");
    }
    for (const Part& part : parts) {
      if (fs::equivalent(folder, part.folder, ignored)) throw UserError(folder + ": is named twice");
    }
    parts.push_back({folder, std::make_unique<Journal>(journal_in(folder))});
    if (const long damaged = parts.back().journal->damaged(); damaged > 0) {
      std::cerr << fmt::format("odeval: {}: {} damaged line{} left out\n", folder, damaged, damaged == 1 ? "" : "s");
    }
    const std::string other = parts.back().journal->head().difference(parts.front().journal->head());
    if (!other.empty()) {
      throw UserError(fmt::format("{}: is of another sweep than {} ({} differ)", folder, parts.front().folder, other));
    }
  }
  return parts;
}

/// Which part has each run.
std::vector<const Part*> sources_of(const std::vector<Part>& parts) {
  const Journal& first = *parts.front().journal;
  std::vector<const Part*> sources(static_cast<std::size_t>(first.runs()));
  long gaps = 0;
  std::string missing;
  for (long run = 0; run < first.runs(); ++run) {
    const Part*& source = sources[static_cast<std::size_t>(run)];
    for (const Part& part : parts) {
      if (!part.journal->has(run)) continue;
      if (source == nullptr) {
        source = &part;
      } else if (!source->journal->row(run).same_as(part.journal->row(run))) {
        throw UserError(fmt::format("run {}: {} and {} contradict each other", run, source->folder, part.folder));
      }
    }
    constexpr long most_named = 5;
    if (source == nullptr && gaps++ < most_named) missing += (missing.empty() ? "" : ", ") + std::to_string(run);
  }
  if (gaps > 0) {
    std::string shards;
    for (const Part& part : parts) shards += ' ' + part.journal->head().shard.text();
    throw UserError(
        fmt::format("{} of {} runs are in no shard (run {}{}); there are shards{}, and a shard that was stopped "
                    "goes on with its own command",
                    gaps, first.runs(), missing, gaps > 5 ? ", ..." : "", shards));
  }
  return sources;
}

int merge(const Options& options) {
  const std::vector<Part> parts = open_parts(options);
  const std::vector<const Part*> sources = sources_of(parts);
  sweep::Head head = parts.front().journal->head();
  head.shard = {};
  const std::filesystem::path place = journal_file(options.out, head.scenario);
  make_folder(place.parent_path());
  Journal whole(place, head);
  for (long run = 0; run < whole.runs(); ++run) {
    const Part& source = *sources[static_cast<std::size_t>(run)];
    const sweep::Row row = source.journal->row(run);
    if (!whole.has(run)) {
      whole.append(run, row);
    } else if (!whole.row(run).same_as(row)) {
      throw UserError(fmt::format("--out {}: has run {} from before, and {} contradicts it; give another folder",
                                  options.out, run, source.folder));
    }
  }
  whole.sync();
  return answer(whole, options.out, options.answer);
}

}  // namespace

Action attach_merge(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("DIR", options->folders, "--out folders of 'odeval sweep --shard I/N', all of them").required();
  flags.add_option("--out", options->out, "folder of the whole sweep").type_name("DIR").required().check(folder_name());
  add_answer_options(flags, options->answer);
  return [options] { return merge(*options); };
}

}  // namespace odeval::cli
