#pragma once
// How a rigid body turns that no torque acts on, in closed form.
//
// Euler's equations in Jacobi elliptic functions (L. D. Landau, E. M. Lifshitz, Mechanics, section 37), and the
// attitude by Euler's angles about the angular momentum L, which keeps its direction. Of the principal axes, 3 is the
// one that the spin goes round ("main"), 2 the middle one and 1 the other, each direction chosen so that they are
// right-handed:
//
//   w1 = A1 cn u,  w2 = A2 sn u,  w3 = A3 dn u,  u = p t + u0
//   precession' = L (I1 w1^2 + I2 w2^2) / (I1^2 w1^2 + I2^2 w2^2) = L (f1 / I1 + f2 / I2),  f1 + f2 = 1, both >= 0
//
// The integral of f1 or f2 is one of the third kind. Carlson's R_J gives each as a product of positive factors, so that
// no bit is lost however thin the body is: with n = I2 (I3 - I1) / (I1 (I3 - I2)),
//
//   f2 = n sn^2 / (cn^2 + n sn^2),   integral from 0 to u = n/3 sn^3 R_J(cn^2, dn^2, 1, cn^2 + n sn^2)
//
// and f1 is the same function of K - u with k'^2 / n for n. Quadrature would have to find a peak of f1 whose width goes
// down with the thickness (a spin that passes the long axis of a rod 1:1000 does so in 1e-3 of the period), and theta
// functions lose their digits where k comes close to 1.
#include <array>

#include "odeval/geometry.hpp"
#include "reference/closed_form/rotation.hpp"

namespace odeval::reference {

class FreeBody {
 public:
  /// Moments of inertia about the body's own axes; `spin_rad_s` and `attitude` at t = 0, spin in the world.
  FreeBody(const Vec3& moments_kgm2, const Rotation& attitude, const Vec3& spin_rad_s);

  struct Turning {
    Rotation attitude;  // body to world
    Vec3 spin_rad_s;    // world
  };
  /// At any time, before the start as well.
  Turning at(double t_s) const;

  /// Whether the spin lies along a principal axis to the last bit, and so stays whatever the motion near it does.
  bool steady() const { return steady_; }

 private:
  Vec3 spin_at(double u) const;
  Rotation euler_angles(const Vec3& spin) const;
  double precession_part(double u) const;

  bool steady_ = false;  // the spin lies along a principal axis and stays
  Rotation start_;       // body to world
  Vec3 start_spin_;      // world

  Rotation sorted_{};    // body axes to the axes 1, 2, 3
  Vec3 moments_;         // I1, I2, I3
  Vec3 amplitudes_{};    // A1, A2, A3
  double momentum_ = 0;  // L
  double rate_ = 0;      // p
  double complement_ = 0;
  double quarter_ = 0;  // K
  double phase_ = 0;    // u0
  double ratio_ = 0;    // n
  double whole_ = 0;    // of precession_part over a quarter
  double start_part_ = 0;
  Rotation to_world_;  // from the frame of Euler's angles at t = 0, whose z axis is along L
};

}  // namespace odeval::reference
