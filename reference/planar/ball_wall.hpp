#pragma once
// Two balls on rods that may both touch a flat wall without friction, and the impulses through the joints when they do.
//
// Ball k touches when d_k(q) = x of its centre - its radius - face is 0. With M the mass matrix, J the rows dd_k/dq of
// the balls at the wall and u = J qd their speeds away from it, the impulses p on them make
//
//   u+ = u + J M^-1 J' p,   u+_k >= -e u_k of those that approach, >= 0 of the others,   p >= 0,
//
// and where p_k > 0 there is equality: Newton's law of restitution with complementarity. Where both touch at once they
// share the impulse; a ball that the other's impulse drives off the wall gets none.
#include <array>
#include <cmath>
#include <cstddef>

#include "odeval/scenario.hpp"
#include "reference/planar/equations.hpp"

namespace odeval::reference {

class BallWall {
 public:
  static constexpr std::size_t balls = 2;
  using Equations = ChainEquations<double, balls>;
  using State = Equations::State;
  using PerBall = std::array<double, balls>;

  explicit BallWall(const Scenario& scenario)
      : equations_(scenario), restitution_(scenario.planar->wall.value().restitution) {
    const PlanarView& view = *scenario.planar;
    for (std::size_t k = 0; k < balls; ++k) {
      length_[k] = view.links[k].length_m;
      offset_[k] = view.frame.hinge_m[0] - view.wall->face_m - view.links[k].width_m / 2;
    }
  }

  const Equations& equations() const { return equations_; }
  double restitution() const { return restitution_; }

  /// d_k, m.
  double distance(std::size_t ball, const State& y) const {
    double x = offset_[ball];
    double angle = 0;
    for (std::size_t i = 0; i <= ball; ++i) x += length_[i] * std::cos(angle += y[i]);
    return x;
  }

  /// dd_k/dq, m/rad.
  PerBall slope(std::size_t ball, const State& y) const {
    const PerBall lever = levers(ball, y);
    return {lever[0] + lever[1], lever[1]};
  }

  /// u_k, m/s.
  double speed(std::size_t ball, const State& y) const {
    const PerBall j = slope(ball, y);
    return j[0] * y[balls] + j[1] * y[balls + 1];
  }

  /// Acceleration of ball k away from the wall in free motion, m/s².
  double pull(std::size_t ball, const State& y) const {
    State rate;
    equations_(y, rate);
    double sum = 0;
    double angle = 0, spin = 0, turning = 0;
    for (std::size_t i = 0; i <= ball; ++i) {
      angle += y[i];
      spin += y[balls + i];
      turning += rate[balls + i];
      sum -= length_[i] * (turning * std::sin(angle) + spin * spin * std::cos(angle));
    }
    return sum;
  }

  /// The state after the impact of the balls that are at the wall.
  State struck(const State& y, const std::array<bool, balls>& at_wall) const {
    std::array<PerBall, balls> response;  // change of the rates by an impulse of 1 N s on each ball
    std::array<PerBall, balls> gain;      // J M^-1 J'
    PerBall wanted;                       // least change of u
    for (std::size_t k = 0; k < balls; ++k) {
      response[k] = equations_.change_of_rates(y, levers(k, y));
      const double u = speed(k, y);
      wanted[k] = u < 0 ? -(1 + restitution_) * u : -u;
    }
    for (std::size_t k = 0; k < balls; ++k) {
      const PerBall j = slope(k, y);
      for (std::size_t l = 0; l < balls; ++l) gain[k][l] = j[0] * response[l][0] + j[1] * response[l][1];
    }
    const PerBall p = impulses(gain, wanted, at_wall);
    State after = y;
    for (std::size_t k = 0; k < balls; ++k) {
      for (std::size_t i = 0; i < balls; ++i) after[balls + i] += response[k][i] * p[k];
    }
    return after;
  }

 private:
  /// dd_k by the absolute angles.
  PerBall levers(std::size_t ball, const State& y) const {
    PerBall lever{};
    double angle = 0;
    for (std::size_t i = 0; i <= ball; ++i) lever[i] = -length_[i] * std::sin(angle += y[i]);
    return lever;
  }

  // Two unknowns: one ball alone if that suffices for the other, or both.
  static PerBall impulses(const std::array<PerBall, balls>& gain, const PerBall& wanted,
                          const std::array<bool, balls>& at_wall) {
    constexpr double rounding = 1e-12;  // m/s
    for (std::size_t k = 0; k < balls; ++k) {
      const std::size_t other = 1 - k;
      if (!at_wall[k] || wanted[k] < 0 || gain[k][k] == 0) continue;
      PerBall p{};
      p[k] = wanted[k] / gain[k][k];
      if (!at_wall[other] || gain[other][k] * p[k] >= wanted[other] - rounding) return p;
    }
    const double determinant = gain[0][0] * gain[1][1] - gain[0][1] * gain[1][0];
    return {(gain[1][1] * wanted[0] - gain[0][1] * wanted[1]) / determinant,
            (gain[0][0] * wanted[1] - gain[1][0] * wanted[0]) / determinant};
  }

  Equations equations_;
  double restitution_;
  PerBall length_{};
  PerBall offset_{};
};

}  // namespace odeval::reference
