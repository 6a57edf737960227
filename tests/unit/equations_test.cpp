// The equations of motion against Lagrange's own, from energies written in Cartesian coordinates of the links' centres.
//
// Nothing is shared with equations.hpp but the meaning of q: where the links lie follows from sums of angles, and dual
// numbers in dual numbers take all derivatives. With L = T - V the residual of joint i is
//
//   sum_j L_(qd_i qd_j) qdd_j + sum_j L_(qd_i q_j) qd_j - L_(q_i)
#include <array>
#include <cmath>
#include <cstddef>
#include <random>

#include "model/generate.hpp"
#include "reference/planar/dual.hpp"
#include "reference/planar/equations.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;

template <class Real>
struct Energies {
  Real kinetic = 0;
  Real potential = 0;
};

/// y = (q1..qN, qd1..qdN).
template <class Real, std::size_t N>
Energies<Real> energies(const Scenario& scenario, const std::array<Real, 2 * N>& y) {
  using std::cos;
  using std::sin;
  Energies<Real> sum;
  Real angle = 0, spin = 0, height = 0, forward_velocity = 0, upward_velocity = 0;  // the last three: of the near hinge
  for (std::size_t i = 0; i < N; ++i) {
    const Link& link = scenario.planar->links[i];
    angle += y[i];
    spin += y[N + i];
    const Real half_forward = 0.5 * link.length_m * cos(angle);
    const Real half_up = 0.5 * link.length_m * sin(angle);
    const Real forward = forward_velocity - spin * half_up;
    const Real upward = upward_velocity + spin * half_forward;
    const double inertia = link.mass_kg * (link.length_m * link.length_m + link.width_m * link.width_m) / 12;
    sum.kinetic += 0.5 * link.mass_kg * (forward * forward + upward * upward) + 0.5 * inertia * spin * spin;
    sum.potential += scenario.gravity * link.mass_kg * (height + half_up);
    height += 2.0 * half_up;
    forward_velocity = 2.0 * forward - forward_velocity;
    upward_velocity = 2.0 * upward - upward_velocity;
  }
  return sum;
}

template <std::size_t N>
struct Derivatives {
  std::array<double, 2 * N> first;
  std::array<std::array<double, 2 * N>, 2 * N> second;
};

template <std::size_t N>
Derivatives<N> lagrangian(const Scenario& scenario, const std::array<double, 2 * N>& y) {
  using Inner = Dual<double, 2 * N>;
  using Outer = Dual<Inner, 2 * N>;
  std::array<Outer, 2 * N> variables;
  for (std::size_t i = 0; i < 2 * N; ++i) variables[i] = Outer(Inner(y[i], i), i);
  const auto energy = energies<Outer, N>(scenario, variables);
  const Outer value = energy.kinetic - energy.potential;
  Derivatives<N> derivatives;
  for (std::size_t i = 0; i < 2 * N; ++i) {
    derivatives.first[i] = value.slope[i].value;
    derivatives.second[i] = value.slope[i].slope;
  }
  return derivatives;
}

template <std::size_t N>
void check(const Scenario& scenario) {
  const ChainEquations<double, N> equations(scenario);
  std::array<double, 2 * N> y, slope;
  for (std::size_t i = 0; i < N; ++i) {
    y[i] = scenario.planar->q0[i];
    y[N + i] = scenario.planar->qd0[i];
  }
  equations(y, slope);
  const Derivatives<N> l = lagrangian<N>(scenario, y);
  for (std::size_t i = 0; i < N; ++i) {
    double residual = -l.first[i];
    double scale = std::fabs(l.first[i]) + scenario.gravity;
    for (std::size_t j = 0; j < N; ++j) {
      residual += l.second[N + i][N + j] * slope[N + j] + l.second[N + i][j] * y[N + j];
      scale += std::fabs(l.second[N + i][N + j] * slope[N + j]) + std::fabs(l.second[N + i][j] * y[N + j]);
      CHECK_EQUAL(slope[j], y[N + j]);
    }
    // Rounding: about twenty operations on numbers of the size of `scale`. A wrong sign or inertia leaves a part of
    // one.
    CHECK_NEAR(residual / scale, 0.0, 1e-14);
  }
  const auto energy = energies<double, N>(scenario, y);
  CHECK_NEAR(equations.kinetic(y), energy.kinetic, 1e-14 * (1 + energy.kinetic));
  CHECK_NEAR(equations.potential(y), energy.potential, 1e-14 * (1 + 10 * scenario.gravity * static_cast<double>(N)));
}

Scenario random_chain(std::mt19937& random, std::size_t links) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Scenario scenario;
  scenario.gravity = between(1, 20);
  PlanarView view{.frame = hanging_frame, .links = {}, .q0 = {}, .qd0 = {}, .wall = {}};
  for (std::size_t i = 0; i < links; ++i) {
    view.links.push_back({between(0.1, 3), between(0.2, 2), between(0.02, 0.5), between(0.02, 0.5)});
    view.q0.push_back(between(-4, 4));
    view.qd0.push_back(between(-5, 5));
  }
  scenario.planar = std::make_shared<const PlanarView>(std::move(view));
  return scenario;
}

}  // namespace

int main() {
  std::mt19937 random(1);
  for (int k = 0; k < 100; ++k) {
    check<1>(random_chain(random, 1));
    check<2>(random_chain(random, 2));
  }
  return odeval::test::verdict();
}
