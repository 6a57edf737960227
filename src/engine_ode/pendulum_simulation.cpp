// Steps a pendulum scene and records it: the timed loop.
#include "engine_ode/pendulum_simulation.hpp"

#include <ode/ode.h>

#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine_ode/library.hpp"
#include "engine_ode/pendulum_scene.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_ode {
namespace {

using StepFunction = int (*)(dWorldID, dReal);

class PendulumSimulation final : public Simulation {
 public:
  PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, StepFunction step, int hinges = 1)
      : scenario_(scenario), grid_(grid), step_(step), scene_(scenario, hinges) {
    impacts_.reserve(1024);
    double angle = 0;
    for (const double q : scenario.q0) angles_.push_back(angle += q);
    follow_angles();
  }

  /// Moved by another stepper instead.
  PendulumSimulation(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper)
      : PendulumSimulation(scenario, grid, StepFunction{}) {
    SteppedWorld world{scene_.world(), scene_.space(), {}, {}, {}};
    if (scenario.wall) world.restitution = scenario.ode.bounce.value_or(scenario.wall->restitution);
    world.before_impact = [this](double after_s) {
      ++contacts_;
      impacts_.push_back({time_of(stepper_steps_) + after_s, angle(), rate(), 0, 0});
    };
    world.after_impact = [this] { impacts_.back().qd_after = rate(); };
    stepper_ = make_stepper(world);
  }

  Outcome run(Rows* rows) override {
    Outcome outcome;
    const long messages_before = message_count();
    dRandSetSeed(scenario_.ode.seed);  // one seed a process, which QuickStep draws from
    if (rows != nullptr) record(*rows);
    try {
      for (long row = 1; row < grid_.rows; ++row) {
        for (long k = 0; k < grid_.stride; ++k) {
          if (stepper_) {
            contacts_ = 0;
            stepper_->step(grid_.step_s);
            ++stepper_steps_;
          } else if (scenario_.wall) {
            step_with_wall(outcome.steps);
          } else {
            step_(scene_.world(), static_cast<dReal>(grid_.step_s));
          }
          if (!finite()) throw Fault("a velocity or its square left the finite numbers");
          ++outcome.steps;
          if (rows == nullptr) continue;
          follow_angles();
          if (outcome.steps == 1) give_start_its_forces(*rows);
        }
        if (rows != nullptr) record(*rows);
      }
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

 private:
  double time_of(long steps) const { return static_cast<double>(steps) * grid_.step_s; }

  // An impact is a run of steps with contacts; its first step carries the bounce.
  void step_with_wall(long steps_done) {
    scene_.collide();
    const bool first_touch = scene_.contacts() > 0 && !touching_;
    contacts_ = scene_.contacts();
    touching_ = contacts_ > 0;
    if (first_touch) {
      impacts_.push_back({time_of(steps_done), angle(), rate(), 0, scene_.depth()});
    }
    step_(scene_.world(), static_cast<dReal>(grid_.step_s));
    scene_.clear_contacts();
    if (first_touch) impacts_.back().qd_after = rate();
  }

  // Positions follow velocities, so these are enough. The squares must stay finite as well: energies hold them.
  bool finite() const {
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

  // One step turns a link by 2 atan(h |w| / 2), less than half a turn, so the nearest branch is the right one.
  void follow_angles() {
    for (std::size_t i = 0; i < angles_.size(); ++i) angles_[i] = nearest_branch(direction(i), angles_[i]);
  }

  void record(Rows& rows) const {
    double* row = rows.append();
    for (std::size_t i = 0; i < angles_.size(); ++i) {
      const BodyView& body = scene_.bodies()[i];
      for (int k = 0; k < 3; ++k) *row++ = body.position[k];
      for (int k = 0; k < 12; ++k) {
        if (k % 4 != 3) *row++ = body.rotation[k];
      }
      for (int k = 0; k < 3; ++k) *row++ = body.velocity[k];
      for (int k = 0; k < 3; ++k) *row++ = body.spin[k];
      for (int k = 0; k < 3; ++k) *row++ = body.joint_force[k];
      *row++ = angles_[i];
    }
    *row = contacts_;
  }

  // No step led to t = 0: its row shows the force of the first step instead of a zero nobody measured.
  void give_start_its_forces(Rows& rows) const {
    for (std::size_t i = 0; i < angles_.size(); ++i) {
      double* force = rows.row(0) + i * body_numbers + offsetof(BodyState, joint_force) / sizeof(double);
      for (int k = 0; k < 3; ++k) force[k] = scene_.bodies()[i].joint_force[k];
    }
  }

  /// Absolute angle of a link's direction, within half a turn of 0.
  double direction(std::size_t link) const {
    const PlanarFrame& frame = scenario_.problem->frame;
    const dReal* r = scene_.bodies()[link].rotation;
    Vec3 along{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) along[i] += static_cast<double>(r[4 * i + j]) * frame.along_body[j];
    }
    return std::atan2(dot(along, frame.up), dot(along, frame.horizontal));
  }

  static double nearest_branch(double angle, double near) {
    constexpr double turn = 2 * std::numbers::pi;
    return angle + turn * std::round((near - angle) / turn);
  }

  /// q1 of a link against a wall, which keeps it within half a turn of the direction away from it.
  double angle() const {
    constexpr double turn = 2 * std::numbers::pi;
    return direction(0) + turn * std::round(scenario_.q0[0] / turn);
  }

  double rate() const {
    const dReal* spin = scene_.bodies().front().spin;
    return dot({spin[0], spin[1], spin[2]}, scenario_.problem->frame.axis());
  }

  Scenario scenario_;
  SampleGrid grid_;
  StepFunction step_;
  PendulumScene scene_;
  std::vector<double> angles_;  // absolute, of each link, as the steps have turned it
  std::vector<Impact> impacts_;
  std::unique_ptr<WorldStepper> stepper_;
  long stepper_steps_ = 0;
  int contacts_ = 0;  // in the last step
  bool touching_ = false;
};

template <class... Step>
std::unique_ptr<Simulation> make(const Scenario& scenario, const SampleGrid& grid, Step... step) try {
  return std::make_unique<PendulumSimulation>(scenario, grid, step...);
} catch (const Fault& fault) {
  throw MachineError("scenario '" + scenario.name + "' can not be built: " + fault.what());
}

}  // namespace

std::unique_ptr<Simulation> make_step(const Scenario& scenario, const SampleGrid& grid) {
  return make<StepFunction>(scenario, grid, &dWorldStep);
}

std::unique_ptr<Simulation> make_quickstep(const Scenario& scenario, const SampleGrid& grid) {
  return make<StepFunction>(scenario, grid, &dWorldQuickStep);
}

std::unique_ptr<Simulation> make_doubled(const Scenario& scenario, const SampleGrid& grid) {
  return make<StepFunction>(scenario, grid, &dWorldStep, 2);
}

std::unique_ptr<Simulation> make_stepped(const Scenario& scenario, const SampleGrid& grid, MakeStepper make_stepper) {
  return make(scenario, grid, make_stepper);
}

}  // namespace odeval::engine_ode
