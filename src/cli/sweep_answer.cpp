#include "cli/sweep_answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <span>

#include "catalogue/methods.hpp"
#include "catalogue/self_converged.hpp"
#include "cli/flags.hpp"
#include "cli/settings.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "odeval/metrics.hpp"
#include "output/file.hpp"
#include "output/number.hpp"
#include "output/sweep_table.hpp"
#include "output/table.hpp"
#include "report/front.hpp"
#include "run/front.hpp"

namespace odeval::cli {
namespace {

namespace fs = std::filesystem;
using sweep::Head;
using sweep::Journal;
using sweep::Point;
using sweep::Row;
using sweep::Status;

/// Quantities of which less is better, in size.
std::vector<std::string> error_metrics() {
  std::vector<std::string> names;
  for (const Quantity& row : quantities) {
    if (row.direction == Direction::less || row.direction == Direction::nearer_zero) names.emplace_back(row.name);
  }
  return names;
}

/// Reads an error out of a row's cells.
class ErrorOf {
 public:
  ErrorOf(const Head& head, const std::string& metric) : error_(place(head, metric)) {
    const std::optional<quantity::Id> bound = quantity_named(metric)->uncertainty;
    if (bound) uncertainty_ = place(head, std::string(quantities[*bound].name));
  }

  double value(const Row& row) const { return std::fabs(number_in(row.cells, error_)); }
  /// Of the reference; none where the metric does not depend on it.
  std::optional<double> uncertainty(const Row& row) const {
    if (!uncertainty_) return std::nullopt;
    return number_in(row.cells, *uncertainty_);
  }
  bool told(const Row& row) const { return value(row) > uncertainty(row).value_or(-1); }
  /// What the error is no larger than. Errors below what the reference knows are not told apart.
  double bound(const Row& row) const {
    const double known_to = uncertainty(row).value_or(0);
    return std::max(value(row), known_to) + known_to;
  }

 private:
  static std::size_t place(const Head& head, const std::string& name) {
    const auto found = std::ranges::find(head.columns, name);
    if (found == head.columns.end()) throw UserError("--error " + name + ": is no column of this sweep's table");
    return static_cast<std::size_t>(found - head.columns.begin());
  }

