#include "engine_ode/pendulum_simulation.hpp"

#include <cmath>
#include <numbers>

namespace odeval::engine_ode {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;

double nearest_branch(double angle, double near) { return angle + full_turn * std::round((near - angle) / full_turn); }

}  // namespace

PendulumSimulation::PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step,
                                       BuildScene build)
    : SteppedSimulation(scenario, grid, step, build, scenario.wall ? scenario.links.size() : 0) {
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

/// Of a ball in the wall, or of the one link in its contacts.
double PendulumSimulation::depth_of(std::size_t link) const {
  if (scenario().links.size() == 1) return scene().depth();
  return scenario().wall->face_m + scenario().links[link].width_m / 2 -
         static_cast<double>(scene().bodies()[link].position[0]);
}

Impact PendulumSimulation::impact_before(double t, std::size_t link, double depth) const {
  Impact impact{t, angle(), rate_after(link), 0, depth};
  if (scenario().links.size() > 1) impact.link = static_cast<int>(link) + 1;
  return impact;
}

/// The rate of a single link, or the velocity of one of two balls away from the wall.
double PendulumSimulation::rate_after(std::size_t link) const {
  const BodyView& body = scene().bodies()[link];
  if (scenario().links.size() > 1) return body.velocity[0];
  return dot({body.spin[0], body.spin[1], body.spin[2]}, scenario().problem->frame.axis());
}

}  // namespace odeval::engine_ode
