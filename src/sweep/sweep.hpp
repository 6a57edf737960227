#pragma once
// Runs what a journal lacks, in workers.
#include <cstdint>
#include <functional>
#include <span>

#include "sweep/worker.hpp"

namespace odeval::sweep {

struct SweepOptions {
  int jobs = 1;
  double timeout_s = 3600;                     // of one run, or of what a group shares
  std::function<void(const Journal&)> passed;  // called after rows have come, and at least twice a second
};

/// Runs those of the journal's shard that it lacks, and writes each row as it comes. `groups` has the group of every
/// run of the grid; groups are begun in their order, and in each the runs in theirs.
///
/// A run that takes its worker down in its first task there, or takes too long, is a row `crashed` or `timeout`. Where
/// the worker had done others before, or was ended from outside, the run is tried again in a new one.
///
/// Returns 0, or the number of the signal (SIGINT, SIGTERM, SIGHUP) that ended the sweep early. In any case, errors
/// included, no worker is left and the journal is whole.
int run_sweep(const Work& work, std::span<const std::uint32_t> groups, Journal& journal, const SweepOptions& options);

}  // namespace odeval::sweep
