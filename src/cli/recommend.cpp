// odeval recommend: the cheapest settings that keep an error, and the runs that prove it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>
#include <optional>

#include "catalogue/accuracy.hpp"
#include "catalogue/timing.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/settings.hpp"
#include "odeval/error.hpp"
#include "odeval/metrics.hpp"
#include "output/csv_cell.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "output/summary.hpp"
#include "output/table.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::string scenario;
  std::vector<std::string> methods;
  Settings settings;
  double max_error = 0;
  double until = 0;
  double max_energy_drift = std::numeric_limits<double>::infinity();
  std::string out = "results";
  bool quiet = false;
};

constexpr long most_steps_of_a_search = 1'000'000;
constexpr int timed_rounds = 5;
constexpr double greatest_error = 1;  // rad
// The search keeps the error at its own rows, 0.05 s apart; the run has to keep it, and the energy, at every step. So
// the step, or rtol, is made smaller until it does: each time by the factor that the excess asks for, between these
// two.
constexpr int most_attempts = 24;
constexpr double finer = 0.93;
constexpr double farthest = 0.125;
constexpr long neighbours = 2;  // numbers of steps above an answer's that have to keep the budget as well
constexpr double grain = 0.02;  // between a step that keeps the budget and one that does not
constexpr double helps = 0.98;  // an excess that falls by less is no matter of the setting

/// A method with settings that were tried, as `odeval run` would do it.
struct Candidate {
  const catalogue::Method* method = nullptr;
  Start start = Start::as_given;
  std::optional<double> erp{};       // another than the scenario's
  double setting = 0;                // of its knob
  std::optional<double> sample_s{};  // where the scenario says which rows it wants: every step counts
  std::unique_ptr<catalogue::Evaluator> evaluator{};
  double error = std::numeric_limits<double>::infinity();
  double uncertainty = 0;
  double drift = std::numeric_limits<double>::infinity();
  long steps = 0;
  std::string suspect{};  // what ODE itself said of the run
  std::string why_not{};  // empty: it keeps the budget
  double median_s = 0;
  double mad_s = 0;
};

// Are searched as well, but for what was asked for.
constexpr std::string_view start_key = "ode.start";
constexpr std::string_view erp_key = "ode.erp";
constexpr std::array other_erps{0.05, 0.8};  // a fraction of the usual 0.2, and near the whole error in a step

bool is_asked_for(const Options& options, std::string_view key) {
  return std::ranges::any_of(options.settings.overrides(), [&](const Override& setting) { return setting.key == key; });
}
bool start_is_asked_for(const Options& options) { return is_asked_for(options, start_key); }

/// As a shell takes it for one word.
std::string in_shell(const std::string& word) {
  const auto plain = [](unsigned char letter) { return std::isalnum(letter) || std::strchr("_./=+-:,@%", letter); };
  if (!word.empty() && std::ranges::all_of(word, plain)) return word;
  std::string quoted = "'";
  for (const char letter : word) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
  return quoted + "'";
}

/// What has to be typed for that run.
std::string command_of(const Candidate& candidate, const Options& options) {
  std::string command = fmt::format("odeval run {} --method {} --duration {}", in_shell(options.scenario),
                                    candidate.method->name, number_text(options.until));
  switch (catalogue::knob_of(*candidate.method)) {
    case catalogue::Knob::step:
      command += " --step " + number_text(candidate.setting);
      break;
    case catalogue::Knob::rtol:
      command += " --rtol " + number_text(candidate.setting);
      if (catalogue::has_setting(*candidate.method, "atol")) {
        command += " --atol " + number_text(candidate.setting * catalogue::atol_over_rtol);
      }
      break;
    case catalogue::Knob::none:
      break;
  }
  if (candidate.sample_s) command += " --sample " + number_text(*candidate.sample_s);
  if (candidate.start == Start::half_step) {
    command += " --start half-step";
  } else if (start_is_asked_for(options) && catalogue::has_half_step_start(*candidate.method)) {
    command += " --start as-given";
  }
  if (candidate.erp) command += " --erp " + number_text(*candidate.erp);
  for (const Override& setting : options.settings.overrides()) {
    const bool another_engines =
        catalogue::is_engine_setting(setting.key) && !catalogue::has_setting(*candidate.method, setting.key);
    if (setting.key == start_key || another_engines) continue;
    command += setting.origin == "--set" ? " --set " + in_shell(setting.key + "=" + setting.value)
                                         : " " + setting.origin + " " + in_shell(setting.value);
  }
  return command;
}

