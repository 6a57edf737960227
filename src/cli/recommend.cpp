// odeval recommend: the cheapest settings that keep a budget, and the runs that prove it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <deque>
#include <iostream>
#include <optional>

#include "catalogue/accuracy.hpp"
#include "catalogue/grid_runs.hpp"
#include "catalogue/self_converged.hpp"
#include "catalogue/settings_search.hpp"
#include "catalogue/timing.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/impacts.hpp"
#include "output/number.hpp"
#include "output/recommendation.hpp"
#include "output/table.hpp"
#include "run/clock.hpp"
#include "run/pool.hpp"

namespace odeval::cli {
namespace {

/// A flag that allows so much of a quantity.
struct TargetFlag {
  quantity::Id id;
  std::string name;
  double at_most = 0;
  Flag flag{nullptr};  // knows whether it was typed
};

struct Options {
  std::string scenario;
  std::vector<std::string> methods;
  Settings settings;
  TargetFlag error{quantity::max_error_q, "--max-error"};  // of what the scenario has
  std::deque<TargetFlag> targets{};                        // stable addresses: the parser writes into them
  double until = 0;
  long most_steps = 1'000'000;
  int jobs = 1;
  std::string out = "results";
  bool quiet = false;
  bool json = false;
};

constexpr int timed_rounds = 5;
constexpr double least = 1e-15;
constexpr double greatest = 1e15;
constexpr double greatest_angle = 1;  // rad

double greatest_of(quantity::Id id) { return quantities[id].unit == "rad" ? greatest_angle : greatest; }

/// What may be asked for: every quantity of which less is better.
bool can_be_target(const Quantity& quantity) {
  return quantity.direction == Direction::less || quantity.direction == Direction::nearer_zero;
}

std::string flag_of(const Quantity& quantity) {
  std::string name = "--" + std::string(quantity.name);
  std::ranges::replace(name, '_', '-');
  return name;
}

/// One true motion, whatever the step.
void require_one_motion(const Options& options, const Scenario& scenario) {
  if (std::ranges::none_of(scenario.mechanism.joints, &Joint::sampled)) return;
  throw UserError(options.scenario + ": a controller of '" + scenario.name +
                  "' looks once a step, so that another step is another motion; give it sampling = \"continuous\", "
                  "or use 'odeval sweep'");
}

/// What `--max-error` is of: angles; without them attitudes of bodies on joints, positions of others.
quantity::Id error_of(const Scenario& scenario) {
  const bool joined = !scenario.mechanism.joints.empty() && scenario.mechanism.contacts.empty();
  return scenario.planar || joined ? catalogue::searched_error(scenario) : quantity::max_error_position;
}

/// The flags that were typed; that of `--max-error` for what the scenario has.
std::vector<const TargetFlag*> asked_for(Options& options, const Scenario& scenario) {
  std::vector<const TargetFlag*> asked;
  if (options.error.flag.given()) {
    options.error.id = error_of(scenario);
    if (options.error.at_most > greatest_of(options.error.id)) {
      throw UserError(fmt::format("{} {}: must be a number from {} to {}, of angles in rad", options.error.name,
                                  number_text(options.error.at_most), number_text(least), number_text(greatest_angle)));
    }
    asked.push_back(&options.error);
  }
  for (const TargetFlag& target : options.targets) {
    if (!target.flag.given()) continue;
    if (!asked.empty() && asked.front()->id == target.id) {
      throw UserError(target.name + ": is what " + asked.front()->name + " says already");
    }
    if (target.id == quantity::max_impact_error && !tells_impacts(scenario)) {
      throw UserError(fmt::format(
          "{} {}: has no meaning in '{}', since impacts are told of links at a wall and of a body on a ground, not of "
          "[[contacts]]; give --max-error E, of which an impact that comes late is a part",
          target.name, number_text(target.at_most), scenario.name));
    }
    asked.push_back(&target);
  }
  if (asked.empty()) {
    throw UserError(
        "--max-error E: is missing; give it, or another budget such as --max-energy-drift D ('odeval "
        "recommend --help' shows all)");
  }
  return asked;
}

/// What is asked for must have a value, and the reference must know it as well as asked.
void require_known(const std::vector<const TargetFlag*>& asked, const Scenario& scenario,
                   const std::vector<const catalogue::Method*>& methods) {
  catalogue::Evaluator evaluator(catalogue::with_enough_rows(scenario));
  if (!catalogue::mark_of(evaluator.reference()).empty()) {
    throw UserError(scenario.file + ": the reference is " + std::string(self_converged_origin) +
                    ", ODE's own limit, which is another motion at another step and ERP: nothing can be recommended by "
                    "it; 'odeval sweep' tells the error of each run against its own");
  }
  std::vector<const TargetFlag*> unseen = asked;
  for (const catalogue::Method* method : methods) {
    const catalogue::Evaluation run = evaluator.evaluate(*method);
    const Metrics metrics = evaluator.measure(run, evaluator.grid().time(evaluator.grid().rows - 1));
    for (const TargetFlag* target : unseen) {
      const double uncertainty = uncertainty_of(target->id, metrics).value_or(0);
      if (!metrics[target->id] || uncertainty <= target->at_most) continue;
      throw UserError(fmt::format(
          "{} {}: the reference of '{}' knows {} to {} {} until {} s; ask for more, or take a shorter --until",
          target->name, number_text(target->at_most), scenario.name, quantities[target->id].name,
          three_digits(uncertainty), quantities[target->id].unit, number_text(scenario.duration_s)));
    }
    std::erase_if(unseen, [&](const TargetFlag* target) { return metrics[target->id].has_value(); });
    if (unseen.empty()) return;
  }
  throw UserError(fmt::format("{}: no method has a value of {} in '{}' until {} s", unseen.front()->name,
                              quantities[unseen.front()->id].name, scenario.name, number_text(scenario.duration_s)));
}

/// Those asked for; else the scenario's own list, and all of ODE's and of the accurate step that can do it: whoever
/// asks for settings has not chosen a stepper. What has neither step nor tolerance has nothing to recommend.
std::vector<const catalogue::Method*> methods_of(const Options& options, const Scenario& scenario) {
  std::vector<const catalogue::Method*> methods = chosen_methods(options.methods, scenario);
  if (!options.methods.empty()) return methods;
  std::vector<const catalogue::Method*> all;
  for (const catalogue::Method& method : catalogue::methods()) {
    const bool listed = std::ranges::find(methods, &method) != methods.end();
    const bool of_ode = method.name.starts_with("ode-") && method.make != nullptr && catalogue::does(method, scenario);
    if (catalogue::knob_of(method) != catalogue::Knob::none && (listed || of_ode)) all.push_back(&method);
  }
  return all;
}

/// As a shell takes it for one word.
std::string in_shell(const std::string& word) {
  const auto plain = [](unsigned char letter) { return std::isalnum(letter) || std::strchr("_./=+-:,@%", letter); };
  if (!word.empty() && std::ranges::all_of(word, plain)) return word;
  std::string quoted = "'";
  for (const char letter : word) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
  return quoted + "'";
}

/// What has to be typed for that run.
std::string command_of(const Recommended& run, const catalogue::Method& method, const Options& options,
                       const Scenario& scenario) {
  std::string command = fmt::format("odeval run {} --method {} --duration {}", in_shell(options.scenario), run.method,
                                    number_text(options.until));
  if (run.knob == "step") command += " --step " + number_text(run.setting);
  if (run.knob == "rtol") {
    command += " --rtol " + number_text(run.setting);
    if (catalogue::has_setting(method, "atol")) {
      command += " --atol " + number_text(run.setting * catalogue::atol_over_rtol);
    }
  }
  if (scenario.sample_s) {  // which rows the file wants: every step counts
    command += " --sample " + number_text(run.knob == "step" ? run.setting : scenario.step_s);
  }
  for (const Change& change : run.changes) command += " " + as_flag(change.key, change.value);
  for (const Override& setting : options.settings.overrides()) {
    const bool another_engines =
        catalogue::is_engine_setting(setting.key) && !catalogue::has_setting(method, setting.key);
    if (another_engines) continue;
    command += setting.origin == "--set" ? " --set " + in_shell(setting.key + "=" + setting.value)
                                         : " " + setting.origin + " " + in_shell(setting.value);
  }
  // A folder of its own: what proves one answer has other settings than what proves the next.
  return command + " --out " + in_shell((std::filesystem::path(options.out) / "recommend" / run.method).string());
}

/// The searches, a method each, in worker processes. Returns the number of the signal that ended them early, or 0.
int search_all(catalogue::SettingsSearch& search, const std::vector<const catalogue::Method*>& methods,
               const Options& options, std::vector<Recommended>& found) {
  std::vector<run::Job> plan;
  for (std::size_t i = 0; i < methods.size(); ++i) plan.push_back({static_cast<std::uint32_t>(i)});
  const run::Work work{{}, [&](long job, long, std::string_view) {
                         return catalogue::packed(search.cheapest(*methods[static_cast<std::size_t>(job)]));
                       }};
  found.resize(methods.size());
  std::size_t done = 0;
  const auto take = [&](long job, const run::Result& result) {
    ++done;
    Recommended& run = found[static_cast<std::size_t>(job)];
    if (result.kind == run::Result::Kind::done) {
      run = catalogue::unpacked(result.text);
      return;
    }
    if (result.kind == run::Result::Kind::refused) throw UserError(result.text);
    run.method = methods[static_cast<std::size_t>(job)]->name;
    run.reached.resize(1);
    run.why_not = result.text;
  };
  Progress progress(methods.size(), options.quiet);
  const double begun_at_s = run::steady_seconds();
  run::PoolOptions pool;
  pool.processes = options.jobs;
  pool.passed = [&] {
    progress.show(
        fmt::format("[{}/{}] methods searched, {:.0f} s", done, methods.size(), run::steady_seconds() - begun_at_s));
  };
  return run_pool(work, plan, take, pool);
}

void time_them(std::vector<Recommended>& found, const std::vector<const catalogue::Method*>& methods,
               const catalogue::SettingsSearch& search, const Options& options) {
  std::deque<catalogue::Evaluator> evaluators;  // timed runs point at them
  std::vector<catalogue::TimedRun> runs;
  std::vector<Recommended*> timed;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].keeps()) continue;
    evaluators.emplace_back(search.scenario(*methods[i], found[i].changes, found[i].setting));
    runs.push_back({&evaluators.back(), methods[i], 0, 0, {}});
    timed.push_back(&found[i]);
  }
  Progress progress(timed_rounds + 1, options.quiet);
  catalogue::time_in_turns(runs, timed_rounds, [&](int) { progress.next("timing"); });
  for (std::size_t i = 0; i < runs.size(); ++i) {
    timed[i]->cpu_per_s = runs[i].median_s() / options.until;
    timed[i]->cpu_spread = runs[i].mad_s() / options.until;
  }
}

