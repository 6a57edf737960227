// odeval run: one scenario in several methods: traces, summaries, a table.
#include <iostream>

#include "catalogue/evaluation.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/plot.hpp"
#include "cli/progress.hpp"
#include "cli/robots.hpp"
#include "cli/run_files.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "output/run_report.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::string scenario;
  std::vector<std::string> methods;
  Settings settings;
  std::string out = "results";
  std::vector<std::string> plot;  // columns
  bool quiet = false;
  bool json = false;
};

/// What the half-step start leaves the first method whose error a shift of the clock explains, until the same time.
std::optional<double> half_step_leaves(const std::vector<RunSummary>& runs) {
  for (const RunSummary& run : runs) {
    const Metrics* const explained = half_a_step(run);
    if (explained == nullptr) continue;
    Scenario scenario = run.scenario;
    scenario.ode.start = Start::half_step;
    scenario.duration_s = explained->until_s;
    catalogue::Evaluator evaluator(scenario);
    const catalogue::Evaluation started = evaluator.evaluate(catalogue::find_method(run.method));
    return evaluator.measure(started, explained->until_s)[quantity::max_error_q];
  }
  return std::nullopt;
}

/// DIR/SCENARIO/plot.svg, from the traces that were just written.
void draw(const std::vector<const catalogue::Method*>& methods, const Options& options, const Scenario& scenario,
          const std::filesystem::path& place) {
  std::vector<DrawnTrace> traces;
  for (const catalogue::Method* method : methods) {
    const std::filesystem::path file = place / (std::string(method->name) + ".csv");
    traces.push_back({file.string(), std::string(method->name), read_csv(file)});
  }
  PlotRequest request{options.plot};
  request.title = scenario.name + ", h = " + number_text(scenario.step_s) + " s";
  draw_traces(traces, request, place / "plot.svg");
}

void require_columns(const std::vector<std::string>& plot) {
  for (const std::string& panel : plot) {
    for (const std::string& name : columns_of(panel)) {
      if (trace_column_of(name) != nullptr) continue;
      std::vector<std::string_view> kinds;
      for (const TraceColumn& row : trace_columns) {
        if (!row.name.empty() && std::ranges::find(kinds, row.name) == kinds.end()) kinds.push_back(row.name);
      }
      throw UserError(
          fmt::format("--plot {}: no trace has such a column; there are {}, with a number (q1) or after a "
                      "name (elbow.q) where there are several",
                      name, fmt::join(kinds, ", ")));
    }
  }
}

int run(const Options& options) {
  require_columns(options.plot);
  const std::filesystem::path file = scenario_file(options.scenario);
  const Scenario scenario = options.settings.read_file(file);
  const auto methods = chosen_methods(options.methods, scenario);
  require_read(options.settings.overrides(), {{{scenario, methods}}});
  const std::filesystem::path place = std::filesystem::path(options.out) / scenario.name;
  const auto require_no_others = [&] {
    const std::string other = results_of_another_run(place, scenario, methods);
    if (other.empty()) return;
    throw UserError("--out " + options.out + ": " + place.string() + " holds results of " + other +
                    "; give another folder, or every method there");
  };
  require_no_others();
  const std::optional<ProvedRobot> robot = proved_robot(file, options.settings.import_options(file));
  catalogue::Evaluator evaluator(scenario);

  std::vector<RunSummary> summaries;
  std::vector<double> ns_per_step;
  bool diverged = false;
  {
    Progress progress(methods.size(), options.quiet, Progress::Clock::shown);
    progress.show(scenario.name + " reference");
    evaluator.reference();
    const ResultFolder folder(place);
    require_no_others();  // that came while the reference was solved
    for (const catalogue::Method* method : methods) {
      progress.next(scenario.name + " " + std::string(method->name));
      const catalogue::Evaluation run = evaluator.evaluate(*method);
      summaries.push_back(folder.write(run, evaluator));
      ns_per_step.push_back(1e9 * evaluator.stepping_s(run) / static_cast<double>(std::max(run.outcome.steps, 1L)));
      diverged = diverged || run.outcome.diverged;
    }
    folder.write_summaries(summaries);
    if (robot) write_whole(place / "import.json", robot->json(file));
  }

  if (options.json) {
    std::cout << summaries_json(summaries);
  } else if (!options.quiet) {
    if (robot) std::cout << robot->report() << '\n';
    std::cout << run_report(summaries, ns_per_step, evaluator.reference(), half_step_leaves(summaries)) << "\nwrote "
              << place.string() << "/\n";
  }
  if (!options.plot.empty()) draw(methods, options, scenario, place);
  return diverged ? 1 : 0;
}

}  // namespace

Action attach_run(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("SCENARIO", options->scenario, "a name ('odeval list') or a .toml, .urdf or .sdf file").required();
  add_method_option(flags, options->methods);
  add_out_option(flags, options->out);
  flags
      .add_option("--plot", options->plot,
                  "draw these columns of the traces as DIR/SCENARIO/plot.svg; C1+C2: in one panel")
      .type_name("C1[,C2...]")
      .delimiter(',')
      .one_value();
  flags.add_flag("--quiet", options->quiet, "print neither table nor progress");
  flags.add_flag("--json", options->json, "print the summaries as JSON instead of the table");
  options->settings.attach(flags);
  return [options] { return run(*options); };
}

}  // namespace odeval::cli