class Search {
 public:
  Search(const Options& options, Scenario scenario) : options_(options), scenario_(std::move(scenario)) {}

  Candidate cheapest(const catalogue::Method& method, Start start, std::optional<double> erp = {}) const {
    Candidate candidate;
    candidate.method = &method;
    candidate.start = start;
    candidate.erp = erp;
    Scenario scenario = scenario_;
    scenario.ode.start = start;
    scenario.ode.erp = erp.value_or(scenario.ode.erp);
    const catalogue::Accuracy accuracy(scenario, options_.until);
    const catalogue::Search found = accuracy.cheapest(method, options_.max_error, most_steps_of_a_search);
    if (!found.reached) {
      candidate.setting = found.trial.setting;
      candidate.error = found.trial.error;
      candidate.uncertainty = found.trial.uncertainty;
      candidate.steps = found.trial.steps;
      candidate.why_not = found.why_not;
      return candidate;
    }
    // The search looked at rows 0.05 s apart; what counts is the run as the user will have it.
    candidate.setting = found.trial.setting;
    double excess_before = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
      run(candidate, scenario);
      if (keeps(candidate)) {
        if (!scenario.planar) return candidate;  // the reference of each further step costs more than the step gains
        return steadied(coarsest(std::move(candidate), scenario, accuracy.row_spacing_s()), scenario);
      }
      const double excess = excess_of(candidate);
      const double factor = finer_by(method, excess);
      if (factor == 1 || !(excess < helps * excess_before)) break;
      if (catalogue::knob_of(method) == catalogue::Knob::step &&
          options_.until / (candidate.setting * factor) > static_cast<double>(most_steps_of_a_search)) {
        candidate.why_not = fmt::format(" in up to {} steps", most_steps_of_a_search);
        break;
      }
      candidate.setting *= factor;
      excess_before = excess;
    }
    if (!candidate.suspect.empty()) {
      candidate.why_not = "suspect: " + candidate.suspect;
      return candidate;
    }
    candidate.why_not =
        (candidate.error + candidate.uncertainty > options_.max_error ? "the error between the rows is larger"
                                                                      : "the energy drifts more") +
        candidate.why_not;
    return candidate;
  }

 private:
  long steps_of(const Candidate& candidate) const {
    return std::lround(std::ceil(options_.until / candidate.setting * (1 - 1e-12)));
  }

  /// The same method from the same start in another number of steps.
  Candidate in_steps(long number, const Candidate& like, const Scenario& scenario) const {
    Candidate candidate;
    candidate.method = like.method;
    candidate.start = like.start;
    candidate.erp = like.erp;
    candidate.setting = options_.until / static_cast<double>(number);
    run(candidate, scenario);
    return candidate;
  }

  /// Where rounding decides, or a motion is nearly lost, one step of many may keep the budget by luck. An answer has to
  /// keep it with a step or two more as well: else a finer one is looked for.
  Candidate steadied(Candidate kept, const Scenario& scenario) const {
    if (catalogue::knob_of(*kept.method) != catalogue::Knob::step) return kept;
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
      const long number = steps_of(kept);
      bool steady = keeps(kept);
      for (long more = 1; more <= neighbours && steady; ++more) steady = keeps(in_steps(number + more, kept, scenario));
      if (steady) return kept;
      const long finer_steps = std::lround(std::ceil(static_cast<double>(number) / finer));
      if (finer_steps > most_steps_of_a_search) break;
      kept = in_steps(finer_steps, kept, scenario);
    }
    kept.why_not = "some number of steps keeps it, one or two steps more do not";
    return kept;
  }

  /// The search knows few large steps, those that fit its rows: between them, and above, by whole numbers of steps.
  Candidate coarsest(Candidate kept, const Scenario& scenario, double row_spacing_s) const {
    const bool steps = catalogue::knob_of(*kept.method) == catalogue::Knob::step;
    if (!steps || kept.setting < grain * row_spacing_s) return kept;
    const auto with_steps = [&](long number) { return in_steps(number, kept, scenario); };
    long enough = steps_of(kept);
    long too_few = 0;
    for (long fewer = enough / 2; fewer > 0; fewer /= 2) {
      Candidate candidate = with_steps(fewer);
      if (!keeps(candidate)) {
        too_few = fewer;
        break;
      }
      kept = std::move(candidate);
      enough = fewer;
    }
    while (enough - too_few > std::max(1L, std::lround(grain * static_cast<double>(enough)))) {
      const long middle = (enough + too_few) / 2;
      Candidate candidate = with_steps(middle);
      if (keeps(candidate)) {
        kept = std::move(candidate);
        enough = middle;
      } else {
        too_few = middle;
      }
    }
    return kept;
  }

  void run(Candidate& candidate, Scenario scenario) const {
    scenario.duration_s = options_.until;
    scenario.tolerances.clear();
    switch (catalogue::knob_of(*candidate.method)) {
      case catalogue::Knob::step:
        scenario.step_s = candidate.setting;
        break;
      case catalogue::Knob::rtol:
        scenario.rtol = candidate.setting;
        scenario.atol = candidate.setting * catalogue::atol_over_rtol;
        break;
      case catalogue::Knob::none:
        break;
    }
    if (scenario.sample_s) scenario.sample_s = candidate.sample_s = scenario.step_s;
    candidate.evaluator = std::make_unique<catalogue::Evaluator>(std::move(scenario));
    const catalogue::Evaluation done = candidate.evaluator->evaluate(*candidate.method);
    const SampleGrid& rows = candidate.evaluator->grid();
    const Metrics metrics = candidate.evaluator->measure(done, rows.time(rows.rows - 1));
    const quantity::Id error = catalogue::searched_error(scenario_);
    candidate.error = metrics[error].value_or(std::numeric_limits<double>::infinity());
    candidate.uncertainty = uncertainty_of(error, metrics).value_or(0);
    candidate.drift = *metrics[quantity::max_energy_drift];
    candidate.steps = done.outcome.steps;
    candidate.suspect = suspicion(done.outcome);
  }

  bool keeps(const Candidate& candidate) const {
    return candidate.suspect.empty() && candidate.error + candidate.uncertainty <= options_.max_error &&
           candidate.drift <= options_.max_energy_drift;
  }

  /// How many times the budget.
  double excess_of(const Candidate& candidate) const {
    return std::max((candidate.error + candidate.uncertainty) / options_.max_error,
                    candidate.drift / options_.max_energy_drift);
  }

  /// What to multiply the setting by, going by the method's order; 1 where it has none.
  static double finer_by(const catalogue::Method& method, double excess) {
    switch (catalogue::knob_of(method)) {
      case catalogue::Knob::step:
        return std::clamp(finer * std::pow(excess, -1.0 / method.order), farthest, finer);
      case catalogue::Knob::rtol:
        return std::clamp(finer / excess, farthest, finer);
      case catalogue::Knob::none:
        break;
    }
    return 1;
  }

  const Options& options_;
  Scenario scenario_;
};

