// odeval judge: a trace of one's own beside a scenario's reference, or beside the same run at half the step.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>

#include "catalogue/foreign_trace.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/settings.hpp"
#include "cli/trace_files.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "output/table.hpp"
#include "output/trace_csv.hpp"
#include "output/trace_judgement.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::string trace;
  std::string scenario;
  std::string against;
  Settings settings;
  bool json = false;
};

/// Numbers of which every one is finite, over time.
CsvColumns read_numbers(const std::string& file) {
  CsvColumns columns = read_csv(file);
  if (columns.header.empty()) throw UserError(file + ": is empty: must have a column t with two rows or more");
  if (std::ranges::find(columns.header, "t") == columns.header.end()) {
    throw UserError(fmt::format("{}: must have a column t, and has {}", file, fmt::join(columns.header, ", ")));
  }
  for (std::size_t row = 0; row < (columns.columns.empty() ? 0 : columns.columns.front().size()); ++row) {
    for (std::size_t i = 0; i < columns.header.size(); ++i) {
      if (std::isfinite(columns.columns[i][row])) continue;
      throw UserError(fmt::format("{}:{}: {} = {} must be a finite number", file, row + 2, columns.header[i],
                                  number_text(columns.columns[i][row])));
    }
  }
  return columns;
}

/// The columns of the file with a place for each angle and body of the scenario, in its order: an empty column where
/// the file has none.
CsvColumns with_places(CsvColumns file, const Scenario& scenario) {
  CsvColumns all;
  const auto column = [&file](const std::string& cell) -> Column* {
    const auto found = std::ranges::find(file.header, cell);
    return found == file.header.end() ? nullptr : &file.columns[static_cast<std::size_t>(found - file.header.begin())];
  };
  const auto place = [&](const std::string& cell) {
    if (std::ranges::find(all.header, cell) != all.header.end()) return;
    all.header.push_back(cell);
    Column* its = column(cell);
    all.columns.push_back(its != nullptr ? std::move(*its) : Column());  // once: of a long file there is one copy
  };
  const std::size_t angles = scenario.planar ? scenario.planar->links.size() : 0;
  for (std::size_t i = 1; i <= angles; ++i) place(fmt::format("q{}", i));
  for (std::size_t i = 1; i <= angles; ++i) place(fmt::format("qd{}", i));
  for (std::size_t i = 1; i <= angles; ++i) place(fmt::format("x{}", i));
  for (std::size_t i = 1; angles == 0 && i <= scenario.mechanism.bodies.size(); ++i) {
    place(scenario.named ? scenario.mechanism.bodies[i - 1].name + ".x" : fmt::format("x{}", i));
  }
  const Column* const energy = column("energy");  // as good as both its parts
  if (energy != nullptr && (column("kinetic") == nullptr || column("potential") == nullptr)) {
    all.header.insert(all.header.end(), {"kinetic", "potential"});
    all.columns.insert(all.columns.end(), {*energy, Column(energy->size())});
  }
  for (const std::string& cell : file.header) place(cell);
  return all;
}

/// A scenario has no more angles and bodies than it has places for.
void refuse_others(const Trace& trace, const Scenario& scenario, const std::string& file) {
  const std::size_t angles = scenario.planar ? scenario.planar->links.size() : 0;
  const std::size_t bodies = scenario.planar ? angles : scenario.mechanism.bodies.size();
  const auto refuse = [&](std::size_t has, std::size_t wanted, const char* one, const char* many) {
    if (has <= wanted) return;
    throw UserError(fmt::format("{}: has columns of {} {}; '{}' has {}", file, has, has == 1 ? one : many,
                                scenario.name, wanted == 0 ? "none" : std::to_string(wanted)));
  };
  refuse(trace.q.size(), angles, "angle", "angles");
  refuse(trace.bodies.size(), bodies, "body", "bodies");
}

void tell_of_unknown(const std::vector<std::string>& header, const std::string& file) {
  std::vector<std::string> unknown;
  for (const std::string& cell : header) {
    if (trace_column_of(cell) == nullptr) unknown.push_back("'" + cell + "'");
  }
  if (unknown.empty()) return;
  std::cerr << fmt::format("odeval: {}: no trace has {} {}: left out\n", file,
                           unknown.size() == 1 ? "a column" : "the columns", fmt::join(unknown, ", "));
}

/// The whole run, and the times of errors within it.
std::vector<double> times_within(double end) {
  std::vector<double> times;
  for (const double t : error_times) {
    if (t < end) times.push_back(t);
  }
  times.push_back(end);
  return times;
}

