// The observed order of every method with a fixed step: claim C1.
#include "measure/order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "catalogue/accuracy.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using report::Cell;
using report::Missing;

constexpr double until_s = 1;
constexpr int halvings = 8;
constexpr double largest_step_s = 5e-3;

/// Ranges of steps that give the order another value, for comparison: as many steps, coarse and fine.
struct Range {
  const char* label;
  double from_s, to_s;
  const char* finding;
};

constexpr Range ranges[] = {{"5 ms to 78 µs", 7e-5, 6e-3, "order.off_coarse"},
                            {"1.25 ms to 20 µs", 1.9e-5, 1.3e-3, "order.off_fine"}};

constexpr const char* few_points = "fewer than three points stand clear of the reference and of rounding";
constexpr const char* not_settled = "the local slopes do not settle in this range of steps";

struct Measured {
  const catalogue::Method* method;
  std::vector<ErrorPoint> points;  // from coarse to fine; empty: not in this build
};

std::vector<ErrorPoint> errors_of(const catalogue::Method& method, const catalogue::Accuracy& accuracy) {
  const double epsilon = method.name.ends_with("-single") ? 6e-8 : 1.1e-16;
  std::vector<ErrorPoint> points;
  for (int k = 0; k <= halvings; ++k) {
    const double h = accuracy.fitting_step(std::ldexp(largest_step_s, -k));
    const catalogue::Trial trial = accuracy.try_setting(method, h);
    points.push_back({h, trial.error, trial.uncertainty + rounding_uncertainty(epsilon, trial.steps)});
  }
  return points;
}

std::optional<ObservedOrder> order_in(const std::vector<ErrorPoint>& points, const Range& range) {
  std::vector<ErrorPoint> inside;
  std::ranges::copy_if(points, std::back_inserter(inside), [&](const ErrorPoint& point) {
    return point.setting >= range.from_s && point.setting <= range.to_s;
  });
  return observed_order(inside, divergence_rad);
}

std::optional<ObservedOrder> settled_order(const std::vector<ErrorPoint>& points) {
  return observed_order(settled_points(points, divergence_rad), divergence_rad);
}

bool is_of_ode(std::string_view name) { return name == "ode-step-double" || name == "ode-quickstep-double"; }

/// The larger distance from 1 of ODE's two steppers.
void add_distance(Findings& findings, const std::string& name, const std::string& meaning,
                  const std::vector<Measured>& all, const auto& order_of) {
  double worst = -1;
  double uncertainty = 0;
  for (const Measured& one : all) {
    if (!is_of_ode(one.method->name)) continue;
    const std::optional<ObservedOrder> observed = order_of(one.points);
    if (!observed) {
      findings.add(name, unavailable(meaning, "", std::string(one.method->name) + ": " + not_settled));
      return;
    }
    const double off = std::fabs(observed->order - 1);
    if (off <= worst) continue;
    worst = off;
    uncertainty = observed->half_width;
  }
  findings.add(name, known_by(report::Source::fit, measured(meaning, "", worst, uncertainty)));
}

void add_orders(Findings& findings, const std::vector<Measured>& all) {
  for (const Measured& one : all) {
    const std::string name(one.method->name);
    const std::string meaning = "observed order of " + name;
    if (one.points.empty()) {
      findings.add("order." + name, unavailable(meaning, "", std::string(one.method->why_missing)));
    } else if (const auto observed = settled_order(one.points)) {
      findings.add("order." + name,
                   known_by(report::Source::fit, measured(meaning, "", observed->order, observed->half_width)));
    } else {
      findings.add("order." + name, unavailable(meaning, "", not_settled));
    }
  }
  const std::string meaning = "distance of ODE's observed order from 1, the larger of both steppers, ";
  add_distance(findings, "C1.order_off", meaning + "where the slopes have settled", all, settled_order);
  for (const Range& range : ranges) {
    add_distance(findings, range.finding, meaning + "at " + range.label, all,
                 [&](const std::vector<ErrorPoint>& points) { return order_in(points, range); });
  }
}

/// The order and its interval, and nothing else, or why not.
void add_cells(std::vector<Cell>& row, const std::optional<ObservedOrder>& observed, const char* why) {
  if (observed) {
    row.insert(row.end(), {observed->order, observed->half_width});
  } else {
    row.insert(row.end(), 2, Missing{why});
  }
}

report::Table orders(const std::vector<Measured>& all) {
  report::Table table{
      .name = "order",
      .columns = {"method", "order by design", "observed", "half width (95 %)", "from h, s", "to h, s", "points"}};
  for (const Range& range : ranges) {
    table.columns.push_back(fmt::format("all points, {}", range.label));
    table.columns.push_back(fmt::format("half width ({})", range.label));
  }
  for (const Measured& one : all) {
    const std::string name(one.method->name);
    std::vector<Cell> row{name, static_cast<double>(one.method->order)};
    const char* const missing = one.method->why_missing.data();  // of a literal
    const char* const why = one.points.empty() ? missing : not_settled;
    const auto settled = settled_order(one.points);
    add_cells(row, settled, why);
    if (settled) {
      row.insert(row.end(), {settled->to, settled->from, static_cast<double>(settled->points)});
    } else {
      row.insert(row.end(), 3, Missing{why});
    }
    for (const Range& range : ranges) {
      add_cells(row, order_in(one.points, range), one.points.empty() ? missing : few_points);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

report::Figure lines(const std::vector<Measured>& all) {
  report::Panel errors{
      .x_label = "h, s", .y_label = "largest angle error until 1 s, rad", .log_x = true, .log_y = true};
  report::Panel slopes{.x_label = "h, s", .y_label = "local slope", .log_x = true, .y_range = std::pair(0.0, 5.0)};
  for (const Measured& one : all) {
    if (one.points.empty()) continue;
    const std::string name(one.method->name);
    report::Series line{name, {}, {}, report::Mark::line_and_points, colour_beside_ode(name), false};
    report::Series slope = line;
    for (std::size_t i = 0; i < one.points.size(); ++i) {
      line.x.push_back(one.points[i].setting);
      line.y.push_back(one.points[i].error);
      if (i + 1 == one.points.size() || one.points[i + 1].error < clear_of_uncertainty * one.points[i + 1].uncertainty)
        continue;
      slope.x.push_back(one.points[i].setting);
      slope.y.push_back(std::log2(one.points[i].error / one.points[i + 1].error));
    }
    errors.series.push_back(std::move(line));
    if (!slope.x.empty()) slopes.series.push_back(std::move(slope));  // of order 8 all is within the uncertainty
  }
  return {.name = "order-lines", .panels = {told_apart(std::move(errors)), std::move(slopes)}, .columns = 2};
}

}  // namespace

Content order(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("double_pendulum");
  const catalogue::Accuracy accuracy(file, until_s);
  std::vector<Measured> all;
  for (const catalogue::Method& method : catalogue::methods()) {
    if (method.order == 0 || !catalogue::does(method, file)) continue;
    all.push_back({&method, {}});
    if (method.make != nullptr) all.back().points = errors_of(method, accuracy);
  }
  add_orders(findings, all);

  Content content;
  content.values = {{"lost", divergence_rad},
                    {"settled", settled_slopes},
                    {"steps", halvings + 1},
                    {"until", until_s},
                    {"clear", clear_of_uncertainty}};
  content.exhibits.emplace_back(lines(all));
  content.exhibits.emplace_back(orders(all));
  return content;
}

}  // namespace odeval::experiments
