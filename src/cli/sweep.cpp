// odeval sweep: a grid of settings in every method, in worker processes, with a journal that survives all of them.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iostream>

#include "catalogue/grid_runs.hpp"
#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/progress.hpp"
#include "cli/settings.hpp"
#include "cli/sweep_answer.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/sweep_table.hpp"
#include "run/clock.hpp"
#include "run/sweep.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string scenario;
  std::vector<std::string> grids;
  std::vector<std::string> methods;
  Settings settings;
  int jobs = 1;
  std::string shard = "1/1";
  double timeout_s = 3600;
  std::string out = "results";
  AnswerOptions answer;
};

bool is_whole_key(const std::string& key) {
  return std::ranges::any_of(key_table(), [&](const KeyRow& row) {
    return row.kind == KeyKind::whole &&
           key == (row.section.empty() ? "" : std::string(row.section) + ".") + std::string(row.name);
  });
}

std::vector<sweep::Axis> axes_of(const Options& options, const std::vector<Override>& settings) {
  std::vector<sweep::Axis> axes;
  for (const std::string& text : options.grids) {
    axes.push_back(sweep::parse_axis(text, is_whole_key));
    const std::string& key = axes.back().key;
    if (key == "method" || key == "methods") {
      throw UserError("--grid " + key + ": give the methods by --method M[,M...]");
    }
    if (key.starts_with("tolerances")) throw UserError("--grid " + key + ": has no meaning for a run");
    const auto same =
        std::ranges::find_if(settings, [&](const Override& setting) { return overlap(setting.key, key); });
    if (same != settings.end()) throw UserError("--grid " + key + ": is set by " + typed(*same) + " as well");
    for (std::size_t i = 0; i + 1 < axes.size(); ++i) {
      if (overlap(axes[i].key, key))
        throw UserError("--grid " + key + ": is set by --grid " + axes[i].key + " as well");
    }
  }
  return axes;
}

/// The settings of the first run of the grid: flags may need what only the grid gives.
std::vector<Override> first_of(std::vector<Override> settings, const std::vector<sweep::Axis>& axes) {
  for (const sweep::Axis& axis : axes) settings.push_back({axis.key, axis.values.front(), "--grid"});
  return settings;
}

/// The methods that a setting of an engine means nothing to.
std::vector<std::string> unread_by(const std::string& key, const std::vector<const catalogue::Method*>& methods,
                                   const Scenario& scenario) {
  std::vector<std::string> names;
  for (const catalogue::Method* method : methods) {
    if (catalogue::is_engine_setting(key) && !catalogue::reads(*method, key, scenario))
      names.emplace_back(method->name);
  }
  return names;
}

/// Of all that has a part in the runs: engines may be replaced where the program stays.
std::string versions_text(const std::vector<const catalogue::Method*>& methods) {
  std::string text;
  for (const auto& [name, version] : catalogue::versions()) text += name + ' ' + version + '\n';
  for (const auto& [name, version] : catalogue::engine_versions(methods)) text += name + ' ' + version + '\n';
  return text;
}

std::string time_text(double seconds) {
  const auto whole = static_cast<long>(seconds + 0.5);
  return whole >= 3600 ? fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60)
                       : fmt::format("{}:{:02} min", whole / 60, whole % 60);
}

/// "[120/4000] 83 runs/s, 0:47 min left, 3 diverged", ten times a second at most.
class SweepProgress {
 public:
  SweepProgress(const sweep::Journal& journal, bool quiet)
      : line_(0, quiet),
        total_(journal.head().shard.runs_of(journal.runs())),
        begun_with_(journal.rows()),
        begun_at_s_(run::steady_seconds()) {}

  void show(const sweep::Journal& journal) {
    const double now = run::steady_seconds();
    if (!line_.shown() || now - shown_at_s_ < 0.1) return;
    shown_at_s_ = now;
    std::string text = fmt::format("[{}/{}]", journal.rows(), total_);
    const auto done = static_cast<double>(journal.rows() - begun_with_);
    if (done > 0 && now > begun_at_s_) {
      const double rate = done / (now - begun_at_s_);
      text +=
          fmt::format(" {:.3g} runs/s, {} left", rate, time_text(static_cast<double>(total_ - journal.rows()) / rate));
    }
    for (const auto status :
         {sweep::Status::diverged, sweep::Status::crashed, sweep::Status::timeout, sweep::Status::suspect}) {
      if (journal.rows(status) > 0) text += fmt::format(", {} {}", journal.rows(status), status_name(status));
    }
    line_.show(text);
  }

