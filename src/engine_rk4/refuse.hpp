#pragma once
// The one way to say no.
#include <string>

#include "engine_rk4/accurate_step.hpp"

namespace odeval::engine_rk4 {

[[noreturn]] inline void refuse(const std::string& what, dxBody* body = nullptr, dxJoint* joint = nullptr) {
  throw AccurateStepError("AccurateStep: " + what, body, joint);
}

}  // namespace odeval::engine_rk4
