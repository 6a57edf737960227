#pragma once
// The timed loop: what is the same for every scene that ODE, or another stepper, moves.
#include <memory>
#include <vector>

#include "engine_ode/scene.hpp"
#include "engine_ode/world_stepper.hpp"
#include "odeval/method.hpp"

namespace odeval::engine_ode {

using StepFunction = int (*)(dWorldID, dReal);

/// A scene that is moved and recorded as bodies. What is special about a family of scenes, the classes below say.
class SteppedSimulation : public Simulation {
 public:
  Outcome run(Rows* rows) final;

 protected:
  using BuildScene = void (*)(Scene&, const Scenario&);

  /// `touchable`: contacts are looked for in every step.
  SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step, BuildScene build,
                    bool touchable);

  /// Moved by another stepper instead.
  void use(MakeStepper make_stepper);

  /// After each step that will be recorded.
  virtual void follow() {}
  /// What BodyState::angle is recorded as.
  virtual double angle_of(std::size_t) const { return 0; }
  /// An impact as it stands before, and its rate again after: an angle and its rate, or a height and its rate.
  virtual Impact impact_before(double t, double depth) const = 0;
  virtual double rate_after() const = 0;

  const Scenario& scenario() const { return scenario_; }
  const Scene& scene() const { return scene_; }

 private:
  double time_of(long steps) const { return static_cast<double>(steps) * grid_.step_s; }
  void step_once(long steps_done);
  void step_with_contacts(long steps_done);
  bool finite() const;
  void record(Rows& rows) const;
  void give_start_its_forces(Rows& rows) const;

  Scenario scenario_;
  SampleGrid grid_;
  StepFunction step_;
  Scene scene_;
  bool touchable_;
  std::vector<Impact> impacts_;
  std::unique_ptr<WorldStepper> stepper_;
  long stepper_steps_ = 0;
  int contacts_ = 0;  // in the last step
  bool touching_ = false;
};

}  // namespace odeval::engine_ode
