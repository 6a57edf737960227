#pragma once
// Balls that fall on a plane and bounce by Newton's law of restitution, without friction: closed form.
#include "reference/closed_form/body_motion.hpp"

namespace odeval::reference {

/// Along the plane a ball moves as in free flight. Away from it, its impacts are those of speed v, e v, e^2 v, ...;
/// with e < 1 they gather at a finite time, from which on the ball stays on the plane.
///
/// Throws UserError when a body is no ball, starts in the ground, or two of them may meet.
std::unique_ptr<BodyMotion> make_bouncing_balls(const Scenario& scenario);

}  // namespace odeval::reference
