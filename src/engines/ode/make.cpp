#include "engines/ode/make.hpp"

#include "engines/ode/library.hpp"
#include "engines/ode/stepped_simulation.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_ode {
namespace {

template <class Step>
std::unique_ptr<Simulation> make(const Scenario& scenario, const SampleGrid& grid, Step step) try {
  return std::make_unique<SteppedSimulation>(scenario, grid, step);
} catch (const Fault& fault) {
  throw MachineError("scenario '" + scenario.name + "' can not be built: " + fault.what());
}

}  // namespace

std::unique_ptr<Simulation> make_step(const Scenario& scenario, const SampleGrid& grid) {
  return make<StepFunction>(scenario, grid, &dWorldStep);
}

std::unique_ptr<Simulation> make_quickstep(const Scenario& scenario, const SampleGrid& grid) {
  return make<StepFunction>(scenario, grid, &dWorldQuickStep);
}

std::unique_ptr<Simulation> make_stepped(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper) {
  return make(scenario, grid, make_stepper);
}

}  // namespace odeval::engine_ode
