// What two workers of a sweep bring, and what sweeping costs beside the runs.
//
//   odeval-sweep-throughput [ROUNDS [RUNS]]
//
// Real runs of the double pendulum (ode-step-double), of about half a millisecond, 20 ms and 60 ms. Each round times
// one after the other, in turn: the same runs in a bare loop in this process with everything at hand (reference,
// scenario read); then in sweeps with one worker and with two, journal and all, of RUNS runs and of three times as many
// (short ones: ten times that). What the longer sweep took more is what its further runs cost; what is left of the
// shorter one is paid once a sweep (processes, their first pages of memory, the reference). Prints medians of the
// rounds, in wall time and in CPU time of all processes together, and the load of the machine; judges nothing.
//
//   once                of a sweep with one worker, whatever the number of its runs
//   machine             what a second process of the bare loop is worth here and now: the most that can be had
//   throughput          wall time of a further run with one worker over that with two
//   by CPU              the same, had nobody else used the machine: twice the CPU time with one over that with two
//   overhead, wall      of a further run with one worker beyond one of the bare loop
//   overhead, CPU       the same in CPU time
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "catalogue/grid_runs.hpp"
#include "catalogue/paths.hpp"
#include "cli/settings.hpp"
#include "measure/spread.hpp"
#include "odeval/error.hpp"
#include "output/sweep_table.hpp"
#include "sweep/sweep.hpp"

namespace {

using namespace odeval;
namespace fs = std::filesystem;

struct Times {
  double wall_s = 0;
  double cpu_s = 0;

