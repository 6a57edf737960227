// What a second worker of a sweep is worth, and what sweeping costs beside the runs.
//
//   odeval-sweep-throughput [ROUNDS [SECONDS]]
//
// Real runs of the double pendulum (ode-step-double) of three lengths, over ERP, on which no time depends. Four parties
// do such runs without end: a bare loop with everything at hand (reference, scenarios read), two such loops in two
// processes, a sweep with one worker and a sweep with two, journal and all. Only one party is awake at a time (the
// others are stopped by SIGSTOP): in each round each gets SECONDS, in turn, so that whatever else happens on the
// machine falls on all of them alike. Who works alone is held to one of two processors, the other one in the next
// round: one processor may well be slower than the other for a while. What a sweep pays once (processes, the reference)
// is over before the count begins. The rounds come in ten parts, each with new processes, since where its memory lies
// makes a process a few percent faster or slower for all of its life. Prints what the whole of the rounds gives, and as
// +- the standard error of the mean over the parts; judges nothing.
//
//   bare         time of a run in the bare loop
//   machine      runs of two bare loops over those of one: what this machine, here and now, gives two processes that
//                have nothing to do with each other
//   throughput   runs of two workers over those of one
//   overhead     time of a run with one worker beyond that of the bare loop; the sweep's own process may use another
//                processor than its worker, and what it does there meanwhile does not show
//   load         processes that wanted to run in the last minute, these among them
#include <fmt/format.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include "catalogue/grid_runs.hpp"
#include "catalogue/paths.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "output/sweep_table.hpp"
#include "run/clock.hpp"
#include "run/sweep.hpp"

namespace {

using namespace odeval;
namespace fs = std::filesystem;

constexpr std::size_t parts = 10;

using Count = std::atomic<long>;
static_assert(Count::is_always_lock_free, "shared between processes");

Count& shared_count() {
  void* const memory = ::mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw MachineError("no memory to share");
  return *new (memory) Count(0);
}

/// Processes that count the runs they do, awake only in `turn`.
class Party {
 public:
  explicit Party(const std::function<void(Count& done)>& work) {
    leader_ = ::fork();
    if (leader_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      ::setpgid(0, 0);
      try {
        work(done_);
      } catch (const std::exception& error) {
        fmt::print(stderr, "odeval-sweep-throughput: {}\n", error.what());
      }
      ::_exit(1);  // its work has no end
    }
    if (leader_ < 0) throw MachineError("no process for a party");
    ::setpgid(leader_, leader_);
    while (done_ < 5) sleep(0.01);
    ::kill(-leader_, SIGSTOP);
  }
  ~Party() {
    ::kill(-leader_, SIGKILL);
    ::waitpid(leader_, nullptr, 0);
  }
  Party(const Party&) = delete;
  Party& operator=(const Party&) = delete;

  /// Runs a second.
  double turn(double seconds) const {
    const long before = done_;
    const double begun = run::steady_seconds();
    ::kill(-leader_, SIGCONT);
    sleep(seconds);
    ::kill(-leader_, SIGSTOP);
    const double took = run::steady_seconds() - begun;
    return static_cast<double>(done_ - before) / took;
  }

 private:
  void sleep(double seconds) const {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    if (::waitpid(leader_, nullptr, WNOHANG) != 0) throw MachineError("a party has ended before its time");
  }

  Count& done_ = shared_count();
  pid_t leader_ = -1;
};

/// One of the first two processors that this program may use: the other one in every other round.
class Processor {
 public:
  Processor() {
    cpu_set_t allowed;
    if (::sched_getaffinity(0, sizeof allowed, &allowed) != 0) throw MachineError("no list of processors");
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (CPU_ISSET(cpu, &allowed)) cpus_.push_back(cpu);
    }
    if (cpus_.size() < 2) throw MachineError("one processor: nothing to compare");
  }

  void choose(std::size_t round) { chosen_ = cpus_[round % 2]; }

  /// In the process that works alone.
  void keep_to_it() const {
    static long kept = -1;
    const long chosen = chosen_;
    if (chosen == kept) return;
    kept = chosen;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(chosen), &set);
    if (::sched_setaffinity(0, sizeof set, &set) != 0) throw MachineError("cannot choose a processor");
  }

 private:
  std::vector<int> cpus_;
  Count& chosen_ = shared_count();
};

struct Estimate {
  double value = 0;
  double standard_error = 0;
};

double mean(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  return std::accumulate(values.begin() + static_cast<long>(begin), values.begin() + static_cast<long>(end), 0.0) /
         static_cast<double>(end - begin);
}

/// Of a quantity made of the mean rates of two parties.
template <class Quantity>
Estimate estimate(const std::vector<double>& a, const std::vector<double>& b, const Quantity& quantity) {
  const std::size_t rounds = a.size();
  const double whole = quantity(mean(a, 0, rounds), mean(b, 0, rounds));
  double squares = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t begin = rounds * part / parts;
    const std::size_t end = rounds * (part + 1) / parts;
    squares += std::pow(quantity(mean(a, begin, end), mean(b, begin, end)) - whole, 2);
  }
  return {whole, std::sqrt(squares / (parts * (parts - 1)))};
}

struct Case {
  const char* what;
  double duration_s;
  long runs;  // more than will be done
};

