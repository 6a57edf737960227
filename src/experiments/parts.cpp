#include "experiments/parts.hpp"
#include "model/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace odeval::experiments {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Finding;
using report::Series;
using report::Shade;

namespace {

constexpr double rounding_s = 1e-9;  // far below the least step, far above the rounding of times

}  // namespace

Series curve(std::string label, const Column& x, const Column& y, int colour, bool dashed) {
  return {std::move(label), thinned(x), thinned(y), report::Mark::line, colour, dashed};
}

Series uncertainty_curve(const Column& t, const Column& uncertainty) {
  return curve("uncertainty of the reference", t, above_zero(uncertainty), colour_of(catalogue::reference_method),
               true);
}

int colour_beside_ode(std::string_view method) {
  return method.starts_with("ode-") ? colour_of(method) : report::rest_colour;
}

report::Panel told_apart(report::Panel panel) {
  constexpr double line = 0.005;  // its width, of a plot's height
  const auto place = [&](double y) { return panel.log_y ? std::log10(y) : y; };
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Series& series : panel.series) {
    for (const double y : series.y) {
      if (!std::isfinite(place(y))) continue;
      low = std::min(low, place(y));
      high = std::max(high, place(y));
    }
  }
  constexpr double most_apart = 0.02;  // of the points: where curves cross or dip
  const auto alike = [&](const Series& a, const Series& b) {
    const bool apart_by_colour = a.colour == guide_colour || b.colour == guide_colour ||
                                 (a.colour == report::rest_colour && b.colour == report::rest_colour);
    if (apart_by_colour || a.mark != b.mark || a.x != b.x) return false;
    std::size_t apart = 0;
    for (std::size_t i = 0; i < a.y.size(); ++i) {
      const bool gaps = std::isnan(a.y[i]) && std::isnan(b.y[i]);
      if (!gaps && !(std::fabs(place(a.y[i]) - place(b.y[i])) <= line * (high - low))) ++apart;
    }
    return static_cast<double>(apart) <= most_apart * static_cast<double>(a.y.size());
  };
  std::vector<Series> kept;
  for (Series& series : panel.series) {
    const auto same = std::ranges::find_if(kept, [&](const Series& other) { return alike(other, series); });
    if (same == kept.end()) {
      kept.push_back(std::move(series));
    } else {
      same->label += " = " + series.label;
      const bool has_none = same->colour == report::rest_colour || same->colour < 0;  // that belongs to a method
      if (has_none && series.colour >= 0) same->colour = series.colour;
    }
  }
  panel.series = std::move(kept);
  return panel;
}

Span rows_between(const Column& t, double from_s, double until_s) {
  const auto first = std::lower_bound(t.begin(), t.end(), from_s - rounding_s);
  const auto end = std::upper_bound(first, t.end(), until_s + rounding_s);
  return {static_cast<std::size_t>(first - t.begin()), static_cast<std::size_t>(end - t.begin())};
}

Column part(const Column& column, const Span& span) {
  const auto begin = column.begin();
  return {begin + static_cast<std::ptrdiff_t>(span.first), begin + static_cast<std::ptrdiff_t>(span.end)};
}

Column total_energy(const Trace& trace) {
  Column energy(trace.rows());
  for (std::size_t k = 0; k < energy.size(); ++k) energy[k] = trace.kinetic[k] + trace.potential[k];
  return energy;
}

Column energy_drift(const Trace& trace) {
  Column drift = total_energy(trace);
  const double start = drift.empty() ? 0 : drift.front();
  for (double& value : drift) value -= start;
  return drift;
}

Column sizes(Column column) {
  for (double& value : column) value = std::fabs(value);
  return column;
}

Column largest_error(const Trace& trace) {
  Column largest(trace.rows(), 0.0);
  for (const Column& error : trace.error_q) {
    for (std::size_t k = 0; k < largest.size(); ++k) largest[k] = std::max(largest[k], std::fabs(error[k]));
  }
  return largest;
}

Column above_zero(Column column) {
  for (double& value : column) {
    if (!(value > 0)) value = std::numeric_limits<double>::quiet_NaN();
  }
  return column;
}

