#pragma once
// A mechanism put into an ODE world: one maker a kind of shape, joint and obstacle.
#include <ode/ode.h>

#include <vector>

#include "odeval/scenario.hpp"

namespace odeval::engine_ode {

constexpr dReal real(double value) { return static_cast<dReal>(value); }

/// A body with its geoms, where and as fast as it starts. Every setting of its own is set.
dBodyID make_body(dWorldID world, dSpaceID space, const Body& body, const OdeSettings& ode);

/// A joint between bodies that stand where they start; the step says what a suspension's ERP and CFM are. Throws
/// Faults; ODE checks its own assertions.
dJointID make_joint(dWorldID world, const Joint& joint, const std::vector<dBodyID>& bodies,
                    const std::vector<Body>& starts, double step_s);

dGeomID make_obstacle(dSpaceID space, const Obstacle& obstacle);

}  // namespace odeval::engine_ode
