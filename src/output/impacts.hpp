#pragma once
// What tables and files say of impacts.
#include "odeval/scenario.hpp"

namespace odeval {

/// Whether methods count a scenario's impacts: of contacts between named things none does, which is not the same as
/// that there were none.
inline bool tells_impacts(const Scenario& scenario) {
  return scenario.mechanism.contacts.empty() || !scenario.impact_views.empty();
}

}  // namespace odeval
