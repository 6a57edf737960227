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

  /// `touchers`: how many things have impacts of their own; 0: nothing touches anything.
  SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step, BuildScene build,
                    std::size_t touchers);

  /// Moved by another stepper instead.
  void use(MakeStepper make_stepper);

  /// After each step that will be recorded.
  virtual void follow() {}
  /// What BodyState::angle is recorded as.
  virtual double angle_of(std::size_t) const { return 0; }

  // Impacts: each of `touchers` things has its own.
  /// How deep a thing is in what it may touch, m; below 0 where it does not.
  virtual double depth_of(std::size_t toucher) const = 0;
  /// As it stands before: an angle and its rate, or a height and its rate.
  virtual Impact impact_before(double t, std::size_t toucher, double depth) const = 0;
  virtual double rate_after(std::size_t toucher) const = 0;

  const Scenario& scenario() const { return scenario_; }
  const Scene& scene() const { return scene_; }

 private:
  double time_of(long steps) const { return static_cast<double>(steps) * grid_.step_s; }
  void step_once(long steps_done);
  void step_world();
  void step_with_contacts(long steps_done);
  std::size_t deepest() const;
  bool finite() const;
  void record(Rows& rows) const;
  void give_start_its_forces(Rows& rows) const;

  Scenario scenario_;
  SampleGrid grid_;
  StepFunction step_;
  Scene scene_;
  std::vector<Impact> impacts_;
  std::unique_ptr<WorldStepper> stepper_;
  long stepper_steps_ = 0;
  int contacts_ = 0;                  // in the last step
  std::vector<char> touching_;        // by toucher, in the last step
  std::vector<std::size_t> touched_;  // the touchers of the impacts of this step
};

}  // namespace odeval::engine_ode
