#pragma once
// Pendulums stepped by ODE: links whose angles are followed from step to step.
#include "engine_ode/stepped_simulation.hpp"

namespace odeval::engine_ode {

class PendulumSimulation final : public SteppedSimulation {
 public:
  PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step);
  PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper);

 private:
  void follow() override;
  double angle_of(std::size_t link) const override { return angles_[link]; }
  double depth_of(std::size_t link) const override;
  Impact impact_before(double t, std::size_t link, double depth) const override;
  double rate_after(std::size_t link) const override;

  double direction(std::size_t link) const;
  double angle() const;

  std::vector<double> angles_;  // absolute, of each link, as the steps have turned it
};

}  // namespace odeval::engine_ode
