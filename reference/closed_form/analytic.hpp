#pragma once
// The motion of one link in closed form: elliptic functions between impacts, energy at each impact.
//
// With phi the angle from hanging, phi'' = -omega^2 sin(phi), omega^2 = m g c / I about the hinge, and
// w^2 = (phi'/2)^2 + omega^2 sin^2(phi/2) constant:
//
//   libration, w < omega   sin(phi/2) = k sn(u, k), phi' = 2 w cn(u, k), u = u0 + omega t, k = w / omega
//   rotation,  w > omega   phi/2 = am(u, k),        phi' = 2 w dn(u, k), u = u0 + w t,     k = omega / w
//
// Every number comes from 1 - k^2, which is known to all its digits from the start's distance to the upper
// equilibrium, and not from k, which has lost them near the separatrix k = 1.
//
// Accuracy reached (tests/unit/analytic_test.cpp): within four times what a change of gravity or of the start in its
// sixteenth digit would make, near the separatrix too. For motions that do not amplify that is 3e-15 rad in the first
// second and 2e-12 rad in 1000 s, where the rounding of omega alone shifts the phase by as much.
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// One link without a wall, from any start: libration, rotation, the separatrix, rest, no gravity.
class FreePendulum {
 public:
  using State = std::array<double, 2>;  // q (rad, from the horizontal, unwrapped), qd (rad/s)

  FreePendulum(const Scenario& scenario, const State& start);

  State at(double t_s) const;

  struct Passage {
    double t_s;
    double qd;  // from the conservation of energy
  };

  /// The first passage of an angle with rising (or falling) q; nothing if there is none. An angle that the start has
  /// reached in this direction up to rounding is passed at once.
  std::optional<Passage> passage(double q, bool rising) const;

 private:
  double phase_at(double sine, double cosine, double delta_squared) const;

  State start_;
  double omega_;           // rad/s, of small oscillations
  double bottom_;          // rad, the hanging angle nearest the start
  double offset_;          // rad, phi of the start, within +-pi
  double w_;               // rad/s
  bool rotates_;           // or is on the separatrix
  double sense_ = 1;       // of rotation
  double complement_ = 1;  // 1 - k^2
  double quarter_ = 0;     // K(k), infinite on the separatrix
  double phase_ = 0;       // u0
};

/// A single pendulum or one against a wall, with all its impacts up to a time.
class ClosedFormPendulum {
 public:
  ClosedFormPendulum(const Scenario& scenario, double until_s);

  /// The state at 0 <= t <= until; at the very time of an impact the one before it.
  FreePendulum::State at(double t_s) const;

  /// Impacts (without overlap, so depth 0), and when the link came to rest, if it did.
  const Outcome& outcome() const { return outcome_; }

 private:
  struct Piece {
    double begin_s;
    FreePendulum swing;
  };

  std::vector<Piece> pieces_;
  FreePendulum::State rest_{};
  Outcome outcome_;
};

/// One link; with a wall or without.
bool has_closed_form(const PlanarView& view);

/// Method analytic: of one link, or where there are no joint coordinates of bodies (body_solution.hpp).
/// Throws UserError for a scenario without a closed form. Outcome::steps counts the samples after t = 0.
std::unique_ptr<Simulation> make_analytic(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