  Times operator-(const Times& other) const { return {wall_s - other.wall_s, cpu_s - other.cpu_s}; }
  Times operator/(double count) const { return {wall_s / count, cpu_s / count}; }
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

void run_all(std::span<const Scenario> scenarios, const std::shared_ptr<const Reference>& reference,
             const catalogue::Method& method) {
  for (const Scenario& scenario : scenarios) {
    catalogue::Evaluator evaluator(scenario, reference);
    const catalogue::Evaluation evaluation = evaluator.evaluate(method);
    const SampleGrid& rows = evaluator.grid();
    const Metrics metrics = evaluator.measure(evaluation, rows.time(rows.rows - 1));
    if (evaluation.outcome.diverged || !metrics.max_error_q) fmt::print("not all runs are ok\n");
  }
}

/// Half of the runs in this process and half in another at the same time, once both are warm: what this machine gives
/// two processes that have nothing to do with each other.
Times timed_beside(std::span<const Scenario> scenarios, const std::shared_ptr<const Reference>& reference,
                   const catalogue::Method& method) {
  const std::size_t half = scenarios.size() / 2;
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) throw MachineError("no pipe");
  char byte = 0;
  const auto say = [&](int end) { return ::write(end, &byte, 1) == 1; };
  const auto hear = [&](int end) { return ::read(end, &byte, 1) == 1; };
  const pid_t other = ::fork();
  if (other == 0) {
    run_all(scenarios.first(1), reference, method);
    const bool asked = say(ends[1]) && hear(ends[1]);
    if (asked) run_all(scenarios.subspan(half), reference, method);
    ::_exit(asked && say(ends[1]) ? 0 : 1);
  }
  if (other < 0 || !hear(ends[0])) throw MachineError("no second process");
  const Times together = timed([&] {
    if (!say(ends[0])) throw MachineError("the second process is gone");
    run_all(scenarios.first(half), reference, method);
    if (!hear(ends[0])) throw MachineError("the second process is gone");
  });
  ::waitpid(other, nullptr, 0);
  for (const int end : ends) ::close(end);
  return together;
}

void measure(const Case& wanted, int rounds, const fs::path& folder) {
  const ScenarioFile file(catalogue::scenario_folder() / "double_pendulum.toml");
  // A grid of ERP, which the reference does not depend on: one group.
  const auto grid_of = [](long runs) {
    const std::string erp = fmt::format("ode.erp=lin:0.1:0.9:{}", runs);
    return sweep::Grid({sweep::parse_axis(erp, [](auto&) { return false; }), {"method", {"ode-step-double"}}});
  };
  const std::vector<Override> settings{{"duration", fmt::format("{}", wanted.duration_s), "--duration"}};
  catalogue::GridRuns runs(file, settings, cli::known_names(), grid_of(wanted.runs));
  catalogue::GridRuns few(file, settings, cli::known_names(), grid_of(wanted.runs / 3));
  const auto groups = runs.groups();
  const auto few_groups = few.groups();
  const catalogue::Method& method = catalogue::find_method("ode-step-double");

  int journals = 0;
  const auto sweep_with = [&](int jobs, catalogue::GridRuns& swept, const std::vector<std::uint32_t>& swept_groups) {
    const sweep::Head head{"double_pendulum", {}, swept.grid().axes(), result_columns(), "", ""};
    sweep::Journal journal(folder / std::to_string(++journals) / "benchmark.journal", head);
    run_sweep(swept.work(), swept_groups, journal, {jobs, 3600, {}});
    if (journal.rows(sweep::Status::ok) != swept.grid().runs()) fmt::print("not all runs are ok\n");
  };

  const auto reference = std::make_shared<const Reference>(catalogue::Evaluator(runs.scenario(0)).reference());
  const auto further = static_cast<double>(wanted.runs - wanted.runs / 3);
  std::vector<double> bare_ms, one_ms, two_ms, once_ms, machine, throughput, by_cpu, overhead_wall, overhead_cpu;
  for (int round = -1; round < rounds; ++round) {  // the first warms up
    std::vector<Scenario> scenarios;
    for (long run = wanted.runs / 3; run < wanted.runs; ++run) scenarios.push_back(runs.scenario(run));
    const Times few_of_one = timed([&] { sweep_with(1, few, few_groups); });
    const Times few_of_two = timed([&] { sweep_with(2, few, few_groups); });
    const Times bare = timed([&] { run_all(scenarios, reference, method); }) / further;
    const Times bare_beside = timed_beside(scenarios, reference, method) / further;
    const Times all_of_one = timed([&] { sweep_with(1, runs, groups); });
    const Times all_of_two = timed([&] { sweep_with(2, runs, groups); });
    fs::remove_all(folder);
    if (round < 0) continue;
    const Times one = (all_of_one - few_of_one) / further;
    const Times two = (all_of_two - few_of_two) / further;
    bare_ms.push_back(1e3 * bare.wall_s);
    one_ms.push_back(1e3 * one.wall_s);
    two_ms.push_back(1e3 * two.wall_s);
    once_ms.push_back(1e3 * (few_of_one.wall_s - static_cast<double>(wanted.runs / 3) * one.wall_s));
    machine.push_back(bare.wall_s / bare_beside.wall_s);
    throughput.push_back(one.wall_s / two.wall_s);
    by_cpu.push_back(2 * one.cpu_s / two.cpu_s);
    overhead_wall.push_back(1e3 * (one.wall_s - bare.wall_s));
    overhead_cpu.push_back(1e3 * (one.cpu_s - bare.cpu_s));
  }
  double load = 0;
  ::getloadavg(&load, 1);
  fmt::print("{:<8} {:5} {:9.3f} {:9.1f} {:11.3f} {:12.3f} {:8.2f} {:11.2f} {:8.2f} {:9.3f} {:9.3f} {:6.1f}\n",
             wanted.what, wanted.runs, median(bare_ms), median(once_ms), median(one_ms), median(two_ms),
             median(machine), median(throughput), median(by_cpu), median(overhead_wall), median(overhead_cpu), load);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 15;
  const long runs = argc > 2 ? std::max(2, std::atoi(argv[2])) : 20;
  const fs::path folder = fs::temp_directory_path() / fmt::format("odeval-sweep-throughput-{}", ::getpid());
  fmt::print("double_pendulum, {} rounds, medians\n", rounds);
  fmt::print("{:<8} {:>5} {:>9} {:>9} {:>11} {:>12} {:>8} {:>11} {:>8} {:>9} {:>9} {:>6}\n", "case", "runs", "bare, ms",
             "once, ms", "1 work., ms", "2 work., ms", "machine", "throughput", "by CPU", "over, ms", "CPU, ms",
             "load");
  for (const Case& each : {Case{"short", 0.3, 30 * runs}, Case{"20 ms", 10, 3 * runs}, Case{"60 ms", 30, 3 * runs}}) {
    measure(each, rounds, folder);
  }
  fs::remove_all(folder);
}
