#pragma once
// A pendulum's links as rigid bodies in their plane, held together by Lagrange multipliers (report 5.3).
//
// Each link has its own x, y and angle, mass matrix diag(m, m, I) and W its inverse. Joint i makes two conditions C =
// 0: the near end of link i is where the far end of the link before is, or at the first hinge. Their multipliers are
// the joint's force on link i, and with Q_a the weights
//
//   J W J^T lambda = -Jdot qdot - J W Q_a - ks C - kd Cdot   (5.38; with ks = kd = 0 it is 5.34, and 5.13 solved for
//   qddot = W (Q_a + J^T lambda)                              the multipliers)
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "odeval/scenario.hpp"
#include "reference/maximal/links_in_plane.hpp"

namespace odeval::reference::maximal {

template <int N>
class PlanarChain {
 public:
  static constexpr int coordinates = 3 * N;
  static constexpr int conditions = 2 * N;
  using State = std::array<double, 2 * coordinates>;  // (x1, y1, angle1, x2, ..), then their rates
  using Coordinates = Eigen::Matrix<double, coordinates, 1>;
  using Conditions = Eigen::Matrix<double, conditions, 1>;
  using Jacobian = Eigen::Matrix<double, conditions, coordinates>;
  using System = Eigen::Matrix<double, conditions, conditions>;

  /// What the joints say at a state.
  struct Joints {
    Conditions error;   // C, m
    Jacobian jacobian;  // J
    Conditions bias;    // Jdot qdot, m/s²
  };

  explicit PlanarChain(const Scenario& scenario) : ks_(scenario.maximal.ks), kd_(scenario.maximal.kd) {
    for (int i = 0; i < N; ++i) {
      const Link& link = scenario.planar->links[static_cast<std::size_t>(i)];
      to_near_[i] = link.centre_m();
      to_far_[i] = link.beyond_centre_m();
      inverse_mass_.template segment<3>(3 * i) << 1 / link.mass_kg, 1 / link.mass_kg, 1 / link.inertia_kgm2();
      weight_.template segment<3>(3 * i) << 0, -link.mass_kg * scenario.gravity, 0;
    }
  }

  static State start(const PlanarView& view) {
    State y{};
    std::size_t k = 0;
    for (const LinkInPlane& link : links_at_start(view)) {
      y[k] = link.x;
      y[k + 1] = link.y;
      y[k + 2] = link.angle;
      y[k + coordinates] = link.vx;
      y[k + coordinates + 1] = link.vy;
      y[k + coordinates + 2] = link.rate;
      k += 3;
    }
    return y;
  }

  /// dy/dt.
  void operator()(const State& y, State& dydt) const {
    const Joints at = joints(y);
    rates_of(dydt) = acceleration(at, multipliers(at, rates_of(y)));
    places_of(dydt) = rates_of(y);
  }

  /// Joint i's force on link i at a state, N, in the plane: entries 2i and 2i + 1.
  Conditions joint_forces(const State& y) const { return multipliers(joints(y), rates_of(y)); }

  Joints joints(const State& y) const {
    const auto q = places_of(y);
    const auto qd = rates_of(y);
    Joints at;
    at.jacobian.setZero();
    for (int i = 0; i < N; ++i) {
      const auto rows = Eigen::seqN(2 * i, 2);
      const Eigen::Vector2d near = to_near_[i] * along(q[3 * i + 2]);
      at.error(rows) = q.template segment<2>(3 * i) - near;
      at.bias(rows) = near * qd[3 * i + 2] * qd[3 * i + 2];
      at.jacobian.template block<2, 2>(2 * i, 3 * i).setIdentity();
      at.jacobian.template block<2, 1>(2 * i, 3 * i + 2) = -across(near);
      if (i == 0) continue;
      const int p = i - 1;
      const Eigen::Vector2d far = to_far_[p] * along(q[3 * p + 2]);
      at.error(rows) -= q.template segment<2>(3 * p) + far;
      at.bias(rows) += far * qd[3 * p + 2] * qd[3 * p + 2];
      at.jacobian.template block<2, 2>(2 * i, 3 * p) = -Eigen::Matrix2d::Identity();
      at.jacobian.template block<2, 1>(2 * i, 3 * p + 2) = -across(far);
    }
    return at;
  }

  /// J W J^T.
  System system(const Joints& at) const { return at.jacobian * inverse_mass_.asDiagonal() * at.jacobian.transpose(); }

  Coordinates acceleration(const Joints& at, const Conditions& forces) const {
    return inverse_mass_.cwiseProduct(weight_ + at.jacobian.transpose() * forces);
  }

  static auto places_of(State& y) { return Eigen::Map<Coordinates>(y.data()); }
  static auto places_of(const State& y) { return Eigen::Map<const Coordinates>(y.data()); }
  static auto rates_of(State& y) { return Eigen::Map<Coordinates>(y.data() + coordinates); }
  static auto rates_of(const State& y) { return Eigen::Map<const Coordinates>(y.data() + coordinates); }

 private:
  static Eigen::Vector2d along(double angle) { return {std::cos(angle), std::sin(angle)}; }
  static Eigen::Vector2d across(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

  Conditions multipliers(const Joints& at, const Coordinates& qd) const {
    const Conditions right =
        -at.bias - at.jacobian * inverse_mass_.cwiseProduct(weight_) - ks_ * at.error - kd_ * (at.jacobian * qd);
    return system(at).llt().solve(right);
  }

  double ks_;
  double kd_;
  Eigen::Matrix<double, N, 1> to_near_, to_far_;
  Coordinates inverse_mass_;
  Coordinates weight_;
};

}  // namespace odeval::reference::maximal
