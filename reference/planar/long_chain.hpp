#pragma once
// The equations of equations.hpp for any number of links, at a cost in proportion to it.
//
// State y = (q1..qn, qd1..qdn). Seen from its near hinge, which is accelerated by p, all of the chain from link i on
// answers with the force of its hinge f_i = A_i p + b_i. With e along link i and t across it (t = axis x e), A and b
// those of the link beyond (0 past the end) and g the gravity as an upward acceleration, Newton's and Euler's laws give
//
//   D = I + m c^2 + l^2 t.A t        w = m c t + l A t      v = b - l a'^2 A e
//   u = m c t.g + l t.v              a'' = -(w.p + u) / D
//   A_i = A + m 1 - w w' / D         b_i = v - m c a'^2 e + m g - w u / D
//
// on the way in, and on the way out from p = 0 at the first hinge: a'', then p of the next, p + l (a'' t - a'^2 e).
// This is the articulated-body recursion (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7) in the
// plane. No matrix of the whole chain is formed.
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "odeval/scenario.hpp"
#include "reference/planar/point_in_plane.hpp"

namespace odeval::reference {

template <class Real>
class LongChain {
 public:
  static constexpr std::size_t dof = 0;  // as many as the scenario has links
  using State = std::vector<Real>;
  using InPlane = std::array<Real, 2>;  // along `horizontal` and `up`

  explicit LongChain(const Scenario& scenario) : gravity_(scenario.gravity), links_(scenario.planar->links.size()) {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const Link& link = scenario.planar->links[i];
      const Real m = link.mass_kg;
      const Real l = link.length_m;
      const Real w = link.width_m;
      const bool box = link.shape == LinkShape::box;
      links_[i].mass = m;
      links_[i].length = l;
      links_[i].centre = box ? l / 2 : l;
      links_[i].inertia = box ? m * (l * l + w * w) / 12 : m * w * w / 10;
    }
  }

  std::size_t size() const { return links_.size(); }

  /// dy/dt; `dydt` has the size of y. Works in memory of its own, so one object serves one thread.
  void operator()(const State& y, State& dydt) const {
    accelerate(y);
    Real before = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      dydt[i] = y[size() + i];
      dydt[size() + i] = links_[i].acceleration - before;
      before = links_[i].acceleration;
    }
  }

  /// Force of each hinge on its link at a state, N.
  std::vector<InPlane> forces(const State& y) const {
    accelerate(y);
    std::vector<InPlane> all;
    for (const Moving& link : links_) {
      all.push_back({link.a * link.near[0] + link.b * link.near[1] + link.free[0],
                     link.b * link.near[0] + link.d * link.near[1] + link.free[1]});
    }
    return all;
  }

  /// Kinetic energy, J.
  Real kinetic(const State& y) const {
    turn(y);
    Real twice = 0;
    PointInPlane<Real> hinge{};
    for (const Moving& link : links_) {
      const PointInPlane<Real> centre = link.point(hinge, link.centre);
      twice += link.mass * (centre.vx * centre.vx + centre.vy * centre.vy) + link.inertia * link.rate * link.rate;
      hinge = link.point(hinge, link.length);
    }
    return twice / 2;
  }

  /// Potential energy, J; 0 with all centres at the height of the first hinge.
  Real potential(const State& y) const {
    turn(y);
    Real sum = 0;
    PointInPlane<Real> hinge{};
    for (const Moving& link : links_) {
      sum += link.mass * gravity_ * link.point(hinge, link.centre).y;
      hinge = link.point(hinge, link.length);
    }
    return sum;
  }

 private:
  struct Moving {
    Real mass, length, centre, inertia;
    Real cosine, sine, rate;  // of the absolute angle
    Real a, b, d;             // A_i = (a b; b d)
    InPlane free;             // b_i
    InPlane lever;            // w
    Real inertia_seen, load;  // D, u
    InPlane near;             // p
    Real acceleration;        // a''

    PointInPlane<Real> point(const PointInPlane<Real>& near_hinge, const Real& s) const {
      return near_hinge.along(s, cosine, sine, rate);
    }
  };

  void turn(const State& y) const {
    using std::cos;
    using std::sin;
    Real angle = 0;
    Real rate = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      angle += y[i];
      rate += y[size() + i];
      links_[i].cosine = cos(angle);
      links_[i].sine = sin(angle);
      links_[i].rate = rate;
    }
  }

  void accelerate(const State& y) const {
    turn(y);
    Real a = 0;
    Real b = 0;
    Real d = 0;
    InPlane free{0, 0};
    for (std::size_t i = size(); i-- > 0;) {
      Moving& link = links_[i];
      const Real squared = link.rate * link.rate;
      const Real mc = link.mass * link.centre;
      const InPlane e{link.cosine, link.sine};
      const InPlane t{-link.sine, link.cosine};
      const InPlane at{a * t[0] + b * t[1], b * t[0] + d * t[1]};
      const Real pull = link.length * squared;
      const InPlane v{free[0] - pull * (a * e[0] + b * e[1]), free[1] - pull * (b * e[0] + d * e[1])};
      const InPlane w{mc * t[0] + link.length * at[0], mc * t[1] + link.length * at[1]};
      const Real seen = link.inertia + mc * link.centre + link.length * link.length * (t[0] * at[0] + t[1] * at[1]);
      const Real load = mc * t[1] * gravity_ + link.length * (t[0] * v[0] + t[1] * v[1]);
      a += link.mass - w[0] * w[0] / seen;
      b -= w[0] * w[1] / seen;
      d += link.mass - w[1] * w[1] / seen;
      free = {v[0] - mc * squared * e[0] - w[0] * load / seen,
              v[1] - mc * squared * e[1] - w[1] * load / seen + link.mass * gravity_};
      link.a = a;
      link.b = b;
      link.d = d;
      link.free = free;
      link.lever = w;
      link.inertia_seen = seen;
      link.load = load;
    }
    InPlane near{0, 0};
    for (Moving& link : links_) {
      link.near = near;
      link.acceleration = -(link.lever[0] * near[0] + link.lever[1] * near[1] + link.load) / link.inertia_seen;
      const Real across = link.length * link.acceleration;
      const Real along = link.length * link.rate * link.rate;
      near[0] -= across * link.sine + along * link.cosine;
      near[1] += across * link.cosine - along * link.sine;
    }
  }

  Real gravity_;
  mutable std::vector<Moving> links_;
};

}  // namespace odeval::reference