void time_them(std::vector<Candidate>& candidates, Progress& progress) {
  std::vector<catalogue::TimedRun> runs;
  std::vector<Candidate*> timed;
  for (Candidate& candidate : candidates) {
    if (!candidate.why_not.empty()) continue;
    runs.push_back({candidate.evaluator.get(), candidate.method, 0, 0, {}});
    timed.push_back(&candidate);
  }
  progress.next("timing");
  catalogue::time_in_turns(runs, timed_rounds);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    timed[i]->median_s = runs[i].median_s();
    timed[i]->mad_s = runs[i].mad_s();
  }
}

std::string setting_text(const Candidate& candidate) {
  const std::string knob(knob_name(catalogue::knob_of(*candidate.method)));
  std::string text = knob.empty() ? "-" : knob + " = " + three_digits(candidate.setting);
  if (candidate.start == Start::half_step) text += ", half-step start";
  if (candidate.erp) text += ", ERP " + number_text(*candidate.erp);
  return text;
}

std::string table_csv(const std::vector<Candidate>& candidates, const Options& options, quantity::Id error) {
  std::string text = fmt::format("method,start,knob,setting,{},{},{},steps,median_s,mad_s,keeps,why_not,command\n",
                                 quantities[error].name, quantities[*quantities[error].uncertainty].name,
                                 quantities[quantity::max_energy_drift].name);
  for (const Candidate& candidate : candidates) {
    const bool keeps = candidate.why_not.empty();
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", candidate.method->name,
                        candidate.start == Start::half_step ? "half-step" : "as-given",
                        knob_name(catalogue::knob_of(*candidate.method)), number_text(candidate.setting),
                        number_text(candidate.error), number_text(candidate.uncertainty), number_text(candidate.drift),
                        candidate.steps, keeps ? number_text(candidate.median_s) : "",
                        keeps ? number_text(candidate.mad_s) : "", keeps ? 1 : 0, csv_cell(candidate.why_not),
                        csv_cell(command_of(candidate, options)));
  }
  return text;
}

