// Links in Cartesian coordinates: Jacobian and its rate by differences, accelerations and joint forces against the
// Lagrangian equations and Newton's law, for chains of one to five unlike links; and the box problem of contacts.
#include "reference/maximal/planar_chain.hpp"

#include <Eigen/Dense>
#include <random>

#include "model/problems.hpp"
#include "reference/maximal/box_lcp.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/generalized_state.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using maximal::BoxLcp;
using maximal::PlanarChain;

Scenario chain_of(int links, double ks, double kd) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> spread(-1.5, 1.5);
  Scenario scenario;
  scenario.gravity = 9.81;
  scenario.maximal = {ks, kd};
  PlanarView view{.frame = hanging_frame, .links = {}, .q0 = {}, .qd0 = {}, .wall = {}};
  for (int i = 0; i < links; ++i) {
    view.links.push_back({0.5 + 0.3 * i, 1.2 - 0.2 * i, 0.1 + 0.05 * i, 0.1});
    view.q0.push_back(spread(random));
    view.qd0.push_back(spread(random));
  }
  scenario.planar = std::make_shared<const PlanarView>(std::move(view));
  return scenario;
}

template <int N>
void start_keeps_the_joints() {
  const PlanarChain<N> chain(chain_of(N, 0, 0));
  const auto y = chain.start(*chain_of(N, 0, 0).planar);
  const auto at = chain.joints(y);
  CHECK_BETWEEN(at.error.cwiseAbs().maxCoeff(), 0, 1e-15 * N);  // rounding of sums of lengths of 1 m
  CHECK_BETWEEN((at.jacobian * chain.rates_of(y)).cwiseAbs().maxCoeff(), 0, 1e-14);
}

// Central differences over 1e-5 are right to their own 1e-10, and to rounding of 1e-16 / 1e-5.
template <int N>
void derivatives_are_the_differences() {
  const PlanarChain<N> chain(chain_of(N, 0, 0));
  auto y = chain.start(*chain_of(N, 0, 0).planar);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += 0.1 * std::sin(static_cast<double>(7 * k));  // joints open
  constexpr double step = 1e-5;
  const auto moved = [&](int coordinate, double by) {
    auto other = y;
    other[static_cast<std::size_t>(coordinate)] += by;
    return other;
  };
  const auto at = chain.joints(y);
  for (int k = 0; k < 3 * N; ++k) {
    const auto slope = ((chain.joints(moved(k, step)).error - chain.joints(moved(k, -step)).error) / (2 * step)).eval();
    CHECK_BETWEEN((slope - at.jacobian.col(k)).cwiseAbs().maxCoeff(), 0, 1e-9);
  }
  // Jdot qdot is d/dt (J qdot) at constant rates.
  auto later = y;
  auto earlier = y;
  chain.places_of(later) += step * chain.rates_of(y);
  chain.places_of(earlier) -= step * chain.rates_of(y);
  const auto bias =
      ((chain.joints(later).jacobian - chain.joints(earlier).jacobian) * chain.rates_of(y) / (2 * step)).eval();
  CHECK_BETWEEN((bias - at.bias).cwiseAbs().maxCoeff(), 0, 1e-9);
}

// With closed joints the feedback is silent, and both formulations have the same angular accelerations. The masses are
// alike, so the systems lose no more than two or three digits; measured 1e-13 of 100 rad/s².
template <int N>
void accelerations_are_the_lagrangian_ones() {
  const Scenario scenario = chain_of(N, 400, 40);
  const PlanarChain<N> chain(scenario);
  const auto y = chain.start(*scenario.planar);
  typename PlanarChain<N>::State dydt;
  chain(y, dydt);

  const ChainEquations<double, N> equations(scenario);
  const auto state = start_state<typename ChainEquations<double, N>::State>(*scenario.planar);
  auto rate = state;
  equations(state, rate);
  double wanted = 0;
  for (std::size_t i = 0; i < N; ++i) {
    wanted += rate[N + i];
    CHECK_NEAR(dydt[3 * N + 3 * i + 2], wanted, 1e-11);
    CHECK_EQUAL(dydt[3 * i + 2], y[3 * N + 3 * i + 2]);
  }

  // Newton: what the joints of a link and its weight add up to is its mass times its acceleration.
  const auto forces = chain.joint_forces(y);
  for (int i = 0; i < N; ++i) {
    const Link& link = scenario.planar->links[static_cast<std::size_t>(i)];
    Eigen::Vector2d sum = forces.template segment<2>(2 * i) - Eigen::Vector2d(0, link.mass_kg * scenario.gravity);
    if (i + 1 < N) sum -= forces.template segment<2>(2 * i + 2);
    const auto k = static_cast<std::size_t>(3 * N + 3 * i);
    CHECK_NEAR(sum.x(), link.mass_kg * dydt[k], 1e-11);
    CHECK_NEAR(sum.y(), link.mass_kg * dydt[k + 1], 1e-11);
  }
}

// (5.36) itself: with open joints, C'' = J qddot + Jdot qdot is what the feedback asks for.
template <int N>
void feedback_is_what_the_settings_say() {
  const PlanarChain<N> chain(chain_of(N, 30, 7));
  auto y = chain.start(*chain_of(N, 30, 7).planar);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += 0.01 * std::cos(static_cast<double>(5 * k));
  typename PlanarChain<N>::State dydt;
  chain(y, dydt);
  const auto at = chain.joints(y);
  const auto second = (at.jacobian * chain.rates_of(dydt) + at.bias).eval();
  const auto asked = (-30 * at.error - 7 * at.jacobian * chain.rates_of(y)).eval();
  CHECK_BETWEEN((second - asked).cwiseAbs().maxCoeff(), 0, 1e-11);
  CHECK(asked.cwiseAbs().minCoeff() > 1e-4);  // or nothing was tested
}

template <int N>
void check_chain() {
  start_keeps_the_joints<N>();
  derivatives_are_the_differences<N>();
  accelerations_are_the_lagrangian_ones<N>();
  feedback_is_what_the_settings_say<N>();
}

// Random positive definite problems with rows of every kind of bounds: the answer obeys its own definition.
void boxes_hold() {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  BoxLcp lcp;
  long at_bounds = 0;
  long inside = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Index n = 1 + trial % 12;
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    const Eigen::MatrixXd a = root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, [&] { return 3 * normal(random); });
    Eigen::VectorXd lo(n), hi(n), x(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto kind = (trial + i) % 4;  // free, contact, friction, bounded above
      lo[i] = kind == 1 ? 0 : kind == 2 ? -0.3 : -infinite;
      hi[i] = kind == 2 ? 0.3 : kind == 3 ? 0.1 : infinite;
    }
    CHECK(lcp.solve(n, a, b, lo, hi, x));
    const Eigen::VectorXd w = a * x - b;
    for (Eigen::Index i = 0; i < n; ++i) {
      CHECK(x[i] >= lo[i] && x[i] <= hi[i]);
      // Rounding: matrices of size 100 and answers of size 100 with condition up to 1e3.
      if (x[i] > lo[i] && x[i] < hi[i]) CHECK_NEAR(w[i], 0, 1e-9);
      if (x[i] == lo[i]) CHECK(w[i] >= 0);
      if (x[i] == hi[i]) CHECK(w[i] <= 0);
      ++(x[i] == lo[i] || x[i] == hi[i] ? at_bounds : inside);
    }
  }
  CHECK(at_bounds > 100 && inside > 100);
}

}  // namespace

int main() {
  check_chain<1>();
  check_chain<2>();
  check_chain<3>();
  check_chain<5>();
  boxes_hold();
  return test::verdict();
}
