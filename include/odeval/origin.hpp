#pragma once
// How a reference's origin begins that is ODE's own limit, so that it is told wherever its numbers stand.
#include <string_view>

namespace odeval {

inline constexpr std::string_view self_converged_origin = "self-converged";

}  // namespace odeval
