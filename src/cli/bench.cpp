// odeval bench: what a step costs. Methods take turns, so that a machine that slows down slows all of them.
#include "cli/bench.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "catalogue/evaluation.hpp"
#include "catalogue/paths.hpp"
#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/progress.hpp"
#include "measure/spread.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/timing.hpp"
#include "scenario/find_scenario.hpp"

namespace odeval::cli {
namespace {

struct Timed {
  const catalogue::Method* method;
  long steps = 0;
  std::vector<double> seconds;
};

/// CPU time of the stepping alone: the simulation is made before, and nothing is recorded.
void time_once(const catalogue::Evaluator& evaluator, Timed& timed, bool counts) {
  const auto simulation = evaluator.make(*timed.method);
  const double start = catalogue::cpu_seconds();
  timed.steps = simulation->run(nullptr).steps;
  const double seconds = catalogue::cpu_seconds() - start;
  if (counts) timed.seconds.push_back(seconds);
}

TimingRow row_of(const catalogue::Evaluator& evaluator, const Timed& timed) {
  TimingRow row;
  row.scenario = evaluator.scenario().name;
  row.method = timed.method->name;
  row.step_s = evaluator.grid().step_s;
  row.steps = timed.steps;
  row.simulated_s = evaluator.grid().time(evaluator.grid().rows - 1);
  row.repeats = static_cast<int>(timed.seconds.size());
  row.median_s = median(timed.seconds);
  row.mad_s = median_absolute_deviation(timed.seconds);
  row.min_s = *std::ranges::min_element(timed.seconds);
  row.ns_per_step = 1e9 * row.median_s / static_cast<double>(std::max(timed.steps, 1L));
  row.realtime_factor = row.simulated_s / row.median_s;
  return row;
}

}  // namespace

int bench(const BenchOptions& options) {
  struct Plan {
    catalogue::Evaluator evaluator;
    std::vector<Timed> timed;
  };
  std::vector<Plan> plans;
  const auto names = options.scenarios.empty() ? scenario_names(catalogue::scenario_folder()) : options.scenarios;
  for (const std::string& name : names) {
    const Scenario scenario = options.settings.read(name);
    if (std::ranges::any_of(plans, [&](const Plan& plan) { return plan.evaluator.scenario().name == scenario.name; })) {
      throw UserError(name + ": a second scenario named '" + scenario.name + "'; give each a name of its own");
    }
    Plan& plan = plans.emplace_back(Plan{catalogue::Evaluator(scenario), {}});
    for (const catalogue::Method* method : chosen_methods(options.methods, scenario))
      plan.timed.push_back({method, 0, {}});
  }

  std::vector<TimingRow> rows;
  {
    Progress progress(plans.size() * static_cast<std::size_t>(options.repeats + 1), options.quiet);
    for (Plan& plan : plans) {
      for (int round = 0; round <= options.repeats; ++round) {  // round 0 warms up
        progress.next(plan.evaluator.scenario().name + (round == 0 ? " warm-up" : " round " + std::to_string(round)));
        for (Timed& timed : plan.timed) time_once(plan.evaluator, timed, round > 0);
      }
      for (const Timed& timed : plan.timed) rows.push_back(row_of(plan.evaluator, timed));
    }
  }

  auto environment = catalogue::machine();
  for (const auto& version : catalogue::versions()) environment.push_back(version);
  const std::filesystem::path folder(options.out);
  write_whole(folder / "timing.csv", timing_csv(rows));
  write_whole(folder / "timing.json", timing_json(rows, environment));
  if (options.json) {
    std::cout << timing_json(rows, environment);
  } else if (!options.quiet) {
    std::cout << timing_table(rows) << "\nCPU time of the stepping alone. Wrote " << folder.string() << "/timing.csv\n";
  }
  return 0;
}

Action attach_bench(CLI::App& app) {
  const auto options = std::make_shared<BenchOptions>();
  app.add_option("SCENARIO", options->scenarios, "names or .toml files; default: all that come with the program");
  add_method_option(app, options->methods);
  app.add_option("--repeats", options->repeats, "timed rounds")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  add_out_option(app, options->out);
  app.add_flag("--quiet", options->quiet, "no table, no progress");
  app.add_flag("--json", options->json, "the table for programs");
  options->settings.attach(app);
  return [options] { return bench(*options); };
}

}  // namespace odeval::cli
