#pragma once
// What an ODE world holds, as a mechanism again.
#include "odeval/scenario.hpp"

namespace odeval::engine_ode {

/// Builds the scenario's world and asks its bodies and joints what they are: masses, inertias, places and speeds,
/// anchors and axes in the world, which bodies they hold.
/// Bodies have the scenario's order. Shapes, names, motors, stops and loads are left out. Throws MachineError when ODE
/// refuses the scenario.
Mechanism take_back(const Scenario& scenario);

}  // namespace odeval::engine_ode
