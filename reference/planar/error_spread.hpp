#pragma once
// How far errors made on the way spread: the variational equations, applied to ellipsoids.
//
// A solver adds a small error to the state in every step, and the motion carries each of them on by its
// state-transition matrix P. Where the errors lie is an ellipsoid, held as a matrix Q: along a direction w it reaches
// sqrt(w' Q w). Carried on it is P Q P'. An error within k ellipsoids stays within k ellipsoids for as long as the
// motion is linear in it, so the ratio of two reaches is the growth of an error from one time to another.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "odeval/scenario.hpp"
#include "reference/planar/ball_wall.hpp"
#include "reference/planar/dual.hpp"
#include "reference/planar/equations.hpp"

namespace odeval::reference {

template <std::size_t Size>
using Vector = std::array<double, Size>;
template <std::size_t Size>
using Matrix = std::array<std::array<double, Size>, Size>;

template <std::size_t Size>
Matrix<Size> product(const Matrix<Size>& a, const Matrix<Size>& b) {
  Matrix<Size> c{};
  for (std::size_t i = 0; i < Size; ++i) {
    for (std::size_t k = 0; k < Size; ++k) {
      for (std::size_t j = 0; j < Size; ++j) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

template <std::size_t Size>
class Ellipsoid {
 public:
  /// Over a linear map of the state.
  void carry(const Matrix<Size>& map) {
    const Matrix<Size> half = product(map, q_);
    for (std::size_t i = 0; i < Size; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < Size; ++k) sum += half[i][k] * map[j][k];
        q_[i][j] = q_[j][i] = sum;
      }
    }
  }

  /// Adds errors, one a component, that owe nothing to those before: variances add.
  void add_independent(const Vector<Size>& error) {
    for (std::size_t i = 0; i < Size; ++i) q_[i][i] += error[i] * error[i];
  }

  /// Adds one error that owes nothing to those before, and whose components go together.
  void add_together(const Vector<Size>& error) {
    for (std::size_t i = 0; i < Size; ++i) {
      for (std::size_t j = 0; j < Size; ++j) q_[i][j] += error[i] * error[j];
    }
  }

  /// Adds errors that may point the way of those before: the ellipsoid about the sums of both,
  /// (1 + r) Q + (1 + 1/r) S for any r > 0, and smallest in trace for this one.
  void add_aligned(const Vector<Size>& error) {
    double before = 0;
    double added = 0;
    for (std::size_t i = 0; i < Size; ++i) {
      before += q_[i][i];
      added += error[i] * error[i];
    }
    const double r = before > 0 ? std::sqrt(added / before) : 0;
    if (r > 0) {
      for (auto& row : q_) {
        for (double& entry : row) entry *= 1 + r;
      }
    }
    for (std::size_t i = 0; i < Size; ++i) q_[i][i] += error[i] * error[i] * (r > 0 ? 1 + 1 / r : 1);
  }

  /// How far it reaches along a direction.
  double reach(const Vector<Size>& direction) const {
    double sum = 0;
    for (std::size_t i = 0; i < Size; ++i) {
      for (std::size_t j = 0; j < Size; ++j) sum += direction[i] * q_[i][j] * direction[j];
    }
    return std::sqrt(std::max(sum, 0.0));
  }
  /// How far it reaches in one component.
  double reach(std::size_t component) const { return std::sqrt(q_[component][component]); }

 private:
  Matrix<Size> q_{};
};

/// State-transition matrices of short steps of free motion.
template <std::size_t N>
class FreeMotion {
 public:
  static constexpr std::size_t size = 2 * N;

  explicit FreeMotion(const Scenario& scenario) : equations_(scenario) {}

  /// d(dy/dt)_i / dy_j, exact.
  Matrix<size> jacobian(const Vector<size>& y) const {
    using Variable = Dual<double, size>;
    std::array<Variable, size> variables, slopes;
    for (std::size_t i = 0; i < size; ++i) variables[i] = Variable(y[i], i);
    equations_(variables, slopes);
    Matrix<size> derivatives;
    for (std::size_t i = 0; i < size; ++i) derivatives[i] = slopes[i].slope;
    return derivatives;
  }

  /// 1 + hJ + (hJ)^2 / 2 + (hJ)^3 / 6, J the Jacobian at the state half way.
  Matrix<size> transition(const Vector<size>& middle, double h) const {
    Matrix<size> step = jacobian(middle);
    for (auto& row : step) {
      for (double& entry : row) entry *= h;
    }
    // Horner's rule.
    Matrix<size> sum{};
    for (std::size_t i = 0; i < size; ++i) sum[i][i] = 1;
    for (const double divisor : {3.0, 2.0, 1.0}) {
      sum = product(step, sum);
      for (std::size_t i = 0; i < size; ++i) {
        for (double& entry : sum[i]) entry /= divisor;
        sum[i][i] += 1;
      }
    }
    return sum;
  }

 private:
  ChainEquations<Dual<double, size>, N> equations_;
};

/// The same at an impact of one link, qd -> -e qd, where it meets the wall with the rate qd and the acceleration qdd
/// (the saltation matrix). A link that is late meets the wall late, and what it gained in speed meanwhile changes sign.
inline Matrix<2> saltation(double restitution, double qd, double qdd) {
  return {{{-restitution, 0}, {(1 + restitution) * qdd / qd, -restitution}}};
}

/// The saltation matrix of an impact of two balls: DR + (f+ - DR f-) d' / (d f-), with R the change of state, f the
/// slopes before and after it and d the gradient of the ball's distance. DR by central differences, to about 1e-9.
inline Matrix<4> saltation(const BallWall& wall, std::size_t ball, const std::array<bool, 2>& at_wall,
                           const Vector<4>& y) {
  Matrix<4> change;
  for (std::size_t j = 0; j < 4; ++j) {
    const double off = 1e-6 * std::max(1.0, std::fabs(y[j]));
    Vector<4> above = y;
    Vector<4> below = y;
    above[j] += off;
    below[j] -= off;
    const Vector<4> high = wall.struck(above, at_wall);
    const Vector<4> low = wall.struck(below, at_wall);
    for (std::size_t i = 0; i < 4; ++i) change[i][j] = (high[i] - low[i]) / (2 * off);
  }
  Vector<4> before, after;
  wall.equations()(y, before);
  wall.equations()(wall.struck(y, at_wall), after);
  const auto gradient = wall.slope(ball, y);
  const double speed = gradient[0] * before[0] + gradient[1] * before[1];
  Matrix<4> map = change;
  for (std::size_t i = 0; i < 4; ++i) {
    double jump = after[i];
    for (std::size_t k = 0; k < 4; ++k) jump -= change[i][k] * before[k];
    for (std::size_t j = 0; j < 2; ++j) map[i][j] += jump * gradient[j] / speed;
  }
  return map;
}

}  // namespace odeval::reference
