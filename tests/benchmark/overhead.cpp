// What the harness costs beside a bare C loop of dWorldStep on the same world.
//
//   odeval-overhead [ROUNDS] [METHOD...]
//
// Interleaved in one run: each round times the bare loop, the harness's stepping loop, the same with every sample
// recorded, and the whole command `odeval run double_pendulum --method ode-step-double`. Then for the other engines of
// this build, or those methods that are named, the engine's own loop and the harness's. Prints medians and the median
// of the rounds' ratios; judges nothing.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "catalogue/paths.hpp"
#include "cli/settings.hpp"
#include "measure/spread.hpp"
#include "model/read_scenario.hpp"
#include "odeval/part.hpp"
#include "tests/benchmark/bare_engine.h"
#include "tests/benchmark/bare_loop.h"

namespace {

using odeval::median;
using odeval::catalogue::cpu_seconds;

/// CPU seconds of the command, children's user and system time together.
double command_seconds(const std::filesystem::path& program, const std::filesystem::path& out) {
  const auto used = [] {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  };
  const double before = used();
  const pid_t child = fork();
  if (child == 0) {
    execl(program.c_str(), program.c_str(), "run", "double_pendulum", "--method", "ode-step-double", "--out",
          out.c_str(), "--quiet", static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0) fmt::print("the command failed with status {}\n", status);
  return used() - before;
}

/// An engine alone, of a module.
struct Bare {
  decltype(&bare_create) create;
  decltype(&bare_run) run;
  decltype(&bare_height) height;
  decltype(&bare_destroy) destroy;

  explicit Bare(const std::string& file)
      : create(odeval::part_function<decltype(create)>(file, "bare_create", "bare loop")),
        run(odeval::part_function<decltype(run)>(file, "bare_run", "bare loop")),
        height(odeval::part_function<decltype(height)>(file, "bare_height", "bare loop")),
        destroy(odeval::part_function<decltype(destroy)>(file, "bare_destroy", "bare loop")) {}
};

void compare(const odeval::catalogue::Method& method, const odeval::catalogue::Evaluator& evaluator, int rounds) {
  const std::string name(method.name);
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string engine = name.substr(0, name.find('-')) + (name.ends_with("-single") ? "_single" : "");
  const Bare bare(here / ("libodeval_bare_" + engine + ".so"));
  const odeval::SampleGrid grid = evaluator.grid();
  std::vector<double> alone, within, ratios;
  double height = 0;
  for (int round = -1; round < rounds; ++round) {  // the first round warms up
    bare.create(name.c_str());
    double start = cpu_seconds();
    bare.run(grid.steps());
    const double alone_s = cpu_seconds() - start;
    height = bare.height();
    bare.destroy();

    const auto simulation = evaluator.make(method);
    start = cpu_seconds();
    simulation->run(odeval::Recorder());
    const double within_s = cpu_seconds() - start;
    if (round < 0) continue;
    alone.push_back(alone_s);
    within.push_back(within_s);
    ratios.push_back(within_s / alone_s);
  }
  const auto recorder = evaluator.make(method);
  odeval::Motion motion(recorder->shape(), static_cast<std::size_t>(grid.rows));
  recorder->run(odeval::Recorder(motion));
  const double steps = static_cast<double>(grid.steps());
  fmt::print("{:<28} bare {:7.3f} µs/step, harness {:7.3f}  {:6.3f} x bare; link 2 at {:.9f} m and {:.9f} m\n", name,
             1e6 * median(alone) / steps, 1e6 * median(within) / steps, median(ratios), height,
             motion[motion.size() - 1].bodies[1].position[2]);
}

}  // namespace

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 21;
  const odeval::Scenario scenario = odeval::read_scenario(odeval::catalogue::scenario_folder() / "double_pendulum.toml",
                                                          {}, odeval::cli::known_names());
  odeval::catalogue::Evaluator evaluator(scenario);
  const odeval::SampleGrid grid = evaluator.grid();
  const odeval::catalogue::Method& method = odeval::catalogue::find_method("ode-step-double");
  std::vector<std::string> named(argv + std::min(argc, 2), argv + argc);
  for (const odeval::catalogue::Method& other : odeval::catalogue::methods()) {
    const bool wanted = named.empty() || std::ranges::find(named, other.name) != named.end();
    if (other.tells && other.make != nullptr && wanted) compare(other, evaluator, rounds);
  }
  if (!named.empty()) return 0;
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "odeval";
  const fs::path out = fs::temp_directory_path() / fmt::format("odeval-overhead-{}", getpid());

  std::vector<double> bare, stepping, recording, command;
  double bare_height = 0;
  double harness_height = 0;
  for (int round = -1; round < rounds; ++round) {  // the first round warms up
    bare_pendulum_create();
    double start = cpu_seconds();
    bare_pendulum_run(grid.steps());
    const double bare_s = cpu_seconds() - start;
    bare_height = bare_pendulum_height();
    bare_pendulum_destroy();

    const auto stepper = evaluator.make(method);
    start = cpu_seconds();
    stepper->run(odeval::Recorder());
    const double stepping_s = cpu_seconds() - start;

    const auto recorder = evaluator.make(method);
    odeval::Motion motion(recorder->shape(), static_cast<std::size_t>(grid.rows));
    start = cpu_seconds();
    recorder->run(odeval::Recorder(motion));
    const double recording_s = cpu_seconds() - start;
    harness_height = motion[motion.size() - 1].bodies[1].position[2];

    const double command_s = command_seconds(program, out);
    if (round < 0) continue;
    bare.push_back(bare_s);
    stepping.push_back(stepping_s);
    recording.push_back(recording_s);
    command.push_back(command_s);
  }
  fs::remove_all(out);

  fmt::print("double_pendulum, {} steps, {} rounds, medians of CPU time\n", grid.steps(), rounds);
  const auto line = [&](const char* what, const std::vector<double>& seconds) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < seconds.size(); ++i) ratios.push_back(seconds[i] / bare[i]);
    fmt::print("{:<34} {:8.3f} ms  {:6.3f} x bare\n", what, 1e3 * median(seconds), median(ratios));
  };
  line("bare C loop of dWorldStep", bare);
  line("stepping loop", stepping);
  line("stepping and recording", recording);
  line("whole command", command);
  fmt::print("height of link 2 at the end: bare {:.9f} m, harness {:.9f} m\n", bare_height, harness_height);
}
