#pragma once
// Bodies in space stepped by ODE.
#include "engine_ode/body_scene.hpp"
#include "engine_ode/stepped_simulation.hpp"

namespace odeval::engine_ode {

class BodySimulation final : public SteppedSimulation {
 public:
  BodySimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step)
      : SteppedSimulation(scenario, grid, step, &build_bodies, scenario.ground ? 1 : 0) {}
  BodySimulation(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper)
      : BodySimulation(scenario, grid, StepFunction{}) {
    use(make_stepper);
  }

 private:
  /// Of the first body: the height of its centre above the ground, and that height's rate.
  double depth_of(std::size_t) const override { return scene().depth(); }
  Impact impact_before(double t, std::size_t, double depth) const override {
    return {t, along_normal(scene().bodies().front().position), rate_after(0), 0, depth};
  }
  double rate_after(std::size_t) const override { return along_normal(scene().bodies().front().velocity); }

  double along_normal(const dReal* v) const { return dot(scenario().ground->normal(), {v[0], v[1], v[2]}); }
};

}  // namespace odeval::engine_ode
