#pragma once
// Lagrangian equations of planar chains of uniform boxes or balls, in the report's generalized coordinates.
//
// State y = (q1..qN, qd1..qdN): q1 from the horizontal, the others relative to the link before.
// Inside, absolute angles a_i = q_1 + .. + q_i make every coefficient a constant:
//
//   sum_j K_ij cos(a_i - a_j) a_j'' = - sum_j K_ij sin(a_i - a_j) a_j'^2 - G_i cos(a_i)
//
//   K_ii = I_i + m_i c_i^2 + l_i^2 M_i       c_i to the centre of mass, M_i = sum of the masses beyond link i
//   K_ij = l_i (c_j m_j + l_j M_j), i < j    G_i = g (m_i c_i + l_i M_i)
//
// For the report's values this is its D.2 (derived in D.1) after the change of coordinates.
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "odeval/scenario.hpp"
#include "reference/planar/long_chain.hpp"

namespace odeval::reference {

template <class Real, std::size_t N>
class ChainEquations {
 public:
  static constexpr std::size_t dof = N;
  using Angles = std::array<Real, N>;
  using State = std::array<Real, 2 * N>;

  explicit ChainEquations(const Scenario& scenario) {
    const std::vector<Link>& links = scenario.planar->links;
    const Real gravity = scenario.gravity;
    Real mass_beyond = 0;
    for (std::size_t i = N; i-- > 0;) {
      const Link& link = links[i];
      const Real m = link.mass_kg;
      const Real l = link.length_m;
      const Real w = link.width_m;
      const bool box = link.shape == LinkShape::box;
      const Real c = box ? l / 2 : l;
      const Real inertia = box ? m * (l * l + w * w) / 12 : m * w * w / 10;
      coupling_[i][i] = inertia + m * c * c + l * l * mass_beyond;
      first_moment_[i] = m * c + l * mass_beyond;
      weight_moment_[i] = gravity * first_moment_[i];
      for (std::size_t h = 0; h < i; ++h) {
        coupling_[h][i] = coupling_[i][h] = Real(links[h].length_m) * first_moment_[i];
      }
      mass_beyond += m;
    }
  }

  /// dy/dt, for y and dydt of the state's layout.
  void operator()(const State& y, State& dydt) const {
    using std::cos;
    using std::sin;
    Angles angle, rate, sine, cosine;
    absolute(y, angle, rate);
    for (std::size_t i = 0; i < N; ++i) {
      sine[i] = sin(angle[i]);
      cosine[i] = cos(angle[i]);
    }
    std::array<Angles, N> inertia;
    Angles force;
    for (std::size_t i = 0; i < N; ++i) {
      force[i] = -weight_moment_[i] * cosine[i];
      for (std::size_t j = 0; j < N; ++j) {
        inertia[i][j] = coupling_[i][j] * (cosine[i] * cosine[j] + sine[i] * sine[j]);
        force[i] -= coupling_[i][j] * (sine[i] * cosine[j] - cosine[i] * sine[j]) * rate[j] * rate[j];
      }
    }
    const Angles acceleration = solve(inertia, force);
    for (std::size_t i = 0; i < N; ++i) {
      dydt[i] = y[N + i];
      dydt[N + i] = i == 0 ? acceleration[0] : acceleration[i] - acceleration[i - 1];
    }
  }

  /// Change of the rates by an impulse given as its moment about each hinge: along the absolute angles, N m s.
  Angles change_of_rates(const State& y, const Angles& moments) const {
    using std::cos;
    Angles angle, rate;
    absolute(y, angle, rate);
    std::array<Angles, N> inertia;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) inertia[i][j] = coupling_[i][j] * cos(angle[i] - angle[j]);
    }
    Angles change = solve(inertia, moments);
    for (std::size_t i = N; i-- > 1;) change[i] -= change[i - 1];
    return change;
  }

  /// Kinetic energy, J.
  Real kinetic(const State& y) const {
    using std::cos;
    Angles angle, rate;
    absolute(y, angle, rate);
    Real twice = 0;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) {
        twice += coupling_[i][j] * cos(angle[i] - angle[j]) * rate[i] * rate[j];
      }
    }
    return twice / 2;
  }

  /// Potential energy, J; 0 with all centres at the height of the first hinge.
  Real potential(const State& y) const {
    using std::sin;
    Angles angle, rate;
    absolute(y, angle, rate);
    Real sum = 0;
    for (std::size_t i = 0; i < N; ++i) sum += weight_moment_[i] * sin(angle[i]);
    return sum;
  }

  /// Absolute angles and rates of all links.
  static void absolute(const State& y, Angles& angle, Angles& rate) {
    Real a = 0;
    Real r = 0;
    for (std::size_t i = 0; i < N; ++i) {
      angle[i] = a += y[i];
      rate[i] = r += y[N + i];
    }
  }

 private:
  // Elimination without pivoting: the mass matrix is positive definite for positive masses.
  static Angles solve(std::array<Angles, N>& matrix, Angles right) {
    for (std::size_t k = 0; k < N; ++k) {
      for (std::size_t i = k + 1; i < N; ++i) {
        const Real factor = matrix[i][k] / matrix[k][k];
        for (std::size_t j = k + 1; j < N; ++j) matrix[i][j] -= factor * matrix[k][j];
        right[i] -= factor * right[k];
      }
    }
    for (std::size_t i = N; i-- > 0;) {
      for (std::size_t j = i + 1; j < N; ++j) right[i] -= matrix[i][j] * right[j];
      right[i] /= matrix[i][i];
    }
    return right;
  }

  std::array<Angles, N> coupling_{};
  Angles first_moment_{};
  Angles weight_moment_{};
};

/// Calls `use` with the equations of one or two links: the one place that turns a number of links known at run time
/// into a type. More links are LongChain's.
template <class Real = double, class Use>
auto with_equations(const Scenario& scenario, Use&& use) {
  if (scenario.planar->links.size() == 1) return use(ChainEquations<Real, 1>(scenario));
  return use(ChainEquations<Real, 2>(scenario));
}

/// The same for any number of links.
template <class Use>
auto with_any_equations(const Scenario& scenario, Use&& use) {
  if (scenario.planar->links.size() > 2) return use(LongChain<double>(scenario));
  return with_equations(scenario, std::forward<Use>(use));
}

}  // namespace odeval::reference
