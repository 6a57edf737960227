#pragma once
// A scenario's bodies in space as an ODE world, and the ground or the joint where there is one.
#include "engine_ode/scene.hpp"

namespace odeval::engine_ode {

void build_bodies(Scene& scene, const Scenario& scenario);

}  // namespace odeval::engine_ode