int beside_reference(const Options& options) {
  CsvColumns columns = read_numbers(options.trace);
  const std::vector<std::string> header = columns.header;
  const std::size_t rows = columns.columns.front().size();
  const auto t = static_cast<std::size_t>(std::ranges::find(header, "t") - header.begin());
  const double dt = spacing(columns.columns[t], options.trace);
  const double end = dt * static_cast<double>(rows - 1);
  catalogue::Evaluator evaluator = evaluator_at(options.scenario, options.settings, dt, rows, options.trace);
  Trace trace = trace_of(with_places(std::move(columns), evaluator.scenario()));
  refuse_others(trace, evaluator.scenario(), options.trace);
  const SampleGrid& grid = evaluator.grid();
  for (std::size_t row = 0; row < rows; ++row) trace.t[row] = grid.time(static_cast<long>(row));
  const catalogue::ForeignTrace foreign(std::move(trace), evaluator, options.trace);
  tell_of_unknown(header, options.trace);
  if (!foreign.untold().empty()) {
    std::cerr << fmt::format("odeval: {}: not told in full: {}\n", options.trace, fmt::join(foreign.untold(), "; "));
  }
  std::vector<Metrics> metrics;
  for (const double until : times_within(end)) metrics.push_back(foreign.measure(until));
  std::cout << (options.json ? judgement_json(metrics) : judgement_table(metrics));
  if (!options.json) std::cout << "\nreference  " << evaluator.reference().origin << '\n';
  return 0;
}

/// Columns that one file alone has.
void tell_of_uncompared(const CsvColumns& whole, const CsvColumns& half, const Options& options) {
  const auto tell = [](const CsvColumns& of, const std::string& file, const CsvColumns& other) {
    std::vector<std::string> alone;
    for (const std::string& cell : of.header) {
      if (std::ranges::find(other.header, cell) == other.header.end()) alone.push_back(cell);
    }
    if (alone.empty()) return;
    std::cerr << fmt::format("odeval: {} alone has {}: not compared\n", file, fmt::join(alone, ", "));
  };
  tell(whole, options.trace, half);
  tell(half, options.against, whole);
}

int beside_half_the_step(const Options& options) {
  const CsvColumns whole = read_numbers(options.trace);
  const CsvColumns half = read_numbers(options.against);
  const double dt = spacing(trace_of(whole).t, options.trace);
  const double finer = spacing(trace_of(half).t, options.against);
  const double ratio = dt / finer;
  if (std::fabs(ratio - std::round(ratio)) > 1e-6 * ratio || ratio < 0.5) {
    throw UserError(fmt::format("{}: has rows every {} s, which must be those of {} or a part of them, every {} s",
                                options.against, number_text(finer), options.trace, number_text(dt)));
  }
  const auto every = static_cast<std::size_t>(std::lround(ratio));
  const std::size_t rows = whole.columns.front().size();
  const std::size_t finer_rows = half.columns.front().size();
  if (finer_rows < (rows - 1) * every + 1) {
    throw UserError(fmt::format("{}: ends at t = {}, and must go on until the end of {}, {}", options.against,
                                number_text(finer * static_cast<double>(finer_rows - 1)), options.trace,
                                number_text(dt * static_cast<double>(rows - 1))));
  }
  const std::vector<TraceDifference> differences =
      differences_of(whole, half, every, times_within(dt * static_cast<double>(rows - 1)));
  if (differences.empty()) {
    throw UserError(fmt::format("{}: has {}, and must have a column besides t that {} has: {}", options.against,
                                fmt::join(half.header, ", "), options.trace, fmt::join(whole.header, ", ")));
  }
  tell_of_uncompared(whole, half, options);
  std::cout << (options.json ? differences_json(differences) : differences_table(differences));
  return 0;
}

int judge(const Options& options) {
  if (options.scenario.empty() == options.against.empty()) {
    throw UserError("judge: give either --scenario or --against");
  }
  return options.against.empty() ? beside_reference(options) : beside_half_the_step(options);
}

}  // namespace

Action attach_judge(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("TRACE", options->trace, "a .csv file with a column t and any columns of a scenario's trace")
      .required();
  flags.add_option("--scenario", options->scenario, "whose motion it should be: a name ('odeval list') or a .toml file")
      .type_name("SCENARIO");
  flags.add_option("--against", options->against, "the same run at half the step").type_name("TRACE");
  flags.add_flag("--json", options->json, "print JSON");
  options->settings.attach(flags);
  return [options] { return judge(*options); };
}

}  // namespace odeval::cli
