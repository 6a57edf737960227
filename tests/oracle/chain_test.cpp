// Chains of many links: the O(n) equations against two others, the reference's bound against quad precision, ODE's
// joint forces and plane, and 128 links in every stepper.
#include <array>
#include <cmath>
#include <random>

#include "catalogue/evaluation.hpp"
#include "measure/order.hpp"
#include "reference/dh/dh_chain.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/extrapolation.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/long_chain_reference.hpp"
#include "reference/planar/quad.hpp"
#include "reference/planar/reference_solution.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using reference::ChainEquations;
using reference::LongChain;
using reference::Quad;

constexpr double quarter = 0.78539816339744831;  // pi / 4

/// The report's links in a row; starts as its double pendulum does, the other links level.
Scenario chain_of(std::size_t n, double duration_s, double step_s) {
  Scenario scenario = test::report_scenario("double_pendulum", duration_s, step_s);
  scenario.name = "chain";
  change_planar(scenario, [n](PlanarView& view) {
    view.links.resize(n, view.links[0]);
    view.q0.resize(n, 0.0);
    view.qd0.resize(n, 0.0);
  });
  return scenario;
}

/// Links of unlike mass, length, width and shape at any angles and rates.
Scenario uneven_chain(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  const auto from_to = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  };
  Scenario scenario = chain_of(n, 1.0, 1e-3);
  change_planar(scenario, [&](PlanarView& view) {
    for (std::size_t i = 0; i < n; ++i) {
      const double width = from_to(0.02, 0.3);
      view.links[i] = {from_to(0.3, 3), from_to(0.3, 2), width, width, i % 3 == 1 ? LinkShape::sphere : LinkShape::box};
      view.q0[i] = from_to(-2, 2);
      view.qd0[i] = from_to(-3, 3);
    }
  });
  return scenario;
}

std::vector<double> slope_of(const LongChain<double>& chain, const Scenario& scenario) {
  const auto y = reference::start_state<std::vector<double>>(*scenario.planar);
  std::vector<double> dydt(y.size());
  chain(y, dydt);
  return dydt;
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::fabs(value));
  return most;
}

// Lagrange's equations with their mass matrix share nothing with the recursion but the links. Both round: about 1e-16
// times the condition of the mass matrix, which balls of 2 cm on rods of 2 m make 1e4. Measured: 2e-13.
template <std::size_t N>
void check_against_mass_matrix() {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Scenario scenario = uneven_chain(N, seed);
    const LongChain<double> chain(scenario);
    const ChainEquations<double, N> dense(scenario);
    const auto y = reference::start_state<typename ChainEquations<double, N>::State>(*scenario.planar);
    auto wanted = y;
    dense(y, wanted);
    const std::vector<double> found = slope_of(chain, scenario);
    const double within = 3e-12 * largest(found);
    for (std::size_t i = 0; i < 2 * N; ++i) CHECK_NEAR(found[i], wanted[i], within);
    const std::vector<double> state(y.begin(), y.end());
    CHECK_NEAR(chain.kinetic(state), dense.kinetic(y), 1e-13 * dense.kinetic(y));
    CHECK_NEAR(chain.potential(state), dense.potential(y), 1e-13 * 9.81 * 3 * 2 * N * N);
  }
}

// Recursive Newton-Euler in space (Orocos KDL), a third derivation.
void check_against_kdl(std::size_t n, double within) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Scenario scenario = uneven_chain(n, seed);
    const auto standard = reference::DhConvention::standard;
    reference::DhChain kdl(standard, reference::pendulum_links(*scenario.planar, standard),
                           reference::pendulum_gravity(scenario));
    std::vector<double> wanted(n);
    kdl.accelerations(scenario.planar->q0.data(), scenario.planar->qd0.data(), wanted.data());
    const std::vector<double> found = slope_of(LongChain<double>(scenario), scenario);
    for (std::size_t i = 0; i < n; ++i) CHECK_NEAR(found[n + i], wanted[i], within * largest(found));
  }
}

