#pragma once
// The engines that a test is of.
#include <algorithm>
#include <string>
#include <vector>

#include "catalogue/methods.hpp"

namespace odeval::test {

/// The methods of engines beside ODE that this build has, of those in `asked`; empty: all.
inline std::vector<const catalogue::Method*> engines(const std::vector<std::string>& asked) {
  std::vector<const catalogue::Method*> found;
  for (const catalogue::Method& method : catalogue::methods()) {
    const bool wanted = asked.empty() || std::ranges::find(asked, method.name) != asked.end();
    if (method.tells && method.make != nullptr && wanted) found.push_back(&method);
  }
  return found;
}

}  // namespace odeval::test
