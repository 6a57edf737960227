// What two workers of a sweep bring, and what sweeping costs beside the runs.
//
//   odeval-sweep-throughput [ROUNDS [RUNS]]
//
// Real runs of the double pendulum (ode-step-double), of about half a millisecond, 20 ms and 60 ms. Each round times
// one after the other, in turn: the same runs in a bare loop in this process with everything at hand (reference,
// scenario read); then in a sweep with one worker and one with two, journal and all. Prints medians of the rounds, in
// wall time and in CPU time of all processes together, and the load of the machine; judges nothing.
//
//   throughput          wall time of one worker over that of two
//   by CPU              the same, had nobody else used the machine: twice the CPU time of one over that of two
//   overhead, wall      of a run in the sweep of one worker beyond the bare loop, preparation of the reference left out
//   overhead, CPU       the same in CPU time
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "catalogue/grid_runs.hpp"
#include "catalogue/paths.hpp"
#include "cli/settings.hpp"
#include "measure/spread.hpp"
#include "output/sweep_table.hpp"
#include "sweep/sweep.hpp"

namespace {

using namespace odeval;
namespace fs = std::filesystem;

struct Times {
  double wall_s = 0;
  double cpu_s = 0;
};

/// CPU seconds of this process and of its children that have ended, user and system together.
double all_cpu_seconds() {
  double seconds = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    ::getrusage(who, &usage);
    for (const timeval& t : {usage.ru_utime, usage.ru_stime}) {
      seconds += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    }
  }
  return seconds;
}

template <class Action>
Times timed(const Action& action) {
  const double cpu = all_cpu_seconds();
  const double wall = sweep::steady_seconds();
  action();
  return {sweep::steady_seconds() - wall, all_cpu_seconds() - cpu};
}

struct Case {
  const char* what;
  double duration_s;
  long runs;
};

std::vector<double> of(const std::vector<Times>& times, double Times::*part) {
  std::vector<double> values;
  for (const Times& t : times) values.push_back(t.*part);
  return values;
}

void measure(const Case& wanted, int rounds, const fs::path& folder) {
  const ScenarioFile file(catalogue::scenario_folder() / "double_pendulum.toml");
  // A grid of ERP, which the reference does not depend on: one group.
  const sweep::Axis erp =
      sweep::parse_axis(fmt::format("ode.erp=lin:0.1:0.9:{}", wanted.runs), [](auto&) { return false; });
  const std::vector<Override> settings{{"duration", fmt::format("{}", wanted.duration_s), "--duration"}};
  catalogue::GridRuns runs(file, settings, cli::known_names(), sweep::Grid({erp, {"method", {"ode-step-double"}}}));
  const auto groups = runs.groups();
  const auto work = runs.work();
  const catalogue::Method& method = catalogue::find_method("ode-step-double");

  int journals = 0;
  const auto sweep_with = [&](int jobs) {
    const sweep::Head head{"double_pendulum", {}, runs.grid().axes(), result_columns(), "", ""};
    sweep::Journal journal(folder / std::to_string(++journals) / "benchmark.journal", head);
    run_sweep(work, groups, journal, {jobs, 3600, {}});
    if (journal.rows(sweep::Status::ok) != wanted.runs) fmt::print("not all runs are ok\n");
  };

  std::vector<Times> bare, one, two, preparation;
  std::vector<double> throughput, by_cpu, overhead_wall, overhead_cpu;
  for (int round = -1; round < rounds; ++round) {  // the first warms up
    std::shared_ptr<const Reference> reference;
    const Times prepared = timed(
        [&] { reference = std::make_shared<const Reference>(catalogue::Evaluator(runs.scenario(0)).reference()); });
    std::vector<Scenario> scenarios;
    for (long run = 0; run < wanted.runs; ++run) scenarios.push_back(runs.scenario(run));
    const Times plain = timed([&] {
      for (Scenario& scenario : scenarios) {
        catalogue::Evaluator evaluator(std::move(scenario), reference);
        const catalogue::Evaluation evaluation = evaluator.evaluate(method);
        const SampleGrid& rows = evaluator.grid();
        const Metrics metrics = evaluator.measure(evaluation, rows.time(rows.rows - 1));
        if (evaluation.outcome.diverged || !metrics.max_error_q) fmt::print("not all runs are ok\n");
      }
    });
    const Times with_one = timed([&] { sweep_with(1); });
    const Times with_two = timed([&] { sweep_with(2); });
    fs::remove_all(folder);
    if (round < 0) continue;
    bare.push_back(plain);
    one.push_back(with_one);
    two.push_back(with_two);
    preparation.push_back(prepared);
    const auto count = static_cast<double>(wanted.runs);
    // Preparation has to come first in either sweep and takes one worker.
    throughput.push_back((with_one.wall_s - prepared.wall_s) / (with_two.wall_s - prepared.wall_s));
    by_cpu.push_back(2 * (with_one.cpu_s - prepared.cpu_s) / (with_two.cpu_s - prepared.cpu_s));
    overhead_wall.push_back((with_one.wall_s - prepared.wall_s - plain.wall_s) / count);
    overhead_cpu.push_back((with_one.cpu_s - prepared.cpu_s - plain.cpu_s) / count);
  }
  double load = 0;
  ::getloadavg(&load, 1);
  const double run_ms = 1e3 * median(of(bare, &Times::wall_s)) / static_cast<double>(wanted.runs);
  fmt::print("{:<8} {:5} {:9.3f} {:11.3f} {:11.3f} {:11.3f} {:11.3f} {:11.2f} {:8.2f} {:10.3f} {:9.3f} {:6.1f}\n",
             wanted.what, wanted.runs, run_ms, median(of(preparation, &Times::wall_s)),
             median(of(bare, &Times::wall_s)), median(of(one, &Times::wall_s)), median(of(two, &Times::wall_s)),
             median(throughput), median(by_cpu), 1e3 * median(overhead_wall), 1e3 * median(overhead_cpu), load);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 9;
  const long runs = argc > 2 ? std::max(2, std::atoi(argv[2])) : 100;
  const fs::path folder = fs::temp_directory_path() / fmt::format("odeval-sweep-throughput-{}", ::getpid());
  fmt::print("double_pendulum, {} rounds, medians\n", rounds);
  fmt::print("{:<8} {:>5} {:>9} {:>11} {:>11} {:>11} {:>11} {:>11} {:>8} {:>10} {:>9} {:>6}\n", "case", "runs",
             "run, ms", "prepare, s", "bare, s", "1 worker, s", "2 workers,s", "throughput", "by CPU", "over, ms",
             "CPU, ms", "load");
  for (const Case& each : {Case{"short", 0.3, 10 * runs}, Case{"20 ms", 10, runs}, Case{"60 ms", 30, runs / 2}}) {
    measure(each, rounds, folder);
  }
  fs::remove_all(folder);
}
