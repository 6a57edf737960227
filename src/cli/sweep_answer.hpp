#pragma once
// How a sweep ends, whether it ran here or was merged: its table, and the least error that a cost buys.
#include <filesystem>
#include <string>

#include "run/journal.hpp"

namespace odeval::cli {

class Flags;

struct AnswerOptions {
  std::string error;  // metric of the front; empty: the first error against the reference that there is
  bool quiet = false;
};

void add_answer_options(Flags& flags, AnswerOptions& options);

/// DIR/sweep/SCENARIO.journal
std::filesystem::path journal_file(const std::filesystem::path& folder, const std::string& scenario);

/// Writes, in the journal's folder, SCENARIO.csv (the table: same sweep, same bytes), SCENARIO-timing.csv,
/// SCENARIO-front.csv, -front-ode.csv and -front.png, prints the fronts of each group of runs that can be compared, and
/// returns the exit status: 1 when a run has no results.
int answer(const sweep::Journal& journal, const std::filesystem::path& folder, const AnswerOptions& options);

}  // namespace odeval::cli