/// Angles of pendulums, attitudes of other bodies; one true motion, whatever the step.
void require_angles(const Options& options, const Scenario& scenario) {
  if (scenario.planar) return;
  const Mechanism& mechanism = scenario.mechanism;
  if (mechanism.joints.empty() || !mechanism.contacts.empty()) {
    throw UserError(options.scenario + ": errors are looked for in angles, and scenario '" + scenario.name +
                    "' has none; 'odeval sweep' takes any error");
  }
  if (std::ranges::none_of(mechanism.joints, &Joint::sampled)) return;
  throw UserError(options.scenario + ": a controller of '" + scenario.name +
                  "' looks once a step, so that another step is another motion; give it sampling = \"continuous\", "
                  "or use 'odeval sweep'");
}

/// Throws UserError where the reference does not know the angles as well as asked.
void require_known(const Options& options, const Scenario& scenario) {
  const double uncertainty = catalogue::Accuracy(scenario, options.until).uncertainty();
  if (uncertainty <= options.max_error) return;
  throw UserError(fmt::format(
      "--max-error {}: the reference of '{}' knows the angles to {} rad until {} s; {}take a shorter --until",
      number_text(options.max_error), scenario.name, three_digits(uncertainty), number_text(options.until),
      uncertainty < greatest_error ? "ask for more, or " : ""));
}

/// What keeps the budget, cheapest first; then what does not, nearest first.
std::vector<Candidate> find_candidates(const Options& options, const Scenario& scenario,
                                       const std::vector<const catalogue::Method*>& methods) {
  std::vector<Candidate> candidates;
  Progress progress(methods.size() + 1, options.quiet);
  const Search search(options, scenario);
  for (const catalogue::Method* method : methods) {
    progress.next(scenario.name + " " + std::string(method->name));
    const bool has_start = catalogue::has_half_step_start(*method);
    candidates.push_back(search.cheapest(*method, has_start ? scenario.ode.start : Start::as_given));
    if (has_start && !start_is_asked_for(options) && scenario.ode.start != Start::half_step) {
      candidates.push_back(search.cheapest(*method, Start::half_step));
    }
    // ERP counts as much as the step where joints are not those of a plane.
    if (scenario.planar || !catalogue::reads(*method, erp_key, scenario) || is_asked_for(options, erp_key)) continue;
    for (const double erp : other_erps) {
      candidates.push_back(search.cheapest(*method, has_start ? scenario.ode.start : Start::as_given, erp));
    }
  }
  time_them(candidates, progress);
  std::ranges::stable_sort(candidates, [](const Candidate& a, const Candidate& b) {
    if (a.why_not.empty() != b.why_not.empty()) return a.why_not.empty();
    return a.why_not.empty() ? a.median_s < b.median_s : a.error < b.error;
  });
  return candidates;
}

