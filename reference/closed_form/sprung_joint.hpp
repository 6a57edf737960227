#pragma once
// Bodies pulled out of a joint.
#include "reference/closed_form/body_motion.hpp"

namespace odeval::reference {

/// A joint with a spring and a damper (CFM > 0): each body on a damped oscillator, in closed form. A rigid joint
/// (CFM = 0) has no motion that ODE converges to, and takes back ERP of its error a step whatever the step is: there
/// the motion is that law, whose states stand at multiples of the step.
///
/// One body on the world, or two on each other, whose centre of mass then falls. The joint's force must not turn the
/// bodies: its arms lie along the displacement (of a body on the world, under gravity, along z as well) or are zero, no
/// body spins, and none moves across its arm. A hinge is then as good as a ball: what it adds are rows for turns, which
/// stay zero. Throws UserError otherwise.
///
/// A joint that starts closed may have another motion, which is no fault of the start: `has_sprung_motion` tells, for
/// balls and hinges. Of other kinds, and of joints that start open, it looks at the kind alone.
bool has_sprung_motion(const Scenario& scenario);
std::unique_ptr<BodyMotion> make_sprung_joint(const Scenario& scenario);

}  // namespace odeval::reference
