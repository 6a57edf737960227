// odeval run: one scenario in several methods: traces, summaries, a table.
#include <iostream>

#include "catalogue/evaluation.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/run_files.hpp"
#include "cli/settings.hpp"
#include "output/run_report.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::string scenario;
  std::vector<std::string> methods;
  Settings settings;
  std::string out = "results";
  bool quiet = false;
  bool json = false;
};

int run(const Options& options) {
  const Scenario scenario = options.settings.read(options.scenario);
  const auto methods = chosen_methods(options.methods, scenario);
  require_read(options.settings.overrides(), {{{scenario, methods}}});
  catalogue::Evaluator evaluator(scenario);
  const std::filesystem::path folder = std::filesystem::path(options.out) / scenario.name;

  std::vector<RunSummary> summaries;
  std::vector<double> ns_per_step;
  bool diverged = false;
  {
    Progress progress(methods.size(), options.quiet);
    for (const catalogue::Method* method : methods) {
      progress.next(scenario.name + " " + std::string(method->name));
      const catalogue::Evaluation run = evaluator.evaluate(*method);
      summaries.push_back(write_run(run, evaluator, folder));
      ns_per_step.push_back(1e9 * run.cpu_s / static_cast<double>(std::max(run.outcome.steps, 1L)));
      diverged = diverged || run.outcome.diverged;
    }
  }
  write_summaries(summaries, folder);

  if (options.json) {
    std::cout << summaries_json(summaries);
  } else if (!options.quiet) {
    std::cout << run_report(summaries, ns_per_step, evaluator.reference()) << "\nwrote " << folder.string() << "/\n";
  }
  return diverged ? 1 : 0;
}

}  // namespace

Action attach_run(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("SCENARIO", options->scenario, "a name ('odeval list') or a .toml file").required();
  add_method_option(flags, options->methods);
  add_out_option(flags, options->out);
  flags.add_flag("--quiet", options->quiet, "no table, no progress");
  flags.add_flag("--json", options->json, "summaries for programs instead of the table");
  options->settings.attach(flags);
  return [options] { return run(*options); };
}

}  // namespace odeval::cli