  std::size_t error_;
  std::optional<std::size_t> uncertainty_;
};

std::vector<std::string> keys_of(const Head& head) {
  std::vector<std::string> keys;
  for (const sweep::Axis& axis : head.axes) keys.push_back(axis.key);
  return keys;
}

/// The scenario of the grid's first point.
Scenario first_point(const Head& head) {
  std::vector<Override> settings;
  for (std::size_t i = 0; i + 1 < head.axes.size(); ++i) {
    settings.push_back({head.axes[i].key, head.axes[i].values.front(), "--grid"});
  }
  return ScenarioFile(head.scenario + ".toml", head.settings).read(settings, known_names());
}

/// The axes that make another motion or look at it at other times, so that errors along them cannot be compared: all
/// but the step and the settings of engines.
std::vector<std::size_t> group_axes(const Head& head, const Scenario& scenario) {
  std::vector<std::size_t> axes;
  for (std::size_t i = 0; i + 1 < head.axes.size(); ++i) {
    const std::string& key = head.axes[i].key;
    const bool spring = catalogue::joints_are_springs(scenario) && catalogue::is_of_spring(key);
    if (spring || (key != "step" && !catalogue::is_engine_setting(key))) axes.push_back(i);
  }
  return axes;
}

/// The table and the timings, row by row, and on the way what the front is made of: the reference has no part in it,
/// nor has a run that is not ok.
std::vector<Point> write_tables(const Journal& journal, const fs::path& stem, const ErrorOf& error,
                                std::string_view reference) {
  const Head& head = journal.head();
  const sweep::Grid grid(head.axes);
  WholeFile table(stem.string() + ".csv");
  WholeFile timing(stem.string() + "-timing.csv");
  table.write(sweep_header(keys_of(head), head.columns));
  timing.write("run,cpu_s\n");
  std::vector<Point> points;
  for (long run = 0; run < journal.runs(); ++run) {
    if (!journal.has(run)) continue;
    const Row row = journal.row(run);
    table.write(
        sweep_line(run, grid.values(run), sweep::status_name(row.status), row.reason, row.cells, head.columns.size()));
    const double cpu_s = static_cast<double>(row.cpu_us) / 1e6;
    timing.write(fmt::format("{},{}\n", run, row.status == Status::timeout ? "" : number_text(cpu_s)));
    if (row.status != Status::ok || grid.values(run).back() == reference) continue;
    points.push_back({run, cpu_s, error.bound(row), error.told(row)});
  }
  table.finish();
  timing.finish();
  return points;
}

/// The first error of the table that any run has; all have an energy.
std::string first_error(const Journal& journal) {
  for (const Quantity& metric : quantities) {
    if (!metric.uncertainty) continue;
    const ErrorOf error(journal.head(), std::string(metric.name));
    for (long run = 0; run < journal.runs(); ++run) {
      if (journal.has(run) && std::isfinite(error.value(journal.row(run)))) return std::string(metric.name);
    }
  }
  return std::string(quantities[quantity::max_energy_drift].name);
}

std::string unit_of(const std::string& metric) {
  const Quantity* const row = quantity_named(metric);
  return row == nullptr || row->unit.empty() ? "" : ", " + std::string(row->unit);
}

/// "3 step × 2 ode.erp × 1 method + 3 step × 4 method without ode.erp": methods together that read the same keys, since
/// a key that a method does not read does not multiply its runs.
std::string grid_text(const Head& head) {
  const std::span keys = std::span(head.axes).first(head.axes.size() - 1);
  std::map<std::vector<bool>, std::size_t> methods;
  std::vector<std::vector<bool>> in_order;
  for (const std::string& method : head.axes.back().values) {
    std::vector<bool> unread;
    for (const sweep::Axis& key : keys)
      unread.push_back(std::ranges::find(key.unread_by, method) != key.unread_by.end());
    if (methods[unread]++ == 0) in_order.push_back(std::move(unread));
  }
  std::string text;
  for (const std::vector<bool>& unread : in_order) {
    if (!text.empty()) text += " + ";
    std::string without;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (unread[i]) {
        without += (without.empty() ? " without " : ", ") + keys[i].key;
      } else {
        text += fmt::format("{} {} × ", keys[i].values.size(), keys[i].key);
      }
    }
    text += fmt::format("{} {}", methods[unread], head.axes.back().key) + without;
  }
  return text;
}

std::string counts_text(const Journal& journal) {
  std::string text;
  for (std::size_t i = 0; i < sweep::statuses; ++i) {
    const auto status = static_cast<Status>(i);
    if (journal.rows(status) == 0) continue;
    text += (text.empty() ? ": " : ", ") + fmt::format("{} {}", journal.rows(status), sweep::status_name(status));
  }
  return text;
}

/// Runs whose errors can be compared, and those of them that no other of these beats.
struct Group {
  std::string name;  // "n = 4, duration = 2"; empty where the sweep has one group
  std::vector<Point> points;
  std::vector<Point> front;      // of all
  std::vector<Point> ode_front;  // of ODE's own methods, where the sweep has others as well: else empty
};

/// What an error costs in a sweep.
struct Answer {
  std::string metric;
  ErrorOf error;
  std::vector<Group> groups;  // in grid order
};

/// Points of a grid, those together that can be compared.
std::vector<Group> groups_of(const Head& head, const std::vector<std::size_t>& axes, std::vector<Point> points) {
  const sweep::Grid grid(head.axes);
  std::map<std::vector<std::size_t>, Group> groups;
  for (const Point& point : points) {
    const std::vector<std::size_t> places = grid.places(point.run);
    std::vector<std::size_t> key;
    for (const std::size_t axis : axes) key.push_back(places[axis]);
    Group& group = groups[key];
    if (group.points.empty()) {
      for (const std::size_t axis : axes) {
        group.name +=
            (group.name.empty() ? "" : ", ") + head.axes[axis].key + " = " + head.axes[axis].values[places[axis]];
      }
    }
    group.points.push_back(point);
  }
  const std::vector<std::string>& methods = head.axes.back().values;
  const auto is_ode = [&](const Point& point) {
    return catalogue::is_plain_ode(methods[grid.places(point.run).back()]);
  };
  std::vector<Group> all;
  for (auto& [key, group] : groups) {
    group.front = sweep::pareto_front(group.points);
    std::vector<Point> of_ode;
    std::ranges::copy_if(group.points, std::back_inserter(of_ode), is_ode);
    if (of_ode.size() < group.points.size()) group.ode_front = sweep::pareto_front(std::move(of_ode));
    all.push_back(std::move(group));
  }
  return all;
}

std::string picture(const Journal& journal, const Answer& answer) {
  constexpr std::size_t most_drawn = 20'000;  // more make one blot
  constexpr std::size_t most_fronts = 8;      // more are not told apart
  const Head& head = journal.head();
  report::Panel panel;
  panel.x_label = "CPU time of the run, s";
  panel.y_label = answer.metric + unit_of(answer.metric) + ", at most";
  const sweep::Grid grid(head.axes);
  for (const std::string& method : head.axes.back().values)
    panel.series.push_back({method, {}, {}, report::Mark::points});
  std::size_t all = 0;
  for (const Group& group : answer.groups) all += group.points.size();
  const std::size_t every = all / most_drawn + 1;
  for (const Group& group : answer.groups) {
    for (std::size_t i = 0; i < group.points.size(); i += every) {
      report::Series& series = panel.series[grid.places(group.points[i].run).back()];
      series.x.push_back(group.points[i].cost);
      series.y.push_back(group.points[i].error);
    }
  }
  const auto draw_front = [&](const std::vector<Point>& front, const std::string& label, bool dashed) {
    report::Series& line = panel.series.emplace_back(report::Series{label, {}, {}});
    line.dashed = dashed;
    for (const Point& point : front) {
      line.x.push_back(point.cost);
      line.y.push_back(point.error);
    }
  };
  for (const Group& group : std::span(answer.groups).first(std::min(answer.groups.size(), most_fronts))) {
    const std::string of = group.name.empty() ? "" : ", " + group.name;
    draw_front(group.front, "Pareto front" + of, false);
    if (!group.ode_front.empty()) draw_front(group.ode_front, "the same of ODE" + of, true);
  }
  return front_png(panel, head.scenario + ": what an error costs");
}

std::string front_csv(const Journal& journal, const Answer& answer, std::vector<Point> Group::*front) {
  const Head& head = journal.head();
  const sweep::Grid grid(head.axes);
  std::string csv = "cpu_s," + answer.metric + ",reference_uncertainty," + sweep_header(keys_of(head), head.columns);
  for (const Group& group : answer.groups) {
    for (const Point& point : group.*front) {
      const Row row = journal.row(point.run);
      const std::optional<double> uncertainty = answer.error.uncertainty(row);
      csv += fmt::format("{},{},{},{}", number_text(point.cost), number_text(answer.error.value(row)),
                         uncertainty ? number_text(*uncertainty) : "",
                         sweep_line(point.run, grid.values(point.run), sweep::status_name(row.status), row.reason,
                                    row.cells, head.columns.size()));
    }
  }
  return csv;
}

/// The same for people.
std::string front_table(const Journal& journal, const Answer& answer, const std::vector<Point>& front) {
  const std::vector<std::string> keys = keys_of(journal.head());
  const sweep::Grid grid(journal.head().axes);
  std::vector<std::string> header{"CPU, ms", answer.metric + unit_of(answer.metric)};
  header.insert(header.end(), keys.begin(), keys.end());
  header.emplace_back("steps");
  header.emplace_back("run");
  TextTable table("rr" + std::string(keys.size(), 'l') + "rr", header);
  for (const Point& point : front) {
    const Row row = journal.row(point.run);
    const std::vector<std::string> values = grid.values(point.run);
    std::vector<std::string> cells{three_digits(1e3 * point.cost),
                                   with_uncertainty(answer.error.value(row), answer.error.uncertainty(row))};
    if (row.reason.starts_with(self_converged_origin)) {
      cells.back() += ' ' + std::string(self_converged_origin);
    }
    cells.insert(cells.end(), values.begin(), values.end());
    cells.push_back(number_text(number_in(row.cells, 0)));
    cells.push_back(std::to_string(point.run));
    table.add(cells);
  }
  return table.text();
}

/// Whether there was something to draw, and it is drawn. A picture of an earlier front goes either way.
bool draw(const Journal& journal, const Answer& answer, const fs::path& file) {
  std::error_code ignored;
  fs::remove(file, ignored);
  try {
    const std::string png = picture(journal, answer);
    if (!png.empty()) write_whole(file, png);
    return !png.empty();
  } catch (const MachineError& cause) {
    std::cerr << "odeval: the front is not drawn: " << cause.what() << '\n';
    return false;
  }
}

void print_front(const Journal& journal, const Answer& answer) {
  const std::string& metric = answer.metric;
  if (journal.rows(Status::ok) == 0) {
    std::cout << "\nno run is ok: there is no front\n";
    return;
  }
  if (std::ranges::all_of(answer.groups, [](const Group& group) { return group.front.empty(); })) {
    std::cout << "\nno run that is ok has a value of " << metric << ": there is no front\n";
    return;
  }
  constexpr std::size_t most_shown = 12;
  bool lost = false;
  for (const Group& group : std::span(answer.groups).first(std::min(answer.groups.size(), most_shown))) {
    const std::string where = group.name.empty() ? "" : " where " + group.name;
    if (!group.ode_front.empty()) {
      std::cout << "\nPareto front of " << metric << " against CPU time" << where << ", ODE's own methods\n\n"
                << front_table(journal, answer, group.ode_front);
    }
    std::cout << "\nPareto front of " << metric << " against CPU time" << where
              << (group.ode_front.empty() ? "" : ", all methods") << "\n\n"
              << (group.front.empty() ? "no run that is ok has a value\n" : front_table(journal, answer, group.front));
    if (group.front.empty()) continue;
    const double worst = answer.error.value(journal.row(group.front.front().run));
    lost = lost || (metric == quantities[quantity::max_error_q].name && worst > divergence_rad);
  }
  if (answer.groups.size() > most_shown) {
    std::cout << fmt::format("\n{} more such fronts are in -front.csv\n", answer.groups.size() - most_shown);
  }
  if (lost) {
    std::cout << fmt::format(
        "\nErrors above {} rad say only that the motion was lost: a shorter --duration tells more.\n", divergence_rad);
  }
  std::cout << "\nCPU time of the stepping, each run once, while others ran beside it; 'odeval recommend' measures "
               "properly\n";
}

}  // namespace

