#pragma once
// What one precision's build of the ODE adapter offers. The adapter is compiled twice, into two shared modules that
// hide every symbol but one function, since both precisions of ODE use the same names. No ODE type crosses this line.
#include <cstddef>

#include "engines/ode/world_stepper.hpp"
#include "odeval/engine.hpp"

namespace odeval::engine_ode {

struct Module {
  const char* precision;          // "double" or "single", as the linked library says of itself
  const char* version;            // ODE's own
  const char* package;            // the source package it was built from, as known when odeval was configured
  const char* configuration;      // ODE's configuration tokens
  MakeSimulation make_step;       // dWorldStep
  MakeSimulation make_quickstep;  // dWorldQuickStep
  /// The same world, moved by another stepper.
  std::unique_ptr<Simulation> (*make_stepped)(const Scenario&, const SampleGrid&, MakeStepper);
  /// What the world holds before any motion (take_back.hpp).
  Mechanism (*take_back)(const Scenario&);
};

/// The modules of this build. Each checks on first use that headers and library have its precision and throws
/// MachineError when they do not.
extern "C" {
__attribute__((visibility("default"))) const Module& odeval_ode_double();
__attribute__((visibility("default"))) const Module& odeval_ode_single();
}

}  // namespace odeval::engine_ode
