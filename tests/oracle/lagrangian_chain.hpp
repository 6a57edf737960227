#pragma once
// Lagrange's equations of a chain of revolute joints in space, from Denavit-Hartenberg parameters.
//
//   M(q) qdd = - sum_jk (dM_ij/dq_k - dM_jk/dq_i / 2) qd_j qd_k - dV/dq_i
//   M(q) = sum over links of m J_v' J_v + J_w' R I R' J_w,   V(q) = - sum of m g . c
//
// Homogeneous transforms are written out by hand and all derivatives are exact (dual numbers), so nothing is shared
// with recursive Newton-Euler, KDL, or DhChain but the meaning of the parameters.
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "reference/dh/dh_chain.hpp"
#include "reference/planar/dual.hpp"

namespace odeval::test {

template <std::size_t N>
class LagrangianChain {
 public:
  static constexpr std::size_t dof = N;
  using State = std::array<double, 2 * N>;
  using Square = std::array<std::array<double, N>, N>;
  using Variable = reference::Dual<double, N>;

  LagrangianChain(reference::DhConvention convention, std::vector<reference::DhLink> links, const Vec3& gravity)
      : convention_(convention), links_(std::move(links)), gravity_(gravity) {}

  Square mass_matrix(const std::array<double, N>& q) const {
    Square mass;
    const Energy energy = energy_at(q);
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) mass[i][j] = energy.mass[i][j].value;
    }
    return mass;
  }

  std::array<double, N> bias_forces(const State& y) const { return bias_forces(energy_of(y), y); }

  void operator()(const State& y, State& dydt) const {
    const Energy energy = energy_of(y);
    std::array<double, N> right = bias_forces(energy, y);
    Square mass;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) mass[i][j] = energy.mass[i][j].value;
    }
    // Elimination; the mass matrix is positive definite.
    for (std::size_t k = 0; k < N; ++k) {
      for (std::size_t i = k + 1; i < N; ++i) {
        const double factor = mass[i][k] / mass[k][k];
        for (std::size_t j = k; j < N; ++j) mass[i][j] -= factor * mass[k][j];
        right[i] -= factor * right[k];
      }
    }
    for (std::size_t i = N; i-- > 0;) {
      for (std::size_t j = i + 1; j < N; ++j) right[i] += mass[i][j] * dydt[N + j];
      dydt[i] = y[N + i];
      dydt[N + i] = -right[i] / mass[i][i];
    }
  }

 private:
  using Vector = std::array<Variable, 3>;

  struct Pose {
    std::array<Vector, 3> axis;  // columns of the rotation matrix: x, y, z of the frame in the base
    Vector origin;
  };
  struct Energy {
    std::array<std::array<Variable, N>, N> mass;
    Variable potential;
  };

  static Variable product(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static Vector across(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  /// The frame's axes times the components.
  static Vector turned(const Pose& frame, const Vector& v) {
    Vector sum;
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] = frame.axis[0][k] * v[0] + frame.axis[1][k] * v[1] + frame.axis[2][k] * v[2];
    }
    return sum;
  }
  /// On to a frame whose axes have these components in this one.
  static Pose moved(const Pose& frame, const std::array<Vector, 3>& axes, const Vector& origin) {
    Pose next;
    for (std::size_t k = 0; k < 3; ++k) next.axis[k] = turned(frame, axes[k]);
    const Vector shift = turned(frame, origin);
    for (std::size_t k = 0; k < 3; ++k) next.origin[k] = frame.origin[k] + shift[k];
    return next;
  }

  /// The homogeneous matrices of the textbooks (Spong et al., eq. 3.10; Craig, eq. 3.6), column by column.
  Pose moved_over(const Pose& frame, const reference::DhLink& link, const Variable& q) const {
    const Variable theta = q + link.offset_rad;
    const Variable c = cos(theta);
    const Variable s = sin(theta);
    const double ca = std::cos(link.alpha_rad);
    const double sa = std::sin(link.alpha_rad);
    if (convention_ == reference::DhConvention::standard) {
      return moved(frame, {{{c, s, 0.0}, {-s * ca, c * ca, sa}, {s * sa, -c * sa, ca}}},
                   {link.a_m * c, link.a_m * s, link.d_m});
    }
    return moved(frame, {{{c, s * ca, s * sa}, {-s, c * ca, c * sa}, {0.0, -sa, ca}}},
                 {link.a_m, -sa * link.d_m, ca * link.d_m});
  }

  Energy energy_of(const State& y) const {
    std::array<double, N> q;
    for (std::size_t i = 0; i < N; ++i) q[i] = y[i];
    return energy_at(q);
  }

  Energy energy_at(const std::array<double, N>& q) const {
    Energy energy;
    std::array<Vector, N> hinge, axis;
    Pose frame;
    for (std::size_t k = 0; k < 3; ++k) frame.axis[k][k] = 1.0;
    for (std::size_t i = 0; i < N; ++i) {
      const reference::DhLink& link = links_[i];
      const Pose before = frame;
      frame = moved_over(before, link, Variable(q[i], i));
      const Pose& joint = convention_ == reference::DhConvention::standard ? before : frame;
      hinge[i] = joint.origin;
      axis[i] = joint.axis[2];

      const Vector arm = turned(frame, {link.centre_m[0], link.centre_m[1], link.centre_m[2]});
      Vector centre;
      for (std::size_t k = 0; k < 3; ++k) {
        centre[k] = frame.origin[k] + arm[k];
        energy.potential -= link.mass_kg * gravity_[k] * centre[k];
      }
      std::array<Vector, N> velocity, spin;  // columns of J_v and of R' J_w
      for (std::size_t j = 0; j <= i; ++j) {
        Vector lever;
        for (std::size_t k = 0; k < 3; ++k) lever[k] = centre[k] - hinge[j][k];
        velocity[j] = across(axis[j], lever);
        for (std::size_t k = 0; k < 3; ++k) spin[j][k] = product(frame.axis[k], axis[j]);
      }
      const auto& in = link.inertia_kgm2;
      for (std::size_t j = 0; j <= i; ++j) {
        const Vector& w = spin[j];
        const Vector momentum{in[0] * w[0] + in[3] * w[1] + in[4] * w[2], in[3] * w[0] + in[1] * w[1] + in[5] * w[2],
                              in[4] * w[0] + in[5] * w[1] + in[2] * w[2]};
        for (std::size_t k = 0; k <= i; ++k) {
          energy.mass[j][k] += link.mass_kg * product(velocity[j], velocity[k]) + product(momentum, spin[k]);
        }
      }
    }
    return energy;
  }

  static std::array<double, N> bias_forces(const Energy& energy, const State& y) {
    std::array<double, N> bias;
    for (std::size_t i = 0; i < N; ++i) {
      bias[i] = energy.potential.slope[i];
      for (std::size_t j = 0; j < N; ++j) {
        for (std::size_t k = 0; k < N; ++k) {
          bias[i] += (energy.mass[i][j].slope[k] - energy.mass[j][k].slope[i] / 2) * y[N + j] * y[N + k];
        }
      }
    }
    return bias;
  }

  reference::DhConvention convention_;
  std::vector<reference::DhLink> links_;
  Vec3 gravity_;
};

}  // namespace odeval::test