void measure(const Case& wanted, std::size_t rounds, double seconds, const fs::path& folder) {
  const ScenarioFile file(catalogue::scenario_folder() / "double_pendulum.toml");
  // A grid of ERP, which the reference does not depend on: one group.
  const std::string erp = fmt::format("ode.erp=lin:0.1:0.9:{}", wanted.runs);
  catalogue::GridRuns runs(
      file, {{"duration", fmt::format("{}", wanted.duration_s), "--duration"}}, cli::known_names(),
      sweep::Grid({sweep::parse_axis(erp, [](auto&) { return false; }), {"method", {"ode-step-double"}}}));
  const auto groups = runs.groups();
  const catalogue::Method& method = catalogue::find_method("ode-step-double");
  const auto reference = std::make_shared<const Reference>(catalogue::Evaluator(runs.scenario(0)).reference());
  std::vector<Scenario> scenarios;
  for (long i = 0; i < 100; ++i) scenarios.push_back(runs.scenario(i));

  const auto loop = [&](Count& done, const Processor* alone) {
    ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // as in a sweep's workers: pages are not given back between runs
    ::mallopt(M_TRIM_THRESHOLD, 256 << 20);
    for (std::size_t i = 0;; ++i) {
      if (alone) alone->keep_to_it();
      catalogue::Evaluator evaluator(scenarios[i % scenarios.size()], reference);
      const catalogue::Evaluation evaluation = evaluator.evaluate(method);
      const SampleGrid& rows = evaluator.grid();
      const Metrics metrics = evaluator.measure(evaluation, rows.time(rows.rows - 1));
      if (evaluation.outcome.diverged || !metrics[quantity::max_error_q]) return;
      ++done;
    }
  };
  const auto sweep_with = [&](int jobs, Count& done, const Processor* alone) {
    sweep::Work work = runs.work();
    if (alone) {
      work.run = [alone, run = work.run](long number, long group, std::string_view prepared) {
        alone->keep_to_it();
        return run(number, group, prepared);
      };
    }
    const sweep::Head head{"double_pendulum", {}, runs.grid().axes(), result_columns(), "", ""};
    sweep::Journal journal(folder / fmt::format("{} {}", wanted.what, jobs) / "benchmark.journal", head);
    run_sweep(work, groups, journal, {jobs, 3600, [&](const sweep::Journal& j) { done = j.rows(sweep::Status::ok); }});
  };

  Processor processor;
  std::array<std::vector<double>, 4> rates;
  for (std::size_t part = 0; part < parts; ++part) {
    const Party bare_one([&](Count& done) { loop(done, &processor); });
    const Party bare_two([&](Count& done) {
      const pid_t leader = ::getpid();
      const pid_t second = ::fork();
      if (second < 0) throw MachineError("no process for the second loop");
      if (second == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != leader) return;
      }
      loop(done, nullptr);
    });
    const Party sweep_one([&](Count& done) { sweep_with(1, done, &processor); });
    const Party sweep_two([&](Count& done) { sweep_with(2, done, nullptr); });
    const std::array<const Party*, 4> parties{&bare_one, &bare_two, &sweep_one, &sweep_two};
    for (std::size_t round = 0; round < rounds / parts; ++round) {
      processor.choose(round);
      for (std::size_t i = 0; i < parties.size(); ++i) {
        const std::size_t whose = round / 2 % 2 == 0 ? i : parties.size() - 1 - i;
        rates[whose].push_back(parties[whose]->turn(seconds));
      }
    }
    fs::remove_all(folder);
  }

  const auto ratio = [](double a, double b) { return a / b; };
  const auto ms_longer = [](double a, double b) { return 1e3 / a - 1e3 / b; };
  const Estimate machine = estimate(rates[1], rates[0], ratio);
  const Estimate throughput = estimate(rates[3], rates[2], ratio);
  const Estimate overhead = estimate(rates[2], rates[0], ms_longer);
  double load = 0;
  ::getloadavg(&load, 1);
  fmt::print("{:<8} {:9.3f} {:10.3f} +- {:.3f} {:10.3f} +- {:.3f} {:10.3f} +- {:.3f} {:6.1f}\n", wanted.what,
             1e3 / mean(rates[0], 0, rates[0].size()), machine.value, machine.standard_error, throughput.value,
             throughput.standard_error, overhead.value, overhead.standard_error, load);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const auto rounds = static_cast<std::size_t>(argc > 1 ? std::max(static_cast<int>(parts), std::atoi(argv[1])) : 240);
  const double seconds = argc > 2 ? std::max(0.01, std::atof(argv[2])) : 0.1;
  const fs::path folder = fs::temp_directory_path() / fmt::format("odeval-sweep-throughput-{}", ::getpid());
  fmt::print("double_pendulum, {} rounds of {} s each\n", rounds, seconds);
  fmt::print("{:<8} {:>9} {:>19} {:>19} {:>19} {:>6}\n", "case", "bare, ms", "machine", "throughput", "overhead, ms",
             "load");
  int status = 0;
  try {
    for (const Case& each : {Case{"short", 0.3, 400'000}, Case{"20 ms", 10, 20'000}, Case{"60 ms", 30, 10'000}}) {
      measure(each, rounds, seconds, folder);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "odeval-sweep-throughput: {}\n", error.what());
    status = 1;
  }
  fs::remove_all(folder);
  return status;
}
