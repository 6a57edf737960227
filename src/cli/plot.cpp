// odeval plot: any columns of any traces as a picture, by themselves or against another trace or the reference.
#include "cli/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/settings.hpp"
#include "cli/trace_files.hpp"
#include "model/nearest.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "report/chart.hpp"
#include "report/log_axis.hpp"
#include "report/plot.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> traces;
  std::vector<std::string> columns;
  std::string x = "t";
  std::string minus;
  std::string scenario;
  Settings settings;
  double from = 0;
  double until = std::numeric_limits<double>::infinity();
  bool log_y = false;
  std::string out = "results/plot.svg";
  bool quiet = false;
};

const Column& column_of(const CsvColumns& table, std::string_view name, const std::string& file) {
  const auto found = std::ranges::find(table.header, name);
  if (found == table.header.end()) {
    throw UserError(fmt::format("{}: has no column '{}'{}; it has {}", file, name, nearest_hint(name, table.header),
                                fmt::join(table.header, ", ")));
  }
  return table.columns[static_cast<std::size_t>(found - table.header.begin())];
}

/// ", rad"; nothing of what has none.
std::string unit_after(const std::string& name) {
  const TraceColumn* const column = trace_column_of(name);
  return column == nullptr || column->unit.empty() ? "" : ", " + std::string(column->unit);
}

/// The last so many parts of a path.
std::string end_of(const fs::path& file, std::size_t parts) {
  std::vector<fs::path> all(file.begin(), file.end());
  fs::path end;
  for (std::size_t i = all.size() - std::min(parts, all.size()); i < all.size(); ++i) end /= all[i];
  return end.string();
}

/// The shortest ends of the files' paths that tell them apart, without ".csv" where nothing else differs.
std::vector<std::string> labels_of(const std::vector<std::string>& files) {
  std::vector<fs::path> whole;
  for (const std::string& file : files) {
    whole.push_back(fs::path(file).lexically_normal());
    if (std::ranges::count(whole, whole.back()) > 1) throw UserError(file + ": is given more than once; give it once");
  }
  const bool other_ends = std::ranges::any_of(whole, [&](const fs::path& file) {
    return std::ranges::any_of(whole, [&](const fs::path& other) {
      return other != file && fs::path(other).replace_extension() == fs::path(file).replace_extension();
    });
  });
  std::vector<std::string> labels;
  for (fs::path& file : whole) {
    if (!other_ends) file.replace_extension();
  }
  for (const fs::path& file : whole) {
    std::size_t parts = 1;
    const auto same = [&](const fs::path& other) { return end_of(other, parts) == end_of(file, parts); };
    while (std::ranges::count_if(whole, same) > 1) ++parts;
    labels.push_back(end_of(file, parts));
  }
  return labels;
}

/// The rows from one time to another.
void cut(CsvColumns& table, const std::string& file, double from, double until) {
  const Column t = column_of(table, "t", file);
  for (Column& column : table.columns) {
    std::size_t row = 0;
    std::erase_if(column, [&](double) {
      const double now = t[row++];
      return now < from || now > until;
    });
  }
  if (table.columns.front().empty()) {
    throw UserError(fmt::format("{}: has no row from t = {} to {} s", file, number_text(from), number_text(until)));
  }
}

/// Takes the columns of another trace off, which has rows at the same times. Columns that it lacks go.
void subtract(CsvColumns& table, const std::string& file, const CsvColumns& other, const std::string& other_file) {
  const Column& t = column_of(table, "t", file);
  const Column& at = column_of(other, "t", other_file);
  constexpr double rounding = 1e-6;  // of a spacing: files have as few digits as their writers like
  const double dt = t.size() > 1 ? t[1] - t[0] : 1;
  for (std::size_t row = 0; row < t.size(); ++row) {
    if (row < at.size() && std::fabs(t[row] - at[row]) <= rounding * dt * static_cast<double>(row + 1)) continue;
    throw UserError(fmt::format("{}: has no row at t = {} s, which {} has; both need rows at the same times",
                                other_file, number_text(t[row]), file));
  }
  CsvColumns left;
  for (std::size_t i = 0; i < table.header.size(); ++i) {
    const auto same = std::ranges::find(other.header, table.header[i]);
    if (same == other.header.end()) continue;
    Column column = table.columns[i];
    const Column& taken_off = other.columns[static_cast<std::size_t>(same - other.header.begin())];
    for (std::size_t row = 0; row < column.size() && table.header[i] != "t"; ++row) column[row] -= taken_off[row];
    left.header.push_back(table.header[i]);
    left.columns.push_back(std::move(column));
  }
  table = std::move(left);
}

/// The reference's motion at the times of a trace.
CsvColumns reference_at(const Options& options, const CsvColumns& table, const std::string& file) {
  const Column& t = column_of(table, "t", file);
  catalogue::Evaluator evaluator = evaluator_at(options.scenario, options.settings, spacing(t, file), t.size(), file);
  return parse_csv(trace_csv(evaluator.reference().trace), "the reference of '" + evaluator.scenario().name + "'");
}

