#include "reference/bodies/solution.hpp"

#include <algorithm>
#include <cstring>

#include "reference/bodies/motion.hpp"

namespace odeval::reference {
namespace {

class BodyAnalytic final : public Simulation {
 public:
  BodyAnalytic(const Scenario& scenario, const SampleGrid& grid)
      : motion_(make_body_motion(scenario)), grid_(grid), bodies_(scenario.bodies.size()) {}

  Outcome run(Rows* rows) override {
    Outcome outcome;
    for (long k = 0; k < grid_.rows; ++k) {
      motion_->at(grid_.time(k), bodies_);
      if (rows != nullptr) {
        double* row = rows->append();
        std::memcpy(row, bodies_.data(), bodies_.size() * sizeof(BodyState));
        row[bodies_.size() * body_numbers] = 0;
      }
    }
    outcome.steps = grid_.rows - 1;
    outcome.impacts = motion_->impacts(grid_.time(grid_.rows - 1));
    outcome.at_rest_from = motion_->at_rest_from();
    return outcome;
  }

 private:
  std::unique_ptr<BodyMotion> motion_;
  SampleGrid grid_;
  std::vector<BodyState> bodies_;
};

template <std::size_t N>
void store(std::array<Column, N>& columns, const double (&values)[N]) {
  for (std::size_t i = 0; i < N; ++i) columns[i].push_back(values[i]);
}

}  // namespace

Reference solve_body_reference(const Scenario& scenario, const SampleGrid& grid) {
  const std::unique_ptr<BodyMotion> motion = make_body_motion(scenario);
  Reference reference;
  Trace& trace = reference.trace;
  trace.bodies.resize(scenario.bodies.size());
  trace.long_axis_spin.resize(scenario.bodies.size());
  std::vector<BodyState> states(scenario.bodies.size());
  for (long k = 0; k < grid.rows; ++k) {
    const double t = grid.time(k);
    motion->at(t, states);
    trace.t.push_back(t);
    for (std::size_t i = 0; i < states.size(); ++i) {
      store(trace.bodies[i].position, states[i].position);
      store(trace.bodies[i].rotation, states[i].rotation);
      store(trace.bodies[i].velocity, states[i].velocity);
      store(trace.bodies[i].spin, states[i].spin);
      store(trace.bodies[i].joint_force, states[i].joint_force);
      const std::size_t axis = scenario.bodies[i].long_axis();
      const double* const r = states[i].rotation;
      trace.long_axis_spin[i].push_back(
          dot({r[axis], r[3 + axis], r[6 + axis]}, {states[i].spin[0], states[i].spin[1], states[i].spin[2]}));
    }
    const BodyUncertainty uncertainty = motion->uncertainty(t);
    reference.uncertainty_position.push_back(uncertainty.position_m);
    reference.uncertainty_turn.push_back(uncertainty.turn_rad);
    reference.uncertainty_spin.push_back(uncertainty.spin_rad_s);
  }
  if (scenario.joint) {
    for (const BodyColumns& body : trace.bodies) reference.joint_force.push_back(body.joint_force);
  }
  reference.impacts = motion->impacts(grid.time(grid.rows - 1));
  reference.at_rest_from = motion->at_rest_from();
  reference.described = motion->described();
  return reference;
}

std::unique_ptr<Simulation> make_body_analytic(const Scenario& scenario, const SampleGrid& grid) {
  return std::make_unique<BodyAnalytic>(scenario, grid);
}

Scenario half_a_step_earlier(const Scenario& scenario) {
  Scenario earlier = scenario;
  std::vector<BodyState> states(scenario.bodies.size());
  make_body_motion(scenario)->at(-scenario.step_s / 2, states);
  for (std::size_t i = 0; i < states.size(); ++i) {
    std::copy_n(states[i].velocity, 3, earlier.bodies[i].velocity_m_s.begin());
    std::copy_n(states[i].spin, 3, earlier.bodies[i].spin_rad_s.begin());
  }
  return earlier;
}

}  // namespace odeval::reference
