#pragma once
// A chain of N hinges in space in generalized coordinates, by Lagrange: an oracle that knows no constraint.
//
//   M(q) q'' = -C(q, q') - V'(q),  C_i = sum_jk (dM_ij/dq_k - dM_jk/dq_i / 2) q'_j q'_k
//
// M = sum over links of m Jv' Jv + Jw' I Jw, its derivatives by dual numbers. A ball joint is three hinges in a point,
// the first two without a link.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "reference/cvode_solver.hpp"
#include "reference/planar/dual.hpp"

namespace odeval::test {

template <std::size_t N>
class SpatialChain {
 public:
  struct Hinge {
    Eigen::Vector3d axis;                              // unit, frame of the link before (or the world), at q = 0 of all
    Eigen::Vector3d offset;                            // from the hinge before, frame of the link before
    double mass = 0;                                   // of the link after it
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // from this hinge, frame of the link
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the centre, frame of the link
  };
  using Vector = Eigen::Matrix<double, static_cast<int>(N), 1>;

  SpatialChain(std::array<Hinge, N> hinges, double gravity) : hinges_(std::move(hinges)), gravity_(gravity) {}

  Vector acceleration(const Vector& q, const Vector& qd) const {
    using Dual = reference::Dual<double, N>;
    std::array<Dual, N> angles;
    for (std::size_t i = 0; i < N; ++i) angles[i] = Dual(q[static_cast<Eigen::Index>(i)], i);
    std::array<std::array<Dual, N>, N> mass{};
    Dual potential(0.0);
    inertia(angles, mass, potential);
    Eigen::Matrix<double, static_cast<int>(N), static_cast<int>(N)> m;
    Vector force;
    for (std::size_t i = 0; i < N; ++i) {
      double sum = -potential.slope[i];
      for (std::size_t j = 0; j < N; ++j) {
        m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = mass[i][j].value;
        for (std::size_t k = 0; k < N; ++k) {
          sum -= (mass[i][j].slope[k] - mass[j][k].slope[i] / 2) * qd[static_cast<Eigen::Index>(j)] *
                 qd[static_cast<Eigen::Index>(k)];
        }
      }
      force[static_cast<Eigen::Index>(i)] = sum;
    }
    return m.ldlt().solve(force);
  }

  /// The angles at t, by CVODE.
  Vector at(double t, const Vector& q, const Vector& qd) const {
    reference::CvodeSolver solver(
        2 * N,
        [this](double, const double* y, double* f) {
          const Eigen::Map<const Vector> angle(y), rate(y + N);
          Eigen::Map<Vector>(f, static_cast<Eigen::Index>(N)) = rate;
          Eigen::Map<Vector>(f + N, static_cast<Eigen::Index>(N)) = acceleration(angle, rate);
        },
        {1e-13, 1e-14}, "spatial chain", t);
    std::array<double, 2 * N> y;
    Eigen::Map<Vector>(y.data()) = q;
    Eigen::Map<Vector>(y.data() + N) = qd;
    solver.start(0, y.data());
    while (solver.end() < t) solver.step();
    solver.interpolate(t, y.data());
    return Eigen::Map<Vector>(y.data());
  }

  struct Frame {
    Eigen::Vector3d hinge;   // world
    Eigen::Vector3d axis;    // world
    Eigen::Matrix3d turn;    // of the link after it
    Eigen::Vector3d centre;  // world
  };
  std::array<Frame, N> frames(const Vector& q) const {
    std::array<Frame, N> all;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Vector3d hinge = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < N; ++i) {
      hinge += turn * hinges_[i].offset;
      const Eigen::Vector3d axis = turn * hinges_[i].axis;
      turn = turn * Eigen::AngleAxisd(q[static_cast<Eigen::Index>(i)], hinges_[i].axis).toRotationMatrix();
      all[i] = {hinge, axis, turn, hinge + turn * hinges_[i].centre};
    }
    return all;
  }

 private:
  template <class Real>
  using Vec = std::array<Real, 3>;
  template <class Real>
  static Vec<Real> cross(const Vec<Real>& a, const Vec<Real>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  template <class Real>
  static Real dot(const Vec<Real>& a, const Vec<Real>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  template <class Real>
  using Mat = std::array<Vec<Real>, 3>;  // rows
  template <class Real>
  static Vec<Real> times(const Mat<Real>& m, const Eigen::Vector3d& v) {
    Vec<Real> r;
    for (std::size_t i = 0; i < 3; ++i) r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return r;
  }

  template <class Real>
  void inertia(const std::array<Real, N>& q, std::array<std::array<Real, N>, N>& mass, Real& potential) const {
    Mat<Real> turn{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    Vec<Real> hinge{0.0, 0.0, 0.0};
    std::array<Vec<Real>, N> axes, places;
    for (std::size_t i = 0; i < N; ++i) {
      const Hinge& h = hinges_[i];
      const Vec<Real> step = times(turn, h.offset);
      for (std::size_t k = 0; k < 3; ++k) hinge[k] += step[k];
      axes[i] = times(turn, h.axis);
      places[i] = hinge;
      turn = turned(turn, h.axis, q[i]);
      if (h.mass == 0) continue;

      const Vec<Real> arm = times(turn, h.centre);
      Vec<Real> centre;
      for (std::size_t k = 0; k < 3; ++k) centre[k] = hinge[k] + arm[k];
      potential += h.mass * gravity_ * centre[2];
      std::array<Vec<Real>, N> moves, spins;  // of the centre in the world, of the link in its own frame
      for (std::size_t j = 0; j <= i; ++j) {
        Vec<Real> from;
        for (std::size_t k = 0; k < 3; ++k) from[k] = centre[k] - places[j][k];
        moves[j] = cross(axes[j], from);
        for (std::size_t k = 0; k < 3; ++k) {
          spins[j][k] = turn[0][k] * axes[j][0] + turn[1][k] * axes[j][1] + turn[2][k] * axes[j][2];
        }
      }
      for (std::size_t j = 0; j <= i; ++j) {
        for (std::size_t k = 0; k <= i; ++k) {
          Real sum = h.mass * dot(moves[j], moves[k]);
          for (std::size_t a = 0; a < 3; ++a) {
            for (std::size_t b = 0; b < 3; ++b) {
              sum += h.inertia(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) * spins[j][a] * spins[k][b];
            }
          }
          mass[j][k] += sum;
        }
      }
    }
  }

  /// turn times the rotation by `angle` about a unit axis (Rodrigues).
  template <class Real>
  static Mat<Real> turned(const Mat<Real>& turn, const Eigen::Vector3d& n, const Real& angle) {
    const Real s = sin(angle);
    const Real c = cos(angle);
    const Real d = Real(1.0) - c;
    const Mat<Real> r{{{c + d * n[0] * n[0], d * n[0] * n[1] - s * n[2], d * n[0] * n[2] + s * n[1]},
                       {d * n[1] * n[0] + s * n[2], c + d * n[1] * n[1], d * n[1] * n[2] - s * n[0]},
                       {d * n[2] * n[0] - s * n[1], d * n[2] * n[1] + s * n[0], c + d * n[2] * n[2]}}};
    Mat<Real> product;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        product[i][j] = turn[i][0] * r[0][j] + turn[i][1] * r[1][j] + turn[i][2] * r[2][j];
      }
    }
    return product;
  }

  std::array<Hinge, N> hinges_;
  double gravity_;
};

}  // namespace odeval::test
