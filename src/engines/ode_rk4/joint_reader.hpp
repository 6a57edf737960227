#pragma once
// A joint of ODE's as its public functions describe it.
#include <map>

#include "engines/ode_rk4/mechanism.hpp"

namespace odeval::engine_rk4 {

/// At its present pose, between numbered bodies. Throws AccurateStepError.
Joint read_joint(dJointID id, const std::map<dBodyID, std::size_t>& numbers, const LMotorRel& lmotor_rel);

}  // namespace odeval::engine_rk4