std::string budget_of(const Options& options) {
  const std::string drift =
      std::isfinite(options.max_energy_drift)
          ? fmt::format(" and an energy drift of at most {} J", number_text(options.max_energy_drift))
          : "";
  return fmt::format("an error of at most {} rad{} until {} s", number_text(options.max_error), drift,
                     number_text(options.until));
}

std::string candidates_table(const std::vector<Candidate>& candidates) {
  TextTable table("llrrrrrl", {"method", "setting", "error, rad", "drift, J", "steps", "median, ms", "±", ""});
  for (const Candidate& c : candidates) {
    const bool keeps = c.why_not.empty();
    table.add({std::string(c.method->name), setting_text(c), with_uncertainty(c.error, c.uncertainty),
               std::isfinite(c.drift) ? three_digits(c.drift) : "-", std::to_string(c.steps),
               keeps ? three_digits(1e3 * c.median_s) : "-", keeps ? three_digits(1e3 * c.mad_s) : "-",
               keeps ? "" : "no: " + c.why_not});
  }
  return table.text();
}

/// The commands that prove the cheapest of all, and the cheapest that ODE has.
std::string proofs(const std::vector<Candidate>& candidates, const Options& options) {
  if (!candidates.front().why_not.empty()) return "none does\n";
  std::string text = "cheapest:      " + command_of(candidates.front(), options) + '\n';
  const auto engine = std::ranges::find_if(
      candidates, [](const Candidate& c) { return c.why_not.empty() && c.method->name.starts_with("ode-"); });
  if (engine != candidates.end() && engine != candidates.begin()) {
    text += "cheapest ODE:  " + command_of(*engine, options) + '\n';
  }
  return text;
}

int recommend(const Options& options) {
  refuse_searched(options.settings.overrides(), catalogue::searched_keys, "'odeval recommend'");
  const Scenario scenario = options.settings.read(options.scenario);
  require_angles(options, scenario);
  const auto methods = chosen_methods(options.methods, scenario);
  require_read(options.settings.overrides(), {{{scenario, methods}}});
  require_known(options, scenario);

  const std::vector<Candidate> candidates = find_candidates(options, scenario, methods);
  const auto file = std::filesystem::path(options.out) / "recommend" / (scenario.name + ".csv");
  write_whole(file, table_csv(candidates, options, catalogue::searched_error(scenario)));
  if (!options.quiet) {
    std::cout << scenario.name << ": what keeps " << budget_of(options) << ", cheapest first\n\n"
              << candidates_table(candidates) << '\n'
              << proofs(candidates, options)
              << "\nErrors are over every step of a run as the command does it; CPU time of the stepping alone, "
                 "methods in turn.\nwrote "
              << file.string() << '\n';
  }
  return candidates.front().why_not.empty() ? 0 : 1;
}

}  // namespace

Action attach_recommend(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("SCENARIO", options->scenario, "a name ('odeval list') or a .toml file").required();
  flags
      .add_option("--max-error", options->max_error,
                  "largest error allowed of an angle or, of bodies in space, of an attitude, rad")
      .type_name("E")
      .required()
      .check(number_within(1e-15, greatest_error));
  flags.add_option("--until", options->until, "until when, s")
      .type_name("T")
      .required()
      .check(number_within(1e-3, 1e4));
  const Quantity& drift = quantities[quantity::max_energy_drift];
  flags.add_option("--max-energy-drift", options->max_energy_drift, fmt::format("{}, {}", drift.meaning, drift.unit))
      .type_name("D")
      .check(number_within(1e-15, 1e15));
  add_method_option(flags, options->methods);
  add_out_option(flags, options->out);
  flags.add_flag("--quiet", options->quiet, "no table, no progress");
  options->settings.attach(flags);
  for (const std::string_view key : catalogue::searched_keys) {
    flags.hide("--" + std::string(key));  // read, so that the refusal can say why; no part of the help
  }
  return [options] { return recommend(*options); };
}

}  // namespace odeval::cli
