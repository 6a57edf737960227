#include "engines/ode/stepped_simulation.hpp"

#include "engines/ode/library.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_ode {

SteppedSimulation::SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step)
    : grid_(grid),
      step_(step),
      seed_(scenario.ode.seed),
      scene_(scenario),
      angles_(scenario, scene_),
      impacts_(scenario, scene_, angles_),
      touching_(!scenario.mechanism.contacts.empty()) {
  if (scenario.named && step != nullptr) ledger_.emplace(scenario, scene_);
}

SteppedSimulation::SteppedSimulation(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper)
    : SteppedSimulation(scenario, grid, StepFunction{}) {
  SteppedWorld world{scene_.world(), scene_.space(), {}, {}, {}, {}};
  if (touching_) {
    world.contact = [this](dGeomID first, dGeomID second) -> std::optional<Touching> {
      const Surface* const surface = scene_.surface_between(first, second);
      if (surface == nullptr) return std::nullopt;
      return Touching{surface->parameters.bounce, surface->parameters.mu};
    };
  }
  if (!scene_.loads().empty()) {
    world.loads = [this](double after_s) { scene_.loads().apply(time_of(stepper_steps_) + after_s); };
  }
  world.before_impact = [this](double after_s) {
    ++contacts_;
    impacts_.begin(time_of(stepper_steps_) + after_s);
  };
  world.after_impact = [this] { impacts_.end(); };
  stepper_ = make_stepper(world);
}

SampleShape SteppedSimulation::shape() const {
  return {scene_.bodies().size(), scene_.joint_forces().size(), 0, ledger_ ? work_names.size() : 0};
}

Outcome SteppedSimulation::run(Recorder recorder) {
  Outcome outcome;
  take_messages();      // of whoever ran before
  dRandSetSeed(seed_);  // one seed a process, which QuickStep draws from
  if (recorder) record(recorder.next());
  try {
    move(recorder, outcome);
  } catch (const MachineError&) {
    throw;
  } catch (const Fault& fault) {
    outcome.diverged = true;
    outcome.reason = when(fault, outcome);
    scene_.abandon();
  } catch (const std::runtime_error& refused) {  // of a stepper, which leaves the world sound
    outcome.diverged = true;
    outcome.reason = when(refused, outcome);
  }
  Messages messages = take_messages();
  outcome.messages = messages.count;
  outcome.first_message = std::move(messages.first);
  outcome.impacts = impacts_.take();
  if (recorder && ledger_) ledger_->tell(outcome);
  return outcome;
}

void SteppedSimulation::move(Recorder& recorder, Outcome& outcome) {
  for (long row = 1; row < grid_.rows; ++row) {
    for (long k = 0; k < grid_.stride; ++k) {
      step_once(outcome.steps, static_cast<bool>(recorder));
      if (!finite()) throw Fault("a velocity or its square left the finite numbers");
      ++outcome.steps;
      if (!recorder) continue;
      angles_.follow();
      // No step led to t = 0: its sample shows the forces of the first step.
      if (outcome.steps == 1) record_forces(recorder.at(0));
      if (outcome.steps == 1 && ledger_) ledger_->record_loads(recorder.at(0));
    }
    if (recorder) record(recorder.next());
  }
}

std::string SteppedSimulation::when(const std::exception& what, const Outcome& outcome) const {
  return what.what() + std::string(" in the step from t = ") + std::to_string(time_of(outcome.steps)) + " s";
}

void SteppedSimulation::step_once(long steps_done, bool recorded) {
  if (!scene_.loads().empty()) scene_.loads().sample(time_of(steps_done));
  if (stepper_) {
    contacts_ = 0;
    stepper_->step(grid_.step_s);
    ++stepper_steps_;
    return;
  }
  if (!scene_.loads().empty()) scene_.loads().apply(time_of(steps_done));
  if (touching_) {
    step_with_contacts(steps_done, recorded);
  } else {
    step_world(steps_done, recorded);
  }
}

// ODE steps nothing and says so by 0 when it cannot get the memory for its matrices.
void SteppedSimulation::step_world(long steps_done, bool recorded) {
  const bool told = recorded && ledger_;
  if (told) ledger_->before_step(time_of(steps_done));
  if (step_(scene_.world(), static_cast<dReal>(grid_.step_s)) == 0) throw MachineError("ODE: no memory for a step");
  if (told) ledger_->after_step();
}

void SteppedSimulation::step_with_contacts(long steps_done, bool recorded) {
  scene_.collide();
  contacts_ = scene_.contacts();
  impacts_.before_step(time_of(steps_done));
  step_world(steps_done, recorded);
  scene_.clear_contacts();
  impacts_.after_step();
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

void SteppedSimulation::record(Sample sample) {
  const std::vector<BodyView>& bodies = scene_.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodyView& body = bodies[i];
    BodyState& state = sample.bodies[i];
    for (std::size_t k = 0; k < 3; ++k) {
      state.position[k] = body.position[k];
      for (std::size_t column = 0; column < 3; ++column) {
        state.rotation[3 * k + column] = body.rotation[4 * k + column];  // ODE's rows hold four numbers
      }
      state.velocity[k] = body.velocity[k];
      state.spin[k] = body.spin[k];
    }
    state.angle = angles_.of(i);
  }
  record_forces(sample);
  sample.contacts = contacts_;
  if (ledger_) ledger_->record(sample);
}

void SteppedSimulation::record_forces(Sample sample) const {
  const std::vector<const dReal*>& forces = scene_.joint_forces();
  for (std::size_t j = 0; j < forces.size(); ++j) {
    for (std::size_t k = 0; k < 3; ++k) sample.joints[j].force[k] = forces[j][k];
  }
}

}  // namespace odeval::engine_ode
