#include "engines/tree/tree_simulation.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace odeval::engine_tree {

TreeSimulation::TreeSimulation(const Scenario& scenario, const SampleGrid& grid, std::unique_ptr<World> world)
    : mechanism_(scenario.mechanism),
      view_(scenario.planar),
      gravity_(scenario.gravity),
      grid_(grid),
      world_(std::move(world)),
      tree_(hang(scenario.mechanism, &closing_)),
      impacts_(scenario),
      carried_(scenario.mechanism.bodies.size()) {
  double angle = 0;
  if (view_) {
    for (const double q : view_->q0) angles_.push_back(angle += q);
  }
}

Outcome TreeSimulation::run(Recorder recorder) {
  Outcome outcome;
  try {
    move(recorder, outcome);
  } catch (const Lost& lost) {
    outcome.diverged = true;
    outcome.reason = lost.what() + std::string(" in the step from t = ") + std::to_string(time_of(step_)) + " s";
  }
  outcome.impacts = impacts_.take();
  return outcome;
}

void TreeSimulation::move(Recorder& recorder, Outcome& outcome) {
  if (!recorder && world_->chooses_steps()) {
    outcome.steps = world_->step(0, time_of(grid_.steps()));
    return;
  }
  if (recorder) {
    follow();
    record(recorder.next());
  }
  for (long row = 1; row < grid_.rows; ++row) {
    for (long k = 0; k < grid_.stride; ++k) {
      outcome.steps += world_->step(time_of(step_), time_of(step_ + 1));
      ++step_;
      if (!recorder) continue;
      follow();
      touched_ = world_->touched();
      impacts_.look(time_of(step_ - 1), touched_, before_, bodies_, angles_);
      weigh();
      if (step_ == 1) record_forces(recorder.at(0));  // no step led to t = 0: its sample shows the forces of the first
    }
    if (recorder) record(recorder.next());
  }
}

// One step turns a link by less than half a turn, so the nearest branch is the right one.
void TreeSimulation::follow() {
  std::swap(before_, bodies_);
  bodies_ = world_->bodies();
  constexpr double full_turn = 2 * std::numbers::pi;
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    const double angle = direction(i);
    angles_[i] = angle + full_turn * std::round((angles_[i] - angle) / full_turn);
  }
}

/// Absolute angle of a link's direction, within half a turn of 0.
double TreeSimulation::direction(std::size_t link) const {
  const PlanarFrame& frame = view_->frame;
  const Vec3 along = turned(bodies_[link].rotation, frame.along_body);
  return std::atan2(dot(along, frame.up), dot(along, frame.horizontal));
}

// Engines in joint coordinates need no forces of joints, and each that tells them does so for another moment. These are
// of the step's momentum: what all that hangs on a joint gained, less its weight and what touched it, is what the joint
// gave.
void TreeSimulation::weigh() {
  for (std::size_t i = 0; i < carried_.size(); ++i) {
    const Vec3 gained = (1 / grid_.step_s) * (bodies_[i].velocity_m_s - before_[i].velocity_m_s);
    carried_[i] = mechanism_.bodies[i].mass_kg * (gained + Vec3{0, 0, gravity_});
  }
  const std::vector<Vec3> pressed = world_->contact_forces();
  for (std::size_t i = 0; i < pressed.size(); ++i) carried_[i] = carried_[i] - pressed[i];
  closed_by_ = world_->closing_forces();
  for (std::size_t k = 0; k < closed_by_.size(); ++k) {
    const Joint& joint = mechanism_.joints[closing_[k]];
    carried_[joint.first] = carried_[joint.first] - closed_by_[k];
    if (joint.second) carried_[*joint.second] = carried_[*joint.second] + closed_by_[k];
  }
  for (std::size_t k = tree_.size(); k-- > 0;) {
    const Hanging& hanging = tree_[k];
    if (hanging.parent) carried_[*hanging.parent] = carried_[*hanging.parent] + carried_[hanging.body];
  }
}

void TreeSimulation::record(Sample sample) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Placed& body = bodies_[i];
    const double angle = angles_.empty() ? 0 : angles_[i];
    sample.bodies[i] = {body.position_m, body.rotation, body.velocity_m_s, body.spin_rad_s, angle};
  }
  record_forces(sample);
  sample.contacts = static_cast<double>(touched_.contacts);
}

void TreeSimulation::record_forces(Sample sample) const {
  for (const Hanging& hanging : tree_) {
    if (!hanging.joint) continue;
    const bool carries = mechanism_.joints[*hanging.joint].carried() == hanging.body;
    sample.joints[*hanging.joint].force = carries ? carried_[hanging.body] : Vec3{} - carried_[hanging.body];
  }
  for (std::size_t k = 0; k < closed_by_.size(); ++k) {
    const Joint& joint = mechanism_.joints[closing_[k]];
    sample.joints[closing_[k]].force = joint.carried() == joint.first ? closed_by_[k] : Vec3{} - closed_by_[k];
  }
}

}  // namespace odeval::engine_tree
