#pragma once
// The one way to say no.
#include <charconv>
#include <iterator>
#include <string>

#include "engines/ode_rk4/accurate_step.hpp"

namespace odeval::engine_rk4 {

/// Six digits, however small.
inline std::string shown(double number) {
  char text[32];
  return {text, std::to_chars(std::begin(text), std::end(text), number, std::chars_format::general, 6).ptr};
}

[[noreturn]] inline void refuse(const std::string& what, dxBody* body = nullptr, dxJoint* joint = nullptr) {
  throw AccurateStepError("AccurateStep: " + what, body, joint);
}

}  // namespace odeval::engine_rk4
