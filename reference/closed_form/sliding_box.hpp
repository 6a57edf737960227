#pragma once
// A box that slides on a plane under Coulomb friction, in any direction: closed form.
#include "reference/closed_form/body_motion.hpp"

namespace odeval::reference {

/// The force of friction points against the velocity and has the size f (per mass): a coefficient times the normal
/// force, or a constant. Down the slope pulls g (per mass). With k = f / g, u the speed downhill, w across, v = |(u,
/// w)| and A = v + u, B = v - u at the start, the motion runs with a parameter s >= 0:
///
///   downhill speed  (A e^-(k-1)s - B e^-(k+1)s) / 2         speed across  w e^-ks
///   time            (A E(k-1) + B E(k+1)) / 2g,             E(p) = (1 - e^-ps) / p
///   way downhill    (A² E(2k-2) - B² E(2k+2)) / 4g,         way across  w (A E(2k-1) + B E(2k+1)) / 2g
///
/// (the hodograph dv/dphi = -v (cos phi - k) / sin phi of the angle phi to the way downhill, tan(phi/2) = z0 e^-s). It
/// stops where k > 1, or where it came straight uphill; then it is held if k >= 1 and slides down if not.
///
/// Throws UserError when the body is no single box that lies flat, moves off the plane, spins, or could tip.
std::unique_ptr<BodyMotion> make_sliding_box(const Scenario& scenario);

}  // namespace odeval::reference
