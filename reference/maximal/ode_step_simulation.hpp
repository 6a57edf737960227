#pragma once
// A scenario's pendulum moved by the rebuilt dWorldStep.
#include <memory>

#include "odeval/engine.hpp"

namespace odeval::reference {

/// Samples of bodies and joints, as those of the ODE methods. Obeys the [ode] settings of dWorldStep.
std::unique_ptr<Simulation> make_maximal_ode_step(const Scenario& scenario, const SampleGrid& grid);

/// How singular the system is that dWorldStep factors, J M^-1 J^T + CFM/h of all hinges' rows.
struct SystemSpectrum {
  double least;                                          // eigenvalue, 1/kg; 0 where rounding leaves nothing of it
  double greatest;                                       // eigenvalue, 1/kg
  double condition() const { return greatest / least; }  // 2-norm; infinite for a singular system
};

/// Of the scenario's pose at t = 0 with `hinges` equal hinges in the place of each.
SystemSpectrum system_spectrum(const Scenario& scenario, int hinges);

}  // namespace odeval::reference
