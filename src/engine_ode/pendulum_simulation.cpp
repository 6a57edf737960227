#include "engine_ode/pendulum_simulation.hpp"

#include <cmath>
#include <numbers>

#include "engine_ode/pendulum_scene.hpp"

namespace odeval::engine_ode {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;

double nearest_branch(double angle, double near) { return angle + full_turn * std::round((near - angle) / full_turn); }

}  // namespace

PendulumSimulation::PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step)
    : SteppedSimulation(scenario, grid, step, &build_pendulum, scenario.wall.has_value()) {
  double angle = 0;
  for (const double q : scenario.q0) angles_.push_back(angle += q);
  follow();
}

PendulumSimulation::PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper)
    : PendulumSimulation(scenario, grid, StepFunction{}) {
  use(make_stepper);
}

// One step turns a link by 2 atan(h |w| / 2), less than half a turn, so the nearest branch is the right one.
void PendulumSimulation::follow() {
  for (std::size_t i = 0; i < angles_.size(); ++i) angles_[i] = nearest_branch(direction(i), angles_[i]);
}

/// Absolute angle of a link's direction, within half a turn of 0.
double PendulumSimulation::direction(std::size_t link) const {
  const PlanarFrame& frame = scenario().problem->frame;
  const dReal* r = scene().bodies()[link].rotation;
  Vec3 along{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) along[i] += static_cast<double>(r[4 * i + j]) * frame.along_body[j];
  }
  return std::atan2(dot(along, frame.up), dot(along, frame.horizontal));
}

/// q1 of a link against a wall, which keeps it within half a turn of the direction away from it.
double PendulumSimulation::angle() const { return direction(0) + full_turn * std::round(scenario().q0[0] / full_turn); }

double PendulumSimulation::rate_after() const {
  const dReal* spin = scene().bodies().front().spin;
  return dot({spin[0], spin[1], spin[2]}, scenario().problem->frame.axis());
}

}  // namespace odeval::engine_ode
