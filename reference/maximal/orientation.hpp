#pragma once
// Ways to keep the orientation of a body whose angular velocity is known: claim C15.
#include <string_view>
#include <vector>

namespace odeval::reference {

/// A body whose axis goes round a cone while it spins about it: R(t) = Rz(precession t) Rx(tilt) Rz(spin t). Its
/// angular velocity turns in space, so no step about a fixed axis gets it right.
struct Precession {
  double precession = 3;  // rad/s
  double tilt = 0.5;      // rad
  double spin = 5;        // rad/s
};

enum class Keeps {
  matrix,                 // R += h [w]x R
  matrix_orthonormal,     // the same, and its columns made orthonormal again (Gram-Schmidt)
  quaternion,             // q += h/2 (0, w) q
  quaternion_normalised,  // the same, divided by its length: what ODE does
};

/// With w of the middle of the step, so that what a step gets wrong is the way it turns and not its w.
struct Kept {
  std::vector<double> t;        // s
  std::vector<double> squeeze;  // largest entry of |R^T R - 1|: how far R is from a rotation
  std::vector<double> error;    // rad, angle between the rotation nearest to R and the exact one
};

/// `rows` samples after t = 0, evenly spread.
Kept keep_orientation(Keeps keeps, const Precession& motion, double step_s, double duration_s, int rows);

/// So many steps, rotation matrix included, with the spin held fast: for timing. Returns an entry of the last matrix.
double turn(Keeps keeps, double step_s, long steps);

}  // namespace odeval::reference