 private:
  Progress line_;
  long total_;
  long begun_with_;
  double begun_at_s_;
  double shown_at_s_ = 0;
};

/// Half-written tables of a sweep that was killed while it wrote them; its journal's lock is ours now.
void remove_parts(const fs::path& journal) {
  const std::string begin = "." + journal.stem().string();
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(journal.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    for (const char* table : {".csv.", "-timing.csv.", "-front.csv.", "-front-ode.csv.", "-front.png."}) {
      if (name.starts_with(begin + table) && name.ends_with(".part")) fs::remove(entry.path(), ignored);
    }
  }
}

int sweep_grid(const Options& options) {
  const std::filesystem::path path = scenario_file(options.scenario);
  const ScenarioFile file(path, options.settings.import_options(path));
  tell_of_import(path);
  const std::vector<Override> settings = options.settings.overrides();
  std::vector<sweep::Axis> axes = axes_of(options, settings);
  const std::vector<Override> first = first_of(settings, axes);
  const Scenario base = file.read(first, known_names());
  const auto methods = chosen_methods(options.methods, base, first);
  require_read(first, {{{base, methods}}});
  for (sweep::Axis& axis : axes) axis.unread_by = unread_by(axis.key, methods, base);
  sweep::Axis& last = axes.emplace_back(sweep::Axis{"method", {}});
  for (const catalogue::Method* method : methods) last.values.emplace_back(method->name);
  catalogue::GridRuns runs(file, settings, known_names(), sweep::Grid(std::move(axes)));
  const sweep::Head head{base.name,           sweep::parse_shard(options.shard),
                         runs.grid().axes(),  result_columns(),
                         file.text(settings), versions_text(methods)};
  std::vector<std::uint32_t> groups;
  {
    Progress progress(0, options.answer.quiet);
    groups = runs.groups([&](long run) {
      if (run % 1000 == 0) progress.show(fmt::format("checking run {} of {}", run, runs.grid().runs()));
    });
  }

  const fs::path place = journal_file(options.out, base.name);
  make_folder(place.parent_path());
  sweep::Journal journal(place, head);
  remove_parts(place);
  if (journal.damaged() > 0) {
    std::cerr << fmt::format(
        "odeval: {}: {} damaged line{} left out; a run that no other line tells of is done again\n", place.string(),
        journal.damaged(), journal.damaged() == 1 ? "" : "s");
  }
  int signal = 0;
  try {
    SweepProgress progress(journal, options.answer.quiet);
    signal = run_sweep(runs.work(), groups, journal,
                       {options.jobs, options.timeout_s, [&](const auto& now) { progress.show(now); }});
  } catch (const UserError&) {  // of a run that nothing checks before its turn: bad input writes nothing
    if (journal.rows() == 0) fs::remove(place);
    throw;
  }
  if (signal != 0) {
    std::cerr << fmt::format(
        "odeval: stopped by {}; {} of {} runs are in {}, and the same command goes on from there\n",
        ::strsignal(signal), journal.rows(), head.shard.runs_of(journal.runs()), place.string());
    return 128 + signal;
  }
  return answer(journal, options.out, options.answer);
}

}  // namespace

Action attach_sweep(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("SCENARIO", options->scenario, "a name ('odeval list') or a .toml file").required();
  flags
      .add_option(
          "--grid", options->grids,
          "values of a key of the file: KEY=V1,V2,... or N of them, KEY=log:A:B:N or KEY=lin:A:B:N; each --grid "
          "multiplies the runs")
      .type_name("KEY=VALUES")
      .one_value();
  add_method_option(flags, options->methods);
  add_jobs_option(flags, options->jobs);
  flags.add_option("--shard", options->shard, "only the I-th of N parts of the runs; 'odeval merge' joins them")
      .type_name("I/N");
  flags.add_option("--timeout", options->timeout_s, "seconds after which a run is given up")
      .type_name("S")
      .check(number_within(1e-3, 1e7))
      .capture_default_str();
  add_out_option(flags, options->out);
  add_answer_options(flags, options->answer);
  options->settings.attach(flags);
  return [options] { return sweep_grid(*options); };
}

}  // namespace odeval::cli