int plot(const Options& options) {
  if (!is_picture(options.out)) throw UserError("--out " + options.out + ": must end in .svg or .png");
  if (!options.minus.empty() && !options.scenario.empty()) {
    throw UserError("--minus " + options.minus + ": give it or --scenario, not both");
  }
  if (options.scenario.empty() && !options.settings.overrides().empty()) {
    throw UserError(typed(options.settings.overrides().front()) + ": has a meaning only beside --scenario");
  }
  const std::vector<std::string> labels = labels_of(options.traces);
  std::vector<DrawnTrace> traces;
  for (std::size_t i = 0; i < options.traces.size(); ++i) {
    traces.push_back({options.traces[i], labels[i], read_csv(options.traces[i])});
    DrawnTrace& trace = traces.back();
    if (!options.minus.empty()) subtract(trace.table, trace.file, read_csv(options.minus), options.minus);
    if (!options.scenario.empty()) {
      subtract(trace.table, trace.file, reference_at(options, trace.table, trace.file), "the reference");
    }
    if (options.from > 0 || std::isfinite(options.until)) cut(trace.table, trace.file, options.from, options.until);
  }
  PlotRequest request{options.columns, options.x};
  if (!options.minus.empty()) request.minus = fs::path(options.minus).stem().string();
  if (!options.scenario.empty()) request.minus = "reference";
  request.log_y = options.log_y;
  const std::vector<std::string> left_out = draw_traces(traces, request, options.out);
  if (options.quiet) return 0;
  for (const std::string& what : left_out) std::cout << what << '\n';
  std::cout << "wrote " << options.out << '\n';
  return 0;
}

/// Columns of all traces in one panel; on a logarithmic axis their sizes.
report::Panel panel_of(const std::string& together, const std::vector<DrawnTrace>& traces, const PlotRequest& request) {
  const std::vector<std::string> names = columns_of(together);
  report::Panel panel;
  panel.x_label = request.x + unit_after(request.x);
  panel.y_label = together;
  if (!request.minus.empty()) panel.y_label += " − " + request.minus;
  if (request.log_y) panel.y_label = "|" + panel.y_label + "|";
  panel.y_label += unit_after(names.front());
  panel.log_y = request.log_y;
  for (std::size_t i = 0; i < traces.size(); ++i) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::string label = names.size() > 1 ? traces[i].label + " " + names[k] : traces[i].label;
      report::Series series{label, column_of(traces[i].table, request.x, traces[i].file),
                            column_of(traces[i].table, names[k], traces[i].file)};
      series.colour = static_cast<int>(names.size() > 1 ? i * names.size() + k : i);
      if (request.log_y) {
        for (double& value : series.y) value = std::fabs(value);
      }
      panel.series.push_back(std::move(series));
    }
  }
  return panel;
}

}  // namespace

std::vector<std::string> columns_of(const std::string& panel) {
  std::vector<std::string> names(1);
  for (const char letter : panel) {
    if (letter == '+') {
      names.emplace_back();
    } else {
      names.back() += letter;
    }
  }
  return names;
}

bool is_picture(const fs::path& file) { return file.extension() == ".svg" || file.extension() == ".png"; }

std::vector<std::string> draw_traces(const std::vector<DrawnTrace>& traces, const PlotRequest& request,
                                     const fs::path& file) {
  std::vector<std::string> told;
  report::Chart chart;
  chart.title = request.title;
  for (const std::string& together : request.columns) {
    report::Panel& panel = chart.panels.emplace_back(panel_of(together, traces, request));
    if (!report::has_points(panel)) {
      throw UserError(fmt::format("--columns {}: has no value that can be drawn", together));
    }
    if (!request.log_y) continue;
    const report::LogAxis axis = report::log_axis_of(panel);
    panel.y_range = {axis.least, axis.greatest};
    panel.title = report::left_out_text(axis);
    if (!panel.title.empty()) told.push_back(together + ": " + panel.title);
  }
  chart.width = request.width;
  chart.height = request.height > 0 ? request.height : static_cast<int>(120 + 300 * chart.panels.size());
  write_whole(file,
              report::drawn(chart, file.extension() == ".svg" ? report::ChartFormat::svg : report::ChartFormat::png));
  return told;
}

Action attach_plot(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("TRACE", options->traces, "files with a column t, as 'odeval run' writes them").required();
  flags
      .add_option("--columns", options->columns,
                  "a panel each, one above the other; C1+C2: both in one panel (the first row of a file names all)")
      .type_name("C1[,C2...]")
      .delimiter(',')
      .one_value()
      .required();
  flags.add_option("--x", options->x, "column of the horizontal axis").type_name("C").capture_default_str();
  flags.add_option("--minus", options->minus, "draw the differences from this trace, which has the same times")
      .type_name("TRACE");
  flags.add_option("--scenario", options->scenario, "draw the differences from the reference of this scenario")
      .type_name("SCENARIO");
  flags.add_option("--from", options->from, "time of the first row, s").type_name("T").check(number_within(0, 1e9));
  flags.add_option("--until", options->until, "time of the last row, s").type_name("T").check(number_within(0, 1e9));
  flags.add_flag("--log", options->log_y,
                 "draw absolute values on a logarithmic axis, and tell what has no place on it");
  flags.add_option("--out", options->out, "file of the picture, .svg or .png").type_name("FILE").capture_default_str();
  flags.add_flag("--quiet", options->quiet, "print nothing");
  options->settings.attach(flags);
  return [options] { return plot(*options); };
}

}  // namespace odeval::cli
