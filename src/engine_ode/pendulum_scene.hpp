#pragma once
// A scenario's pendulum as an ODE world, built the way the report's listings C.2 and C.5 build it.
#include "engine_ode/scene.hpp"

namespace odeval::engine_ode {

/// Links on hinges, one shown body a link; the wall where there is one, else a ground that nothing touches.
void build_pendulum(Scene& scene, const Scenario& scenario);

}  // namespace odeval::engine_ode
