#pragma once
// Free bodies by the equations of Newton and Euler and CVODE: the second opinion on the closed form.
#include <memory>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// Samples of bodies. State of each: centre, its velocity, attitude as a quaternion, spin in the body's frame.
std::unique_ptr<Simulation> make_free_cvode(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
