#pragma once
// Runs what a journal lacks, in a pool of workers.
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "run/journal.hpp"

namespace odeval::sweep {

/// What is swept. The functions are called in workers only.
struct Work {
  /// What the runs of a group share, as bytes: made once, by one of the workers.
  std::function<std::string(long group)> prepare;

  /// One run. A MachineError makes a row `crashed`, a UserError ends the sweep.
  std::function<Row(long run, long group, std::string_view prepared)> run;
};

struct SweepOptions {
  int jobs = 1;
  double timeout_s = 3600;                     // of one run, or of what a group shares
  std::function<void(const Journal&)> passed;  // called after rows have come, and at least twice a second
};

/// Runs those of the journal's shard that it lacks, and writes each row as it comes. `groups` has the group of every
/// run of the grid; groups are begun in their order, and in each the runs in theirs.
///
/// A run that takes its worker down, or takes too long, is a row `crashed` or `timeout`, as `run_pool` tells.
///
/// Returns 0, or the number of the signal that ended the sweep early. In any case, errors included, no worker is left
/// and the journal is whole.
int run_sweep(const Work& work, std::span<const std::uint32_t> groups, Journal& journal, const SweepOptions& options);

}  // namespace odeval::sweep
