// odeval bench: what a step costs. Methods take turns, so that a machine that slows down slows all of them.
#include "cli/bench.hpp"

#include <fmt/format.h>
#include <algorithm>

#include <iostream>

#include "catalogue/equal_error.hpp"
#include "catalogue/table_5_2.hpp"
#include "catalogue/timing.hpp"
#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "output/timing.hpp"

namespace odeval::cli {
namespace {

/// One scenario in the methods chosen for it.
struct Plan {
  std::string name_or_path;
  catalogue::Evaluator evaluator;
  std::vector<const catalogue::Method*> methods;
};

std::vector<Plan> plans_of(const BenchOptions& options) {
  if (options.equal_error > 0) {
    refuse_searched(options.settings.overrides(), catalogue::searched_keys, "--equal-error");
  }
  std::vector<Plan> plans;
  std::vector<Chosen> chosen;
  const auto names = options.scenarios.empty() ? shipped_scenarios() : options.scenarios;
  for (const std::string& name : names) {
    const Scenario scenario = options.settings.read(name);
    if (std::ranges::any_of(plans, [&](const Plan& plan) { return plan.evaluator.scenario().name == scenario.name; })) {
      throw UserError(name + ": a second scenario named '" + scenario.name + "'; give each a name of its own");
    }
    chosen.push_back({scenario, chosen_methods(options.methods, scenario)});
    plans.push_back({name, catalogue::Evaluator(scenario), chosen.back().methods});
  }
  require_read(options.settings.overrides(), chosen);
  return plans;
}

NamedTexts environment(const std::vector<Plan>& plans) {
  auto texts = catalogue::machine();
  for (const auto& version : catalogue::versions()) texts.push_back(version);
  std::vector<const catalogue::Method*> methods;
  for (const Plan& plan : plans) methods.insert(methods.end(), plan.methods.begin(), plan.methods.end());
  for (const auto& version : catalogue::engine_versions(methods)) texts.push_back(version);
  return texts;
}

/// Times runs in turns and says how far it is.
void time_with_progress(std::span<catalogue::TimedRun> runs, const std::string& scenario, const BenchOptions& options,
                        Progress& progress) {
  const auto begins = [&](int round) {
    progress.next(scenario + (round == 0 ? " warm-up" : " round " + std::to_string(round)));
  };
  catalogue::time_in_turns(runs, options.repeats, begins, catalogue::cpu_seconds, options.enough_s);
}

int bench_at_equal_steps(const BenchOptions& options) {
  std::vector<Plan> plans = plans_of(options);
  std::vector<TimingRow> rows;
  std::vector<Table52Row> table_5_2;
  std::string diverged;
  std::string suspect;
  {
    Progress progress(plans.size() * static_cast<std::size_t>(options.repeats + 1), options.quiet);
    for (Plan& plan : plans) {
      std::vector<catalogue::TimedRun> runs;
      for (const catalogue::Method* method : plan.methods) runs.push_back({&plan.evaluator, method, 0, 0, {}});
      time_with_progress(runs, plan.evaluator.scenario().name, options, progress);
      for (const auto& run : runs) {
        rows.push_back(catalogue::timing_row(run));
        if (!run.suspect.empty()) {
          suspect += fmt::format("odeval: {} {} is suspect: {}\n", rows.back().scenario, run.method->name, run.suspect);
        }
        if (run.diverged.empty()) continue;
        diverged += fmt::format("odeval: {} {} diverged: {}; its times are of the {} steps until then\n",
                                rows.back().scenario, run.method->name, run.diverged, run.steps);
      }
      if (catalogue::is_of_table_5_2(plan.evaluator.scenario())) {
        table_5_2 = catalogue::table_5_2_rows(std::span(rows).last(runs.size()));
      }
    }
  }

  const std::filesystem::path folder(options.out);
  const std::string json = timing_json(rows, table_5_2, environment(plans));
  write_whole(folder / "timing.csv", timing_csv(rows));
  write_whole(folder / "timing.json", json);
  if (options.json) {
    std::cout << json;
  } else if (!options.quiet) {
    std::cout << timing_table(rows);
    if (!table_5_2.empty()) {
      std::cout << "\nThe report's Table 5.2 (10 s; ode45's 500 points of 2010 are " << 500 / catalogue::ode45_refine
                << " steps) and this machine:\n"
                << table_5_2_text(table_5_2);
    }
    std::cout << "\nCPU time of the stepping alone. Wrote " << folder.string() << "/timing.csv\n";
  }
  std::cerr << suspect << diverged;
  return diverged.empty() ? 0 : 1;
}

std::vector<EqualErrorRow> at_equal_error(const Plan& plan, const BenchOptions& options, double until_s,
                                          Progress& progress) {
  const Scenario& scenario = plan.evaluator.scenario();
  if (!scenario.planar) {
    throw UserError(
        "--equal-error: must be left out for '" + scenario.name +
        "', since it is of angles of links in a plane; 'odeval recommend --max-error E --until T' keeps errors "
        "of bodies");
  }
  const catalogue::Accuracy accuracy(scenario, until_s);
  if (accuracy.uncertainty() > options.equal_error) {
    throw UserError("--equal-error " + number_text(options.equal_error) + ": must be above what the reference of '" +
                    scenario.name + "' knows until " + number_text(until_s) + " s, " +
                    number_text(accuracy.uncertainty()) + " rad");
  }
  const std::filesystem::path path = scenario_file(plan.name_or_path);
  const ScenarioFile file(path, options.settings.import_options(path));
  const catalogue::EqualError wanted{options.equal_error, options.repeats};
  catalogue::SettingsSearch search(
      file, options.settings.overrides(), known_names(),
      {{{quantity::max_error_q, options.equal_error}}, until_s, wanted.most_steps_tried, false});
  return catalogue::at_equal_error(search, plan.methods, wanted,
                                   [&](const std::string& what) { progress.next(scenario.name + " " + what); });
}

int bench_at_equal_error(const BenchOptions& options) {
  const std::vector<Plan> plans = plans_of(options);
  std::size_t pieces = 0;
  for (const Plan& plan : plans) pieces += plan.methods.size() + static_cast<std::size_t>(options.repeats + 1);
  std::vector<EqualErrorRow> rows;
  {
    Progress progress(pieces, options.quiet);
    for (const Plan& plan : plans) {
      for (EqualErrorRow& row : at_equal_error(plan, options, options.until, progress)) rows.push_back(std::move(row));
    }
  }

  const std::filesystem::path folder(options.out);
  const std::string json = equal_error_json(rows, options.equal_error, options.until, environment(plans));
  write_whole(folder / "equal_error.csv", equal_error_csv(rows, options.equal_error, options.until));
  write_whole(folder / "equal_error.json", json);
  if (options.json) {
    std::cout << json;
  } else if (!options.quiet) {
    std::cout << "cheapest settings with an error of at most " << number_text(options.equal_error) << " rad until "
              << number_text(options.until) << " s\n\n"
              << equal_error_table(rows) << "\nCPU time of the stepping alone. Wrote " << folder.string()
              << "/equal_error.csv\n";
  }
  return 0;
}

}  // namespace

int bench(const BenchOptions& options) {
  return options.equal_error > 0 ? bench_at_equal_error(options) : bench_at_equal_steps(options);
}

Action attach_bench(Flags& flags) {
  const auto options = std::make_shared<BenchOptions>();
  flags.add_option("SCENARIO", options->scenarios, "names or .toml files; default: all that come with the program");
  add_method_option(flags, options->methods);
  flags.add_option("--repeats", options->repeats, "how many rounds are timed")
      .type_name("N")
      .check(whole_within(1, 100000))
      .capture_default_str();
  flags
      .add_option("--equal-error", options->equal_error,
                  "instead of equal steps: each method at the cheapest step or rtol whose angle error stays below E, "
                  "rad")
      .type_name("E")
      .check(number_within(1e-15, 1.0));
  const Flag until = flags.add_option("--until", options->until, "until when the error has to stay below E, s")
                         .type_name("T")
                         .check(number_within(1e-3, 1e4))
                         .capture_default_str();
  add_out_option(flags, options->out);
  flags.add_flag("--quiet", options->quiet, "print neither table nor progress");
  flags.add_flag("--json", options->json, "print the table as JSON");
  options->settings.attach(flags);
  return [options, until] {
    if (until.given() && options->equal_error == 0) {
      throw UserError("--until: has a meaning only beside --equal-error");
    }
    return bench(*options);
  };
}

}  // namespace odeval::cli
