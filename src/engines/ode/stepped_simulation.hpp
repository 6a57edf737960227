#pragma once
// The timed loop over a scene that ODE, or another stepper, moves.
#include <memory>
#include <optional>
#include <string>

#include "engines/ode/impacts.hpp"
#include "engines/ode/ledger.hpp"
#include "engines/ode/link_angles.hpp"
#include "engines/ode/scene.hpp"
#include "engines/ode/world_stepper.hpp"
#include "odeval/engine.hpp"

namespace odeval::engine_ode {

using StepFunction = int (*)(dWorldID, dReal);

/// A scene that is moved and recorded.
class SteppedSimulation final : public Simulation {
 public:
  SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step);
  /// Moved by another stepper instead. Its impacts are those that it locates.
  SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper);

  SampleShape shape() const override;
  Outcome run(Recorder recorder) override;

 private:
  double time_of(long steps) const { return static_cast<double>(steps) * grid_.step_s; }
  void move(Recorder& recorder, Outcome& outcome);
  std::string when(const std::exception& what, const Outcome& outcome) const;
  void step_once(long steps_done, bool recorded);
  void step_world(long steps_done, bool recorded);
  void step_with_contacts(long steps_done, bool recorded);
  bool finite() const;
  void record(Sample sample);
  void record_forces(Sample sample) const;

  SampleGrid grid_;
  StepFunction step_;
  std::uint32_t seed_;
  Scene scene_;
  LinkAngles angles_;
  Impacts impacts_;
  bool touching_;  // whether anything may touch anything
  std::unique_ptr<WorldStepper> stepper_;
  long stepper_steps_ = 0;
  int contacts_ = 0;  // in the last step
  std::optional<Ledger> ledger_;
};

}  // namespace odeval::engine_ode
