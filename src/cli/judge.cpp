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

void tell_of_unknown(const CsvColumns& columns, const std::string& file) {
  std::vector<std::string> unknown;
  for (const std::string& cell : columns.header) {
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
  const CsvColumns columns = read_numbers(options.trace);
  Trace trace = trace_of(columns);
  const double dt = spacing(trace.t, options.trace);
  const double end = dt * static_cast<double>(trace.rows() - 1);
  catalogue::Evaluator evaluator = evaluator_at(options.scenario, options.settings, dt, trace.rows(), options.trace);
  const SampleGrid& grid = evaluator.grid();
  for (std::size_t row = 0; row < trace.rows(); ++row) trace.t[row] = grid.time(static_cast<long>(row));
  catalogue::ForeignTrace foreign(std::move(trace), evaluator, options.trace);
  tell_of_unknown(columns, options.trace);
  std::vector<Metrics> metrics;
  for (const double until : times_within(end)) metrics.push_back(foreign.measure(until));
  std::cout << (options.json ? judgement_json(metrics) : judgement_table(metrics));
  if (!options.json) std::cout << "\nreference  " << evaluator.reference().origin << '\n';
  return 0;
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
  if (differences.empty()) throw UserError(options.against + ": has no column of " + options.trace);
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
  flags.add_flag("--json", options->json, "for programs");
  options->settings.attach(flags);
  return [options] { return judge(*options); };
}

}  // namespace odeval::cli