void sort_cheapest_first(std::vector<Recommended>& runs) {
  std::ranges::stable_sort(runs, [](const Recommended& a, const Recommended& b) {
    if (a.keeps() != b.keeps()) return a.keeps();
    if (a.keeps()) return a.cpu_per_s < b.cpu_per_s;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return a.reached.front().value.value_or(infinity) < b.reached.front().value.value_or(infinity);
  });
}

int recommend(Options& options) {
  refuse_searched(options.settings.overrides(), catalogue::searched_keys, "'odeval recommend'");
  const std::filesystem::path path = scenario_file(options.scenario);
  const ScenarioFile file(path, options.settings.import_options(path));
  tell_of_import(path);
  catalogue::Budget budget{{}, options.until, options.most_steps};
  const Scenario scenario = file.read(options.settings.overrides(), known_names());
  require_one_motion(options, scenario);
  const std::vector<const TargetFlag*> asked = asked_for(options, scenario);
  for (const TargetFlag* target : asked) budget.targets.push_back({target->id, target->at_most});
  const auto methods = methods_of(options, scenario);
  require_read(options.settings.overrides(), {{{scenario, methods}}});
  catalogue::SettingsSearch search(file, options.settings.overrides(), known_names(), budget);
  require_known(asked, search.scenario(), methods);

  Recommendation answer{scenario.name, options.until, budget.targets, {}};
  if (const int signal = search_all(search, methods, options, answer.runs); signal != 0) {
    std::cerr << fmt::format("odeval: stopped by {}; nothing was written\n", ::strsignal(signal));
    return 128 + signal;
  }
  time_them(answer.runs, methods, search, options);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    answer.runs[i].command = command_of(answer.runs[i], *methods[i], options, scenario);
  }
  sort_cheapest_first(answer.runs);
  const auto place = std::filesystem::path(options.out) / "recommend" / (scenario.name + ".csv");
  write_whole(place, recommendation_csv(answer));
  if (options.json) {
    std::cout << recommendation_json(answer);
  } else if (!options.quiet) {
    std::cout
        << recommendation_text(answer)
        << "\nErrors are over every step of a run as its command does it; CPU time of the stepping alone, methods "
           "in turn.\nwrote "
        << place.string() << '\n';
  }
  return answer.runs.front().keeps() ? 0 : 1;
}

}  // namespace

