#pragma once
// CPU times of runs that take turns, so that a machine that slows down slows all of them.
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "output/timing.hpp"

namespace odeval::catalogue {

/// A method in the settings of an evaluator, to be timed.
struct TimedRun {
  const Evaluator* evaluator;
  const Method* method;
  long steps = 0;
  long evaluations = 0;         // of the equations of motion; 0 for an engine that does not say
  std::vector<double> seconds;  // CPU time of the stepping alone, one a round
  int batch = 1;                // runs that one time is the mean of
  std::string diverged{};       // why the run blew up, which ended its steps; empty: it did not
  std::string suspect{};        // what ODE itself said of it; empty: nothing

  double median_s() const;
  double mad_s() const;  // median absolute deviation
};

/// Seconds since some time or other, of which only differences count.
using Clock = double (*)();

/// Times every run once a round, after a round that warms up and does not count. Simulations are made before the clock
/// starts and record nothing. A run so short that the clock and cold caches would show is done several times over.
/// `begins(0)` is called before the warm-up, `begins(k)` before round k. A run whose rounds took `enough_s` in sum has
/// no more of them, and one that takes so long by itself has none: its warm-up counts.
void time_in_turns(std::span<TimedRun> runs, int rounds, const std::function<void(int round)>& begins = {},
                   Clock clock = cpu_seconds, double enough_s = HUGE_VAL);

/// What a table says of a run that was timed.
TimingRow timing_row(const TimedRun& timed);

}  // namespace odeval::catalogue
