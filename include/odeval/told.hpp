#pragma once
// What an engine was told beside the scenario. (C++17, for adapters whose library has headers that are no C++20.)
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace odeval {

/// The engine's own options and their values, read back from it, in its own words: {"integrator", "Euler"}.
using Told = std::vector<std::pair<std::string, std::variant<double, std::int64_t, std::string>>>;

}  // namespace odeval
