#pragma once
// Bodies that nothing touches: the centre on a parabola, the turn about the centre on its own.
#include "reference/closed_form/body_motion.hpp"

namespace odeval::reference {

std::unique_ptr<BodyMotion> make_free_bodies(const Scenario& scenario);

}  // namespace odeval::reference
