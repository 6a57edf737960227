#include "catalogue/timing.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "measure/spread.hpp"
#include "output/summary.hpp"

namespace odeval::catalogue {
namespace {

constexpr double long_enough_s = 5e-4;
constexpr double most_in_a_batch = 100;

double mean_seconds(TimedRun& run, Clock clock) {
  std::vector<std::unique_ptr<Simulation>> simulations(static_cast<std::size_t>(run.batch));
  for (auto& simulation : simulations) simulation = run.evaluator->make(*run.method);
  Outcome outcome;
  const double start = clock();
  for (const auto& simulation : simulations) outcome = simulation->run(Recorder());
  const double seconds = clock() - start;
  run.steps = outcome.steps;
  run.evaluations = outcome.evaluations;
  if (outcome.diverged) run.diverged = outcome.reason;
  run.suspect = suspicion(outcome);
  return seconds / run.batch;
}

}  // namespace

double TimedRun::median_s() const { return median(seconds); }
double TimedRun::mad_s() const { return median_absolute_deviation(seconds); }

void time_in_turns(std::span<TimedRun> runs, int rounds, const std::function<void(int round)>& begins, Clock clock,
                   double enough_s) {
  if (begins) begins(0);
  for (TimedRun& run : runs) {
    run.batch = 1;
    const double once = std::max(mean_seconds(run, clock), 1e-9);
    if (once >= enough_s) run.seconds.push_back(once);
    run.batch = static_cast<int>(std::clamp(std::ceil(long_enough_s / once), 1.0, most_in_a_batch));
  }
  for (int round = 1; round <= rounds; ++round) {
    if (begins) begins(round);
    for (TimedRun& run : runs) {
      if (std::accumulate(run.seconds.begin(), run.seconds.end(), 0.0) >= enough_s) continue;
      run.seconds.push_back(mean_seconds(run, clock));
    }
  }
}

TimingRow timing_row(const TimedRun& timed) {
  const Evaluator& evaluator = *timed.evaluator;
  TimingRow row;
  row.scenario = evaluator.scenario().name;
  row.method = timed.method->name;
  row.step_s = evaluator.grid().step_s;
  row.steps = timed.steps;
  row.simulated_s = timed.diverged.empty() ? evaluator.grid().time(evaluator.grid().rows - 1)
                                           : static_cast<double>(timed.steps) * row.step_s;
  row.repeats = static_cast<int>(timed.seconds.size());
  row.median_s = timed.median_s();
  row.mad_s = timed.mad_s();
  row.min_s = *std::ranges::min_element(timed.seconds);
  row.ns_per_step = 1e9 * row.median_s / static_cast<double>(std::max(timed.steps, 1L));
  row.realtime_factor = row.simulated_s / row.median_s;
  return row;
}

}  // namespace odeval::catalogue
