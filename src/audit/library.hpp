#pragma once
// The libraries that are loaded beside a program.
#include <string>

namespace odeval::audit {

inline constexpr const char* recorder = "libodeval-audit.so";
inline constexpr const char* simulated_clock = "libodeval-clock.so";
inline constexpr const char* accurate_stepper = "libodeval-accurate.so";

/// The full path of one. Throws UserError where LD_PRELOAD cannot name it.
std::string library_file(const char* name);

}  // namespace odeval::audit