// Newton's law of each link from the accelerations: what the hinges of link and next link make of it.
void check_forces() {
  const Scenario scenario = uneven_chain(7, 3);
  const LongChain<double> chain(scenario);
  const auto y = reference::start_state<std::vector<double>>(*scenario.planar);
  const std::vector<double> slope = slope_of(chain, scenario);
  const auto forces = chain.forces(y);
  double angle = 0, rate = 0, acceleration = 0;
  std::array<double, 2> hinge{0, 0};
  for (std::size_t i = 0; i < 7; ++i) {
    const Link& link = scenario.planar->links[i];
    angle += y[i];
    rate += y[7 + i];
    acceleration += slope[7 + i];
    const std::array<double, 2> end{-acceleration * std::sin(angle) - rate * rate * std::cos(angle),
                                    acceleration * std::cos(angle) - rate * rate * std::sin(angle)};
    for (std::size_t d = 0; d < 2; ++d) {
      const double beyond = i + 1 < 7 ? forces[i + 1][d] : 0.0;
      const double weight = d == 1 ? link.mass_kg * scenario.gravity : 0.0;
      CHECK_NEAR(forces[i][d] - beyond - weight, link.mass_kg * (hinge[d] + link.centre_m() * end[d]), 1e-10);
      hinge[d] += link.length_m * end[d];
    }
  }
}

// The bound covers the distance to 20 digits of the same motion, and is not so wide that it says nothing.
template <std::size_t N>
void check_bound(Scenario scenario) {
  scenario.step_s = 0.02;
  const SampleGrid grid = sample_grid(scenario);
  const Reference reference = reference::solve_reference(scenario, grid);
  reference::Extrapolation<Quad, 2 * N> extrapolation(reference::quad_order);
  const ChainEquations<Quad, N> equations(scenario);
  auto y = reference::start_state<typename ChainEquations<Quad, N>::State>(*scenario.planar);
  double worst = 0;  // error over bound
  double error_at_end = 0;
  constexpr int substeps = 10;  // 2 ms; 20 give the same to 1e-18
  for (std::size_t k = 1; k < reference.trace.rows(); ++k) {
    const Quad step = (Quad(grid.time(static_cast<long>(k))) - Quad(grid.time(static_cast<long>(k) - 1))) / substeps;
    for (int s = 0; s < substeps; ++s) extrapolation.advance(equations, y, step);
    error_at_end = 0;
    for (std::size_t i = 0; i < N; ++i) {
      const double error = std::fabs(static_cast<double>(Quad(reference.trace.q[i][k]) - y[i]));
      error_at_end = std::max(error_at_end, error);
      worst = std::max(worst, error / reference.uncertainty_q[k]);
    }
  }
  const double bound = reference.uncertainty_q.back();
  std::printf("n = %zu: error at the end %.2g, bound %.2g rad, worst error / bound %.2g\n", N, error_at_end, bound,
              worst);
  CHECK(worst < 1);
  CHECK(bound < 1e4 * error_at_end);
  CHECK(bound < 1e-7);
}

// Two links have a reference of their own, with another bound.
void check_against_double_pendulum() {
  Scenario scenario = test::report_scenario("double_pendulum", 3.0, 1e-2);
  const SampleGrid grid = sample_grid(scenario);
  const Reference two = reference::solve_reference(scenario, grid);
  const Reference many = reference::solve_long_chain(scenario, grid, reference::Tolerances{3e-15, 3e-16},
                                                     reference::Tolerances{1e-13, 1e-14});
  for (std::size_t k = 0; k < two.trace.rows(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      CHECK_NEAR(many.trace.q[i][k], two.trace.q[i][k], two.uncertainty_q[k] + many.uncertainty_q[k]);
      for (std::size_t d = 0; d < 3; ++d) {
        CHECK_NEAR(many.joint_force[i][d][k], two.joint_force[i][d][k], 1e-6);
      }
    }
    CHECK_NEAR(many.trace.kinetic[k] + many.trace.potential[k], two.trace.kinetic[0] + two.trace.potential[0], 1e-11);
  }
}

