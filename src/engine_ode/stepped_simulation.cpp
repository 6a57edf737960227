#include "engine_ode/stepped_simulation.hpp"

#include <cstddef>

#include "engine_ode/library.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_ode {

SteppedSimulation::SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step,
                                     BuildScene build, std::size_t touchers)
    : scenario_(scenario), grid_(grid), step_(step), scene_(scenario), touching_(touchers) {
  build(scene_, scenario_);
  impacts_.reserve(1024);
  touched_.reserve(touchers);
}

void SteppedSimulation::use(MakeStepper make_stepper) {
  SteppedWorld world{scene_.world(), scene_.space(), {}, {}, {}};
  if (!touching_.empty()) world.restitution = scenario_.ode.bounce.value_or(scenario_.restitution());
  world.before_impact = [this](double after_s) {
    ++contacts_;
    touched_.assign(1, deepest());
    impacts_.push_back(impact_before(time_of(stepper_steps_) + after_s, touched_[0], 0));
  };
  world.after_impact = [this] { impacts_.back().qd_after = rate_after(touched_[0]); };
  stepper_ = make_stepper(world);
}

Outcome SteppedSimulation::run(Rows* rows) {
  Outcome outcome;
  const long messages_before = message_count();
  dRandSetSeed(scenario_.ode.seed);  // one seed a process, which QuickStep draws from
  if (rows != nullptr) record(*rows);
  try {
    for (long row = 1; row < grid_.rows; ++row) {
      for (long k = 0; k < grid_.stride; ++k) {
        step_once(outcome.steps);
        if (!finite()) throw Fault("a velocity or its square left the finite numbers");
        ++outcome.steps;
        if (rows == nullptr) continue;
        follow();
        if (outcome.steps == 1) give_start_its_forces(*rows);
      }
      if (rows != nullptr) record(*rows);
    }
  } catch (const MachineError&) {
    throw;
  } catch (const Fault& fault) {
    outcome.diverged = true;
    outcome.reason =
        fault.what() + std::string(" in the step from t = ") + std::to_string(time_of(outcome.steps)) + " s";
    scene_.abandon();
  } catch (const std::runtime_error& refused) {  // of a stepper, which leaves the world sound
    outcome.diverged = true;
    outcome.reason =
        refused.what() + std::string(" in the step from t = ") + std::to_string(time_of(outcome.steps)) + " s";
  }
  outcome.messages = message_count() - messages_before;
  outcome.impacts = std::move(impacts_);
  return outcome;
}

void SteppedSimulation::step_once(long steps_done) {
  if (stepper_) {
    contacts_ = 0;
    stepper_->step(grid_.step_s);
    ++stepper_steps_;
  } else if (!touching_.empty()) {
    step_with_contacts(steps_done);
  } else {
    step_world();
  }
}

// ODE steps nothing and says so by 0 when it cannot get the memory for its matrices.
void SteppedSimulation::step_world() {
  if (step_(scene_.world(), static_cast<dReal>(grid_.step_s)) == 0) throw MachineError("ODE: no memory for a step");
}

// An impact is a run of steps in which a thing has contacts; its first step carries the bounce.
void SteppedSimulation::step_with_contacts(long steps_done) {
  scene_.collide();
  contacts_ = scene_.contacts();
  touched_.clear();
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    const double depth = contacts_ > 0 ? depth_of(i) : -1;
    if (depth >= 0 && touching_[i] == 0) {
      touched_.push_back(i);
      impacts_.push_back(impact_before(time_of(steps_done), i, depth));
    }
    touching_[i] = depth >= 0;
  }
  step_world();
  scene_.clear_contacts();
  Impact* impact = impacts_.data() + impacts_.size() - touched_.size();
  for (const std::size_t toucher : touched_) (impact++)->qd_after = rate_after(toucher);
}

std::size_t SteppedSimulation::deepest() const {
  std::size_t found = 0;
  for (std::size_t i = 1; i < touching_.size(); ++i) {
    if (depth_of(i) > depth_of(found)) found = i;
  }
  return found;
}

// Positions follow velocities, so these are enough. The squares must stay finite as well: energies hold them.
bool SteppedSimulation::finite() const {
  double sum = 0;
  for (const BodyView& body : scene_.bodies()) {
    for (int k = 0; k < 3; ++k) {
      const double velocity = body.velocity[k];
      const double spin = body.spin[k];
      sum += velocity * velocity + spin * spin;
    }
  }
  return sum < 1e290;
}

void SteppedSimulation::record(Rows& rows) const {
  double* row = rows.append();
  const std::vector<BodyView>& bodies = scene_.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodyView& body = bodies[i];
    for (int k = 0; k < 3; ++k) *row++ = body.position[k];
    for (int k = 0; k < 12; ++k) {
      if (k % 4 != 3) *row++ = body.rotation[k];
    }
    for (int k = 0; k < 3; ++k) *row++ = body.velocity[k];
    for (int k = 0; k < 3; ++k) *row++ = body.spin[k];
    for (int k = 0; k < 3; ++k) *row++ = body.joint_force == nullptr ? 0 : static_cast<double>(body.joint_force[k]);
    *row++ = angle_of(i);
  }
  *row = contacts_;
}

// No step led to t = 0: its row shows the force of the first step instead of a zero nobody measured.
void SteppedSimulation::give_start_its_forces(Rows& rows) const {
  const std::vector<BodyView>& bodies = scene_.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].joint_force == nullptr) continue;
    double* force = rows.row(0) + i * body_numbers + offsetof(BodyState, joint_force) / sizeof(double);
    for (int k = 0; k < 3; ++k) force[k] = bodies[i].joint_force[k];
  }
}

}  // namespace odeval::engine_ode