Action attach_recommend(Flags& flags) {
  const auto options = std::make_shared<Options>();
  const std::string budgets = "Budgets: what a run has to keep at every step, one or several";
  flags.add_option("SCENARIO", options->scenario, "a name ('odeval list') or a .toml file").required();
  options->error.flag = flags.add_option(
      options->error.name, options->error.at_most,
      "largest error against the reference: of angles or, of bodies on joints, attitudes (rad), else of positions (m)");
  options->error.flag.type_name("E").check(number_within(least, greatest)).group(budgets);
  for (const Quantity& quantity : quantities) {
    if (!can_be_target(quantity)) continue;
    TargetFlag& target = options->targets.emplace_back(TargetFlag{quantity.id, flag_of(quantity)});
    target.flag = flags.add_option(target.name, target.at_most, std::string(quantity.meaning));
    target.flag.type_name(std::string(quantity.unit))
        .check(number_within(least, greatest_of(quantity.id)))
        .group(budgets);
  }
  flags.add_option("--until", options->until, "end of the motion, s")
      .type_name("T")
      .required()
      .check(number_within(1e-3, 1e4));
  flags
      .add_option("--most-steps", options->most_steps,
                  "steps that a run of the search may take; all runs of a method together may take ten times as many")
      .type_name("N")
      .check(whole_within(100, 100'000'000))
      .capture_default_str();
  add_method_option(flags, options->methods);
  add_jobs_option(flags, options->jobs);
  add_out_option(flags, options->out);
  flags.add_flag("--quiet", options->quiet, "print neither answer nor progress");
  flags.add_flag("--json", options->json, "print the answers as JSON");
  options->settings.attach(flags);
  for (const std::string_view key : catalogue::searched_keys) {
    flags.hide("--" + std::string(key));  // read, so that the refusal can say why; no part of the help
  }
  return [options] { return recommend(*options); };
}

}  // namespace odeval::cli