std::optional<Shade> lost_shade(Evaluator& evaluator, const Evaluation& run) {
  const Metrics metrics = evaluator.measure(run, evaluator.scenario().duration_s);
  if (metrics[quantity::divergence_time]) {
    return Shade{
        *metrics[quantity::divergence_time],
        fmt::format("the angles are off by more than {} rad, and the motion shown is another one", divergence_rad)};
  }
  if (metrics.reference_lost_at) {
    return Shade{
        *metrics.reference_lost_at,
        fmt::format("the reference knows its angles no better than {} rad, and nobody can tell", divergence_rad)};
  }
  return std::nullopt;
}

std::optional<Shade> all_lost(Evaluator& evaluator, const std::vector<const Evaluation*>& runs) {
  std::optional<Shade> last;
  for (const Evaluation* run : runs) {
    std::optional<Shade> shade = lost_shade(evaluator, *run);
    if (!shade) return std::nullopt;
    if (!last || shade->from > last->from) last = std::move(shade);
  }
  if (last) last->why = fmt::format("here all methods shown are off by more than {} rad", divergence_rad);
  return last;
}

Finding measured(std::string meaning, std::string unit, double value, double uncertainty) {
  if (!std::isfinite(value) || !std::isfinite(uncertainty)) {
    return unavailable(std::move(meaning), std::move(unit), "a run did not stay finite");
  }
  return {std::move(meaning), std::move(unit), value, uncertainty, {}};
}

Finding known_by(report::Source source, Finding finding) {
  finding.source = source;
  return finding;
}

Finding among(Finding finding, const std::vector<double>& at_neighbours) {
  if (!finding.value || at_neighbours.empty()) return finding;
  const auto [least, largest] = std::ranges::minmax(at_neighbours);
  finding.nearby = {std::min(least, *finding.value), std::max(largest, *finding.value)};
  return finding;
}

Finding measured_ratio(std::string meaning, double a, double b, double uncertainty_a, double uncertainty_b) {
  const double ratio = a / b;
  return measured(std::move(meaning), "", ratio, (uncertainty_a + std::fabs(ratio) * uncertainty_b) / std::fabs(b));
}

Finding unavailable(std::string meaning, std::string unit, std::string why) {
  return {std::move(meaning), std::move(unit), std::nullopt, 0, std::move(why)};
}

report::Cell finite_cell(const std::optional<double>& number) {
  if (number && std::isfinite(*number)) return *number;
  return report::Missing{"the run blew up"};
}

std::vector<report::Cell> row_left_out(std::vector<report::Cell> known, std::size_t columns) {
  known.resize(columns, report::Missing{std::string(catalogue::without_single_precision)});
  return known;
}

std::string left_out(const std::vector<std::string>& methods) {
  std::vector<std::pair<std::string_view, std::string>> missing;  // why, and the methods
  for (const std::string& name : methods) {
    if (available(name) != nullptr) continue;
    const std::string_view why = std::ranges::find(catalogue::methods(), name, &catalogue::Method::name)->why_missing;
    if (missing.empty() || missing.back().first != why) missing.push_back({why, ""});
    missing.back().second += (missing.back().second.empty() ? "" : ", ") + name;
  }
  std::string text;
  for (const auto& [why, names] : missing) text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", names, why);
  return text;
}

double error_until(Evaluator& evaluator, const Evaluation& run, double until_s) {
  return evaluator.measure(run, until_s)[quantity::max_error_q].value_or(std::numeric_limits<double>::quiet_NaN());
}

double uncertainty_until(Evaluator& evaluator, const Evaluation& run, double until_s) {
  return evaluator.measure(run, until_s)[quantity::reference_uncertainty].value_or(
      std::numeric_limits<double>::quiet_NaN());
}

std::string reference_known(Evaluator& evaluator, std::initializer_list<double> until_s) {
  const Reference& reference = evaluator.reference();
  std::string text;
  for (const double time : until_s) {
    const Column known = part(reference.uncertainty_q, rows_between(reference.trace.t, 0, time));
    text += fmt::format("{}{} rad until {} s", text.empty() ? "" : ", ", shown(std::ranges::max(known)), time);
  }
  return text;
}

OdeSettings half_step_started(OdeSettings settings) {
  settings.start = Start::half_step;
  return settings;
}

Scenario chain_of(const Scenario& file, std::size_t n, double until_s) {
  Scenario scenario = file;
  change_planar(scenario, [n](PlanarView& view) {
    view.links.resize(n, Link(view.links.front()));
    view.q0.resize(n, 0.0);
    view.qd0.resize(n, 0.0);
  });
  scenario.duration_s = until_s;
  scenario.sample_s = chain_rows_s;
  return scenario;
}

}  // namespace odeval::experiments
