#pragma once
// A scenario's pendulum moved by the rebuilt dWorldStep.
#include <memory>

#include "odeval/method.hpp"

namespace odeval::reference {

/// Rows are Cartesian, as those of the ODE methods. Obeys the [ode] settings of dWorldStep.
std::unique_ptr<Simulation> make_maximal_ode_step(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
