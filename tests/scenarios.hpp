#pragma once
// Scenarios for tests, filled by hand, and short ways to run them.
#include <algorithm>
#include <cmath>
#include <ranges>
#include <string_view>

#include "catalogue/evaluation.hpp"
#include "model/generate.hpp"
#include "model/problems.hpp"
#include "reference/providers.hpp"

namespace odeval::test {

inline const Problem& problem(std::string_view name) { return *std::ranges::find(problems, name, &Problem::name); }

/// The problems with joint coordinates.
inline auto planar_problems() { return problems | std::views::filter(&Problem::planar); }

/// Balls against a wall instead of boxes: larger ones than the scenario file's, since twenty iterations of QuickStep do
/// not hold points on rods together.
inline void set_balls(Scenario& scenario, PlanarView& view) {
  view.q0 = {-0.52359877559829882, -0.41887902047863906};  // -pi/6, -2 pi/15
  for (Link& link : view.links) link = {1.0, 1.0, 0.1, 0.1, LinkShape::sphere};
  view.wall = Wall{-0.05, 0.1};
  scenario.ode.cfm = 1e-10;
  scenario.ode.iterations = 200;
}

/// The report's values (claims: Parameters), with the engine settings of its C.4 where it gives them.
inline Scenario report_scenario(std::string_view name, double duration_s, double step_s) {
  constexpr double quarter = 0.78539816339744831;  // pi / 4
  const Problem& what = problem(name);
  Scenario scenario;
  scenario.name = name;
  scenario.duration_s = duration_s;
  scenario.step_s = step_s;
  scenario.ode.max_correcting_vel = 0.1;
  scenario.ode.surface_layer = 1e-4;
  if (!what.planar) return scenario;
  const std::size_t links = what.links == 0 ? 3 : static_cast<std::size_t>(what.links);  // 0: any number
  PlanarView view{
      what.frame, std::vector(links, Link{1.0, 1.0, 0.1, 0.1}), std::vector(links, 0.0), std::vector(links, 0.0), {}};
  if (name == "double_pendulum") view.q0 = {quarter, -quarter};
  if (name == "chain") view.q0 = {quarter, -quarter, 0};
  if (name == "potra_pendulum") {
    set_balls(scenario, view);
  } else if (what.wall) {
    scenario.gravity = 9.8;
    view.wall = Wall{0.9, 1.0};
    scenario.ode = OdeSettings{};
    scenario.ode.cfm = 1e-10;
  }
  put_planar(scenario, std::move(view));
  return scenario;
}

/// Largest angle error of a method over the whole run, rad.
inline double angle_error(const Scenario& scenario, std::string_view method) {
  catalogue::Evaluator evaluator(scenario);
  const catalogue::Evaluation run = evaluator.evaluate(catalogue::find_method(method));
  return evaluator.measure(run, scenario.duration_s)[quantity::max_error_q].value();
}

inline bool in_this_build(std::string_view method) {
  return std::ranges::find(catalogue::methods(), method, &catalogue::Method::name)->make != nullptr;
}

inline bool has_reference(const Scenario& scenario) {
  return std::ranges::any_of(reference::providers(),
                             [&](const ReferenceProvider& provider) { return provider.supports(scenario); });
}

}  // namespace odeval::test
