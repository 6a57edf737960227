#pragma once
// ODE's scheme in generalized coordinates: claim C3's control.
#include <memory>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// What one dWorldStep does with joints that never open. The velocities of the bodies are carried from the old pose to
/// the new one, and the hinges of the new pose take from them what they do not allow:
///
///   J^T M (J u_new - J_old u_old) = h G,   angles += h u_new
///
/// with J(q) the map from joint rates to body velocities at the pose reached, J_old that of the pose before, and G the
/// weights along the joints. No Coriolis terms: they are in the difference of J and J_old. Semi-implicit Euler in
/// generalized coordinates (lagrange-symplectic-euler) evaluates them with rates half a step old instead.
///
/// In joint coordinates. Chains without a wall.
std::unique_ptr<Simulation> make_projected_step(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
