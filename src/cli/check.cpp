// odeval check: holds every tolerance of the scenario files against a fresh measurement.
#include "cli/check.hpp"

#include <algorithm>
#include <iostream>
#include <map>

#include "catalogue/evaluation.hpp"
#include "catalogue/self_converged.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/settings.hpp"
#include "measure/metrics.hpp"
#include "odeval/error.hpp"
#include "output/summary.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::vector<std::string> scenarios;
  Settings settings;
  bool quiet = false;
  bool json = false;
};

CheckRow::Verdict verdict_of(Judgement judgement) {
  switch (judgement) {
    case Judgement::kept:
      return CheckRow::Verdict::kept;
    case Judgement::undecided:
      return CheckRow::Verdict::undecided;
    case Judgement::failed:
      break;
  }
  return CheckRow::Verdict::failed;
}

/// The quantities that a run has, for a message.
std::string had(const Metrics& metrics) {
  std::string names;
  for (const Quantity& row : quantities) {
    if (!metrics[row.id] || row.scope == Scope::reference) continue;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  return names;
}

/// A metric that no run of the scenario has is a mistake of its file, and no tolerance that failed.
void require_value(const Scenario& scenario, const Tolerance& tolerance, const Metrics& metrics) {
  if (judged_value(tolerance, metrics)) return;
  const Quantity& row = *quantity_named(tolerance.metric);
  const bool in_scope = row.scope != Scope::coordinate || compared(metrics, Scope::coordinate);
  if (in_scope && may_be_missing(row.id)) return;
  const auto number = &tolerance - scenario.tolerances.data();
  throw UserError(scenario.file + ": tolerances." + std::to_string(number) + ".metric = \"" + tolerance.metric +
                  "\": '" + scenario.name + "' has no such quantity in " + tolerance.method + ", which has " +
                  had(metrics));
}

CheckRow check_one(const Tolerance& tolerance, const catalogue::Method& method, catalogue::Evaluator& evaluator,
                   const RunOf& run_of) {
  const Scenario& scenario = evaluator.scenario();
  CheckRow row{scenario.name, tolerance, {}, {}, CheckRow::Verdict::left_out, {}, {}};
  if (method.make == nullptr) return row;
  catalogue::require_does(method, scenario, scenario.file + ": tolerances");
  const catalogue::Evaluation& run = run_of(method);
  const Metrics metrics = evaluator.measure(run, tolerance.until_s);
  require_value(scenario, tolerance, metrics);
  row.measured = judged_value(tolerance, metrics);
  row.reference_uncertainty = uncertainty_of(tolerance, metrics);
  row.verdict = verdict_of(judge(tolerance, metrics));
  row.reference = catalogue::mark_of(evaluator.reference());
  // What ODE's own limit leaves open the reference of trees may decide, which a build without Simbody lacks.
  const auto& of_trees = *std::ranges::find(catalogue::methods(), "mechanism-cvode", &catalogue::Method::name);
  const bool open = row.verdict == CheckRow::Verdict::undecided && !row.reference.empty();
  if (open && of_trees.make == nullptr) row.verdict = CheckRow::Verdict::left_out;
  row.suspect = suspicion(run.outcome);
  return row;
}

std::vector<const catalogue::Method*> methods_of_tolerances(const Scenario& scenario) {
  std::vector<const catalogue::Method*> methods;
  for (const catalogue::Method& method : catalogue::methods()) {
    if (std::ranges::find(scenario.tolerances, method.name, &Tolerance::method) == scenario.tolerances.end()) continue;
    methods.push_back(&method);
  }
  return methods;
}

int check(const Options& options) {
  std::vector<Scenario> scenarios;
  const auto names = options.scenarios.empty() ? shipped_scenarios() : options.scenarios;
  std::vector<Chosen> chosen;
  for (const std::string& name : names) {
    scenarios.push_back(options.settings.read(name));
    if (scenarios.back().tolerances.empty()) {
      throw UserError(scenarios.back().file +
                      ": tolerances: 0 tables; must be one table [[tolerances]] at least, for 'check' to hold it "
                      "against a run");
    }
    chosen.push_back({scenarios.back(), methods_of_tolerances(scenarios.back())});
  }
  require_read(options.settings.overrides(), chosen);

  std::vector<CheckRow> rows;
  {
    Progress progress(scenarios.size(), options.quiet);
    for (const Scenario& scenario : scenarios) {
      progress.next(scenario.name);
      const auto checked = check_scenario(scenario);
      rows.insert(rows.end(), checked.begin(), checked.end());
    }
  }
  if (options.json) {
    std::cout << checks_json(rows);
  } else if (!options.quiet) {
    std::cout << checks_table(rows);
  }
  return status_of(rows);
}

}  // namespace

std::vector<CheckRow> check_runs(catalogue::Evaluator& evaluator, const RunOf& run_of) {
  std::vector<CheckRow> rows;
  for (const Tolerance& tolerance : evaluator.scenario().tolerances) {
    const auto& method = *std::ranges::find(catalogue::methods(), tolerance.method, &catalogue::Method::name);
    rows.push_back(check_one(tolerance, method, evaluator, run_of));
  }
  return rows;
}

std::vector<CheckRow> check_scenario(Scenario scenario) {
  for (const Tolerance& tolerance : scenario.tolerances) {
    scenario.duration_s = std::max(scenario.duration_s, tolerance.until_s);
  }
  catalogue::Evaluator evaluator(std::move(scenario));
  std::map<std::string_view, catalogue::Evaluation> runs;
  return check_runs(evaluator, [&](const catalogue::Method& method) -> const catalogue::Evaluation& {
    const auto found = runs.find(method.name);
    return found != runs.end() ? found->second : runs.emplace(method.name, evaluator.evaluate(method)).first->second;
  });
}

int status_of(std::span<const CheckRow> rows) {
  const bool failed = std::ranges::any_of(rows, [](const CheckRow& row) {
    return row.verdict == CheckRow::Verdict::failed || row.verdict == CheckRow::Verdict::undecided;
  });
  return failed ? 1 : 0;
}

Action attach_check(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("SCENARIO", options->scenarios, "names or .toml files; default: all that come with the program");
  flags.add_flag("--quiet", options->quiet, "print nothing; the exit status tells");
  flags.add_flag("--json", options->json, "print JSON");
  options->settings.attach(flags);
  return [options] { return check(*options); };
}

}  // namespace odeval::cli
