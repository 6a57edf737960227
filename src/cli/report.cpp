// odeval report: every scenario and every experiment, and the verdicts on the claims, as one page.
#include "cli/report.hpp"

#include <algorithm>
#include <iostream>
#include <thread>

#include "catalogue/paths.hpp"
#include "catalogue/self_converged.hpp"
#include "catalogue/versions.hpp"
#include "cli/bench.hpp"
#include "cli/check.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/run_files.hpp"
#include "cli/settings.hpp"
#include "experiments/experiment.hpp"
#include "experiments/highlights.hpp"
#include "experiments/side_by_side.hpp"
#include "model/find_scenario.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "render/painter.hpp"
#include "report/files.hpp"
#include "report/gnuplot.hpp"
#include "report/page.hpp"
#include "report/releases.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;
using experiments::Laboratory;

struct Runs {
  std::vector<report::Files> files;
  bool diverged = false;
};

/// Every scenario in its own methods, as `odeval run` does it.
Runs run_scenarios(Laboratory& laboratory, const ReportOptions& options) {
  struct Pair {
    std::string scenario;
    const catalogue::Method* method;
  };
  std::vector<Pair> plan;
  const std::vector<std::string> names = shipped_scenarios();
  std::map<std::string, ResultFolder> folders;
  for (const std::string& name : names) {
    const auto methods = chosen_methods({}, laboratory.scenario(name));
    for (const catalogue::Method* method : methods) plan.push_back({name, method});
    const fs::path place = fs::path(options.out) / name;
    folders.try_emplace(name, place);
    const std::string other = results_of_another_run(place, laboratory.scenario(name), methods);
    if (!other.empty()) {
      std::cerr << "odeval: " << place.string() << " holds results of " << other << ", which are no part of the page\n";
    }
  }

  Runs runs;
  std::map<std::string, std::vector<RunSummary>> summaries;
  Progress progress(plan.size(), options.quiet);
  for (const auto& [scenario, method] : plan) {
    progress.next(scenario + " " + std::string(method->name));
    const catalogue::Evaluation& run = *laboratory.run(scenario, method->name);
    summaries[scenario].push_back(folders.at(scenario).write(run, laboratory.evaluator(scenario)));
    runs.diverged = runs.diverged || run.outcome.diverged;
  }
  for (const std::string& name : names) {
    folders.at(name).write_summaries(summaries[name]);
    report::Files traces{name + ", trace of every method", {}};
    report::Files settings{name + ", settings, versions and metrics of every run", {}};
    std::string suspects;
    for (const RunSummary& summary : summaries[name]) {
      const std::string stem = name + "/" + summary.method;
      traces.paths.push_back(stem + ".csv");
      settings.paths.push_back(stem + ".json");
      if (const std::string why = suspicion(summary.outcome); !why.empty()) {
        suspects += (suspects.empty() ? "; suspect: " : ", ") + summary.method + ", " + why;
      }
    }
    settings.about += suspects;
    const std::string_view mark = catalogue::mark_of(laboratory.evaluator(name).reference());
    const std::string against = mark.empty() ? "" : " (" + std::string(mark) + ": against ODE's own limit)";
    runs.files.push_back({name + ", errors" + against + ", energy drift and impacts", {name + "/summary.csv"}});
    runs.files.push_back(std::move(traces));
    runs.files.push_back(std::move(settings));
  }
  return runs;
}

/// What `odeval check` holds, against the runs of the page where they last long enough.
std::vector<CheckRow> check_tolerances(Laboratory& laboratory) {
  std::vector<CheckRow> all;
  for (const std::string& name : shipped_scenarios()) {
    const Scenario& scenario = laboratory.scenario(name);
    const bool longer = std::ranges::any_of(
        scenario.tolerances, [&](const Tolerance& tolerance) { return tolerance.until_s > scenario.duration_s; });
    const auto run_of = [&](const catalogue::Method& method) -> const catalogue::Evaluation& {
      return *laboratory.run(name, method.name);
    };
    for (CheckRow& row : longer ? check_scenario(scenario) : check_runs(laboratory.evaluator(name), run_of)) {
      all.push_back(std::move(row));
    }
  }
  return all;
}

