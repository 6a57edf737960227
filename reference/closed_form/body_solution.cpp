#include "reference/closed_form/body_solution.hpp"

#include <optional>
#include <vector>

#include "odeval/mechanism.hpp"
#include "reference/closed_form/body_motion.hpp"

namespace odeval::reference {
namespace {

SampleShape shape_of(const Mechanism& mechanism) {
  return {.bodies = mechanism.bodies.size(), .joints = mechanism.joints.size()};
}

class BodyAnalytic final : public Simulation {
 public:
  BodyAnalytic(const Scenario& scenario, const SampleGrid& grid)
      : motion_(make_body_motion(scenario)), grid_(grid), shape_(shape_of(scenario.mechanism)) {}

  SampleShape shape() const override { return shape_; }

  Outcome run(Recorder recorder) override {
    Motion unseen(shape_, 1);
    for (long k = 0; k < grid_.rows; ++k) {
      const Sample sample = recorder ? recorder.next() : unseen[0];
      motion_->at(grid_.time(k), sample.bodies, sample.joints);
    }
    Outcome outcome;
    outcome.steps = grid_.rows - 1;
    outcome.impacts = motion_->impacts(grid_.time(grid_.rows - 1));
    outcome.at_rest_from = motion_->at_rest_from();
    return outcome;
  }

 private:
  std::unique_ptr<BodyMotion> motion_;
  SampleGrid grid_;
  SampleShape shape_;
};

template <std::size_t N>
void store(std::array<Column, N>& columns, const std::array<double, N>& values) {
  for (std::size_t i = 0; i < N; ++i) columns[i].push_back(values[i]);
}

}  // namespace

void append_row(Reference& reference, const Mechanism& mechanism, double t, const Sample& sample) {
  Trace& trace = reference.trace;
  trace.bodies.resize(sample.bodies.size());
  trace.long_axis_spin.resize(sample.bodies.size());
  trace.t.push_back(t);
  for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
    const BodyState& state = sample.bodies[i];
    const std::optional<Carrier> carrier = carrier_of(mechanism, i);
    store(trace.bodies[i].position, state.position);
    store(trace.bodies[i].rotation, state.rotation);
    store(trace.bodies[i].velocity, state.velocity);
    store(trace.bodies[i].spin, state.spin);
    store(trace.bodies[i].joint_force, force_beside(carrier, sample.joints));
    trace.long_axis_spin[i].push_back(dot(axis_of(state.rotation, mechanism.bodies[i].long_axis()), state.spin));
  }
}

void append_uncertainty(Reference& reference, const BodyUncertainty& uncertainty) {
  reference.uncertainty_position.push_back(uncertainty.position_m);
  reference.uncertainty_turn.push_back(uncertainty.turn_rad);
  reference.uncertainty_spin.push_back(uncertainty.spin_rad_s);
}

void tell_joint_forces(Reference& reference, const Mechanism& mechanism) {
  if (mechanism.joints.empty()) return;
  for (const BodyColumns& body : reference.trace.bodies) reference.joint_force.push_back(body.joint_force);
}

Reference solve_body_reference(const Scenario& scenario, const SampleGrid& grid) {
  const Mechanism& mechanism = scenario.mechanism;
  const std::unique_ptr<BodyMotion> motion = make_body_motion(scenario);
  Motion now(shape_of(mechanism), 1);
  const Sample sample = now[0];
  Reference reference;
  for (long k = 0; k < grid.rows; ++k) {
    const double t = grid.time(k);
    motion->at(t, sample.bodies, sample.joints);
    append_row(reference, mechanism, t, sample);
    append_uncertainty(reference, motion->uncertainty(t));
  }
  tell_joint_forces(reference, mechanism);
  reference.impacts = motion->impacts(grid.time(grid.rows - 1));
  reference.at_rest_from = motion->at_rest_from();
  reference.origin = motion->origin();
  return reference;
}

std::unique_ptr<Simulation> make_body_analytic(const Scenario& scenario, const SampleGrid& grid) {
  return std::make_unique<BodyAnalytic>(scenario, grid);
}

Scenario bodies_half_a_step_earlier(const Scenario& scenario) {
  Scenario earlier = scenario;
  std::vector<Body>& bodies = earlier.mechanism.bodies;
  Motion then(shape_of(scenario.mechanism), 1);
  make_body_motion(scenario)->at(-scenario.step_s / 2, then[0].bodies, then[0].joints);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].velocity_m_s = then[0].bodies[i].velocity;
    bodies[i].spin_rad_s = then[0].bodies[i].spin;
  }
  return earlier;
}

}  // namespace odeval::reference
