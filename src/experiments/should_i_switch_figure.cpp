// The figure of "Should I switch?": error over CPU time, one curve an engine.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "experiments/parts.hpp"
#include "experiments/should_i_switch.hpp"

namespace odeval::experiments::engines {
namespace {

struct Library {
  std::string_view prefix;  // of its methods' names
  std::string_view label;
  int colour;
};
constexpr std::array libraries{Library{"mujoco", "MuJoCo", variant(1)}, Library{"bullet", "Bullet", variant(3)},
                               Library{"dart", "DART", variant(2)}, Library{"simbody", "Simbody", variant(4)}};

/// Less is better: first those that keep the budget, by their time, then the others, by their error.
std::tuple<bool, double> rank(const Tried& tried) {
  return {!tried.keeps, tried.keeps ? tried.us_per_s : tried.best.error};
}

}  // namespace

std::vector<Curve> curves_of(const Result& result) {
  std::vector<Curve> curves;
  const auto best = [&](std::string_view label, int colour, auto is_one) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < result.ways.size(); ++i) {
      if (!is_one(result.ways[i])) continue;
      if (!found || rank(result.tried[i]) < rank(result.tried[*found])) found = i;
    }
    if (found) curves.push_back({label, colour, *found});
  };
  best("ODE as it is", colour_of("ode-step-double"), [](const Way& way) { return way.move == Move::stay; });
  best("accurate_step", colour_of("ode-rk4-double"), [](const Way& way) { return way.move == Move::accurate_step; });
  for (const Library& library : libraries) {
    best(library.label, library.colour, [&](const Way& way) { return way.method->name.starts_with(library.prefix); });
  }
  return curves;
}

report::Panel panel_of(std::string title, const Stage& stage, const Result& result) {
  const Quantity& quantity = quantities[stage.quantity];
  report::Panel panel{.title = std::move(title),
                      .x_label = "CPU time of a simulated second, s",
                      .y_label = fmt::format("largest error, {}", quantity.unit),
                      .log_x = true,
                      .log_y = true};
  double least = INFINITY;
  double most = 0;
  for (const Curve& curve : curves_of(result)) {
    report::Series series{std::string(curve.label), {}, {}, report::Mark::line_and_points, curve.colour};
    for (const Rung& rung : result.tried[curve.way].rungs) {
      if (!std::isfinite(rung.us_per_s)) continue;
      series.x.push_back(1e-6 * rung.us_per_s);
      series.y.push_back(rung.error);
      least = std::min(least, series.x.back());
      most = std::max(most, series.x.back());
    }
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  panel.series.push_back(
      {"error to keep", {least, most}, {stage.budget, stage.budget}, report::Mark::line, guide_colour, true});
  return panel;
}

}  // namespace odeval::experiments::engines
