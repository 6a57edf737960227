#pragma once
// Scenarios for tests, filled by hand, and short ways to run them.
#include <algorithm>
#include <cmath>
#include <ranges>
#include <string_view>

#include "catalogue/evaluation.hpp"
#include "model/problems.hpp"

namespace odeval::test {

inline const Problem* problem(std::string_view name) { return &*std::ranges::find(problems, name, &Problem::name); }

/// The problems of that family alone.
inline auto problems_of(Family family) {
  return problems | std::views::filter([family](const Problem& problem) { return problem.family == family; });
}
inline auto pendulums() { return problems_of(Family::pendulum); }

/// The report's values (claims: Parameters), with the engine settings of its C.4 where it gives them.
inline Scenario report_scenario(std::string_view name, double duration_s, double step_s) {
  constexpr double quarter = 0.78539816339744831;  // pi / 4
  Scenario scenario;
  scenario.name = name;
  scenario.problem = problem(name);
  scenario.duration_s = duration_s;
  scenario.step_s = step_s;
  const int links = scenario.problem->links == 0 ? 3 : scenario.problem->links;  // 0: any number
  scenario.links.assign(static_cast<std::size_t>(links), Link{1.0, 1.0, 0.1, 0.1});
  scenario.q0.assign(scenario.links.size(), 0.0);
  scenario.qd0.assign(scenario.links.size(), 0.0);
  scenario.ode.max_correcting_vel = 0.1;
  scenario.ode.surface_layer = 1e-4;
  if (name == "double_pendulum") scenario.q0 = {quarter, -quarter};
  if (name == "chain") scenario.q0 = {quarter, -quarter, 0};
  if (name == "potra_pendulum") {
    scenario.q0 = {-0.52359877559829882, -0.41887902047863906};  // -pi/6, -2 pi/15
    // Larger balls than the scenario file's: twenty iterations of QuickStep do not hold points on rods together.
    for (Link& link : scenario.links) link = {1.0, 1.0, 0.1, 0.1, Shape::sphere};
    scenario.wall = Wall{-0.05, 0.1};
    scenario.ode.cfm = 1e-10;
    scenario.ode.iterations = 200;
  } else if (scenario.problem->wall) {
    scenario.gravity = 9.8;
    scenario.wall = Wall{0.9, 1.0};
    scenario.ode = OdeSettings{};
    scenario.ode.cfm = 1e-10;
  }
  return scenario;
}

/// Largest angle error of a method over the whole run, rad.
inline double angle_error(const Scenario& scenario, std::string_view method) {
  catalogue::Evaluator evaluator(scenario);
  const catalogue::Evaluation run = evaluator.evaluate(catalogue::find_method(method));
  return evaluator.measure(run, scenario.duration_s)[quantity::max_error_q].value();
}

inline bool in_this_build(std::string_view method) {
  const auto all = catalogue::methods();
  return std::ranges::find(all, method, &catalogue::Method::name)->make != nullptr;
}

}  // namespace odeval::test
