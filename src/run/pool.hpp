#pragma once
// Numbered jobs in a pool of worker processes, which crashes, hanging jobs and killed workers do not stop.
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>

#include "run/worker.hpp"

namespace odeval::run {

struct Job {
  std::uint32_t number;
  std::uint32_t group = 0;  // of jobs that share what was prepared
};

/// What came of a job.
struct Result {
  enum class Kind {
    done,
    failed,   // threw
    refused,  // threw a UserError: bad input
    crashed,  // took its process down
    late,     // took longer than it may
  };
  Kind kind = Kind::done;
  std::string text;             // what the job returned; else why there is nothing
  bool of_preparation = false;  // what the job shares with others is to blame
};

using TakeResult = std::function<void(long job, const Result& result)>;

struct PoolOptions {
  int processes = 1;
  double timeout_s = std::numeric_limits<double>::infinity();  // of one job, or of what a group shares

  /// So much work, by the mean of its jobs so far, lies ready with a worker, which then need not wait until this
  /// process gets its turn. What lies there is kept from the other workers: only for jobs that are short and alike.
  double at_hand_s = 0;

  std::function<void()> passed;  // called after results have come, and at least twice a second
};

/// Does the jobs of the plan, in which those of a group follow each other, in its order: so they are begun; they end as
/// they end. `take` gets the result of each in this process; what it throws ends the pool.
///
/// A job that takes its worker down in its first task there is `crashed`. Where the worker had done others before, or
/// was ended from outside, the job is tried again in a new one; ended from outside again and again, it is `crashed` as
/// well. Time in which all of the program was stopped is no part of what a job took.
///
/// Workers are forked as they are needed, and know what this process knew then. They ignore SIGINT, and what they print
/// on standard output goes nowhere. A process that a job starts itself is not ended with its worker.
///
/// Returns 0, or the number of the signal (SIGINT, SIGTERM, SIGHUP, but for those that the program ignores) that ended
/// it early. In any case, errors included, no worker is left. Throws MachineError where the machine has no processes or
/// memory.
int run_pool(const Work& work, std::span<const Job> plan, const TakeResult& take, const PoolOptions& options);

}  // namespace odeval::run