void add_answer_options(Flags& flags, AnswerOptions& options) {
  flags.add_option("--error", options.error, "the error of the Pareto front; default: the angle error")
      .type_name("METRIC")
      .one_of(error_metrics());
  flags.add_flag("--quiet", options.quiet, "print neither table nor progress");
}

fs::path journal_file(const fs::path& folder, const std::string& scenario) {
  return folder / "sweep" / (scenario + ".journal");
}

int answer(const Journal& journal, const fs::path& folder, const AnswerOptions& options) {
  const Head& head = journal.head();
  const std::string stem = (folder / "sweep" / head.scenario).string();
  const std::string metric = options.error.empty() ? first_error(journal) : options.error;
  const Scenario scenario = first_point(head);
  Answer answer{metric, ErrorOf(head, metric), {}};
  answer.groups = groups_of(head, group_axes(head, scenario),
                            write_tables(journal, stem, answer.error, catalogue::provider_of(scenario).method));
  write_whole(stem + "-front.csv", front_csv(journal, answer, &Group::front));
  const bool two_fronts = std::ranges::any_of(answer.groups, [](const Group& one) { return !one.ode_front.empty(); });
  if (two_fronts) write_whole(stem + "-front-ode.csv", front_csv(journal, answer, &Group::ode_front));
  const bool drawn = draw(journal, answer, stem + "-front.png");
  if (!options.quiet) {
    const std::string shard = head.shard.whole() ? "" : ", shard " + head.shard.text();
    std::cout << fmt::format("{}: {} run{} ({}{}){}\n", head.scenario, journal.rows(), journal.rows() == 1 ? "" : "s",
                             grid_text(head), shard, counts_text(journal));
    print_front(journal, answer);
    std::cout << fmt::format("wrote {}.csv, -timing.csv, -front.csv{}{}\n", stem, two_fronts ? ", -front-ode.csv" : "",
                             drawn ? ", -front.png" : "");
  }
  return journal.rows(Status::ok) + journal.rows(Status::suspect) == journal.rows() ? 0 : 1;
}

}  // namespace odeval::cli