// 128 links for a second at 1 ms: no stepper fails, each is of an error that its order explains, and the reference says
// how well it knows that. Measured: 0.049, 0.092, 1.9e-6, 3.7e-5 rad, known to 6e-10. Quarter of it either way holds
// what other compilers make of rounding; an engine that is suddenly exact, or a chain that hangs still, is outside.
void check_long_chain() {
  Scenario scenario = chain_of(128, 1.0, 1e-3);
  scenario.sample_s = 0.05;
  catalogue::Evaluator evaluator(scenario);
  CHECK(evaluator.reference().uncertainty_q.back() < 1e-8);
  struct Case {
    const char* method;
    double low, high;
  };
  for (const auto& [method, low, high] :
       {Case{"ode-step-double", 0.037, 0.062}, Case{"ode-step-single", 0.037, 0.062},
        Case{"ode-quickstep-double", 0.069, 0.115}, Case{"ode-quickstep-single", 0.069, 0.115},
        Case{"ode-rk4-double", 1.4e-6, 2.5e-6}, Case{"lagrange-rk4", 2.8e-5, 4.7e-5}}) {
    if (!test::in_this_build(method)) continue;
    const catalogue::Evaluation run = evaluator.evaluate(catalogue::find_method(method));
    const Metrics metrics = evaluator.measure(run, 1.0);
    std::printf("%s: error %.3g +- %.1g rad, gap %.3g m, out of plane %.3g m, %s\n", method,
                *metrics[quantity::max_error_q], *metrics[quantity::reference_uncertainty], *metrics[quantity::max_gap],
                *metrics[quantity::max_out_of_plane], run.outcome.diverged ? run.outcome.reason.c_str() : "ok");
    CHECK(!run.outcome.diverged);
    CHECK_EQUAL(run.outcome.steps, 1000);
    CHECK_EQUAL(run.outcome.messages, 0);
    CHECK_BETWEEN(*metrics[quantity::max_error_q], low, high);
    CHECK_EQUAL(metrics[quantity::max_out_of_plane].value_or(1), 0.0);
  }
}

// Joint forces of dJointFeedback against the reference's multipliers.
// dWorldStep: first order, as the motion is. The second-order term is still seen at 0.25 to 4 ms: 1.06 to 1.16.
// ode-rk4-double: the force of its last stage, whose state is of third order (2.98 to 3.12).
void check_joint_forces(std::size_t n, const char* method, double low, double high) {
  std::vector<ErrorPoint> points;
  double before = NAN;
  for (const double h : {4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4}) {
    Scenario scenario = chain_of(n, 1.0, h);
    scenario.sample_s = 4e-3;
    catalogue::Evaluator evaluator(scenario);
    const catalogue::Evaluation run = evaluator.evaluate(catalogue::find_method(method));
    const Metrics metrics = evaluator.measure(run, 1.0);
    points.push_back({h, *metrics[quantity::max_reaction_error], 1e-9});
    std::printf("n = %zu, %s, h = %g: force error %.4g N (ratio %.3f), gap %.3g m\n", n, method, h,
                *metrics[quantity::max_reaction_error], before / *metrics[quantity::max_reaction_error],
                *metrics[quantity::max_gap]);
    before = *metrics[quantity::max_reaction_error];
    CHECK_EQUAL(metrics[quantity::max_out_of_plane].value_or(1), 0.0);
  }
  const auto order = observed_order(points, 1e3);
  std::printf("order %.3f +- %.3f\n", order->order, order->half_width);
  CHECK_BETWEEN(order->order, low, high);
}

}  // namespace

int main() {
  check_against_mass_matrix<1>();
  check_against_mass_matrix<2>();
  check_against_mass_matrix<3>();
  check_against_mass_matrix<6>();
  check_against_kdl(5, 1e-12);
  check_against_kdl(40, 1e-10);
  check_forces();
  check_against_double_pendulum();
  check_bound<3>(chain_of(3, 2.0, 0.02));
  check_bound<4>(chain_of(4, 2.0, 0.02));
  check_bound<5>(chain_of(5, 2.0, 0.02));
  check_bound<3>(uneven_chain(3, 5));
  check_bound<5>(uneven_chain(5, 6));
  for (const std::size_t n : {1u, 2u, 3u, 8u}) {
    check_joint_forces(n, "ode-step-double", 0.95, 1.2);
    check_joint_forces(n, "ode-rk4-double", 2.9, 3.2);
  }
  check_long_chain();
  return test::verdict();
}