/// Every experiment, side by side on the machine's cores.
std::vector<report::Section> run_experiments(Laboratory& laboratory, report::Findings& findings, bool quiet,
                                             std::vector<std::string>& failures) {
  Progress progress(experiments::experiments().size(), quiet);
  const auto finished = [&](const experiments::Experiment& experiment) {
    progress.next("experiment " + std::string(experiment.name));
  };
  std::vector<report::Section> sections;
  for (report::Outcome& outcome : experiments::run_side_by_side(experiments::experiments(), laboratory,
                                                                std::thread::hardware_concurrency(), finished)) {
    sections.push_back(std::move(outcome.section));
    for (auto& [name, finding] : outcome.findings) findings.add(name, std::move(finding));
    failures.insert(failures.end(), outcome.failures.begin(), outcome.failures.end());
  }
  return sections;
}

std::vector<std::pair<std::string, std::string>> environment() {
  auto all = catalogue::versions();
  for (const auto& engine : catalogue::engine_versions()) all.push_back(engine);
  all.emplace_back("figures", report::gnuplot_version());
  all.emplace_back("pictures", "OpenGL " + render::opengl_version());
  for (const auto& part : catalogue::machine()) all.push_back(part);
  return all;
}

void write_tables(const std::vector<report::Section>& sections, const fs::path& folder) {
  for (const report::Section& section : sections) {
    for (const report::Block& block : section.blocks) {
      const auto* const table = std::get_if<report::Table>(&block);
      if (table != nullptr) write_whole(folder / report::csv_of(*table), report::table_csv(*table));
    }
  }
}

/// This build's ODE, as summaries name it.
std::string own_release() {
  for (const auto& [name, version] : catalogue::versions()) {
    if (name == "ode_double") return version;
  }
  return "";
}

}  // namespace

int report(const ReportOptions& options, const SeePage& seen) {
  const fs::path folder(options.out);
  std::optional<fs::path> other;
  if (!options.releases.empty()) report::require_other_release(other.emplace(options.releases), own_release());
  Laboratory laboratory([](const std::string& name) {
    return read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, known_names());
  });
  Runs runs = run_scenarios(laboratory, options);
  const std::vector<CheckRow> checks = options.check ? check_tolerances(laboratory) : std::vector<CheckRow>{};
  if (options.check && !options.quiet) std::cout << checks_table(checks) << '\n' << std::flush;
  BenchOptions timing;
  timing.out = options.out;
  timing.quiet = true;
  timing.enough_s = 1;  // some references take many
  bench(timing);
  runs.files.push_back({"what a step costs, in every scenario and method", {"timing.csv", "timing.json"}});

  std::vector<std::string> failures;
  report::Findings findings;
  report::Document document;
  document.sections = run_experiments(laboratory, findings, options.quiet, failures);
  document.sections.push_back(report::releases_section(folder, other, own_release()));
  document.front = experiments::front_of(document.sections, findings);
  document.files = std::move(runs.files);
  document.command = "odeval report --out " + options.out;
  document.environment = environment();
  if (seen) seen(document, findings);
  std::vector<report::Judged> verdicts;
  for (const report::Claim& claim : report::claims()) verdicts.push_back(report::judge(claim, findings));

  const report::Page page = report::make_page(document, verdicts, findings);
  write_tables(document.front, folder);
  write_tables(document.sections, folder);
  write_whole(folder / "report" / "findings.csv", report::findings_csv(findings));
  write_whole(folder / "report" / "verdicts.csv", report::verdicts_csv(verdicts, findings));
  write_whole(folder / "index.html", page.html);

  failures.insert(failures.end(), page.missing.begin(), page.missing.end());
  for (const std::string& failure : failures) std::cerr << "odeval: the page lacks " << failure << '\n';
  if (!options.quiet) std::cout << "wrote " << (folder / "index.html").string() << '\n';
  if (!failures.empty()) return 3;
  return options.check ? status_of(checks) : (runs.diverged ? 1 : 0);
}

Action attach_report(Flags& flags) {
  const auto options = std::make_shared<ReportOptions>();
  add_out_option(flags, options->out);
  flags
      .add_option("--releases", options->releases,
                  "what another release of ODE changes: the folder that its build's report or run wrote")
      .type_name("DIR");
  flags.add_flag("--check", options->check,
                 "hold the scenarios' tolerances against the same runs, as 'odeval check' does; exit status 1 if one "
                 "fails, and not where a run diverged");
  flags.add_flag("--quiet", options->quiet, "print neither progress nor the name of the page");
  return [options] { return report(*options); };
}

}  // namespace odeval::cli
