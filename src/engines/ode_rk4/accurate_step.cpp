#include "engines/ode_rk4/accurate_step.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/flight.hpp"
#include "engines/ode_rk4/refuse.hpp"
#include "engines/ode_rk4/watch.hpp"

namespace odeval {

using namespace engine_rk4;

namespace {

/// Before anything is read: a single-precision ODE would tell nonsense.
AccurateStepOptions checked(dWorldID world, AccurateStepOptions options) {
  if (dCheckConfiguration("ODE_double_precision") == 0) refuse("needs a double-precision ODE");
  const auto check = [](bool good, const char* what, double value) {
    if (!good) refuse(std::string(what) + ", not " + shown(value));
  };
  check(options.start_gap > 0 && std::isfinite(options.start_gap), "start_gap must be a positive number of metres",
        options.start_gap);
  check(options.rest_speed >= 0 && std::isfinite(options.rest_speed), "rest_speed must be 0 or more metres a second",
        options.rest_speed);
  check(options.most_impacts >= 1, "most_impacts must be 1 or more", options.most_impacts);
  check(options.order == 4 || options.order == 8, "order must be 4 or 8", options.order);
  const bool known = options.impact_order == ImpactOrder::together || options.impact_order == ImpactOrder::in_turn;
  check(known, "impact_order must be ImpactOrder::together or in_turn", static_cast<int>(options.impact_order));
  for (std::size_t i = 0; i < options.bodies.size(); ++i) {
    const dBodyID body = options.bodies[i];
    const std::string number = std::to_string(i) + " of AccurateStepOptions::bodies is ";
    if (body == nullptr) refuse("number " + number + "null");
    if (dBodyGetWorld(body) != world) refuse("number " + number + "of another world", body);
  }
  return options;
}

}  // namespace

class AccurateStep::World {
 public:
  World(dxWorld* world, dxSpace* space, AccurateStepOptions options)
      : world_(world),
        space_(space),
        options_(checked(world, std::move(options))),
        motion_(read_mechanism(world, space, options_.bodies, {}, options_.lmotor_axis_rel), options_.order),
        watch_(space, mechanism()),
        collider_(space, options_.contact),
        flight_(motion_, collider_, options_) {
    if (!options_.forces) return;
    forces_.renew = [this](double t, const State& state, std::vector<Wrench>& now) {
      show_poses(mechanism(), state);
      show_twists(mechanism(), state);
      saved_.restore_forces();
      options_.forces(t);
      read_forces(world_, mechanism(), now);
    };
  }

  void step(double h) {
    if (!(h > 0) || !std::isfinite(h)) refuse("the step must be a positive number of seconds, not " + shown(h));
    if (watch_.changed(space_, mechanism())) reread();
    motion_.prepare(h);
    read_state(mechanism(), state_);
    motion_.check_springs(state_);
    read_forces(world_, mechanism(), forces_.now);
    saved_.save(mechanism());
    try {
      flight_.advance(state_, forces_, h, fresh_);
    } catch (...) {
      saved_.restore(state_);
      throw;
    }
    write();
    fresh_ = false;
  }

  const std::vector<Touch>& touches() const { return flight_.touches(); }
  std::size_t crowded_steps() const { return flight_.crowded_steps(); }
  const Mechanism& mechanism() const { return motion_.mechanism(); }

 private:
  void reread() {
    Mechanism now = read_mechanism(world_, space_, options_.bodies, mechanism(), options_.lmotor_axis_rel);
    watch_ = Watch(space_, now);
    motion_ = Motion(std::move(now), options_.order);
    flight_.start_anew();
    fresh_ = true;
  }

  void write() const {
    show_poses(mechanism(), state_);
    show_twists(mechanism(), state_);
    for (std::size_t i = 0; i < state_.size(); ++i) {
      const Body& body = mechanism().bodies[i];
      dBodySetForce(body.id, 0, 0, 0);
      dBodySetTorque(body.id, 0, 0, 0);
      const Twist& twist = state_[i].twist;
      const bool still = twist.linear.isZero(0) && twist.angular.isZero(0);
      if (dBodyIsEnabled(body.id) == 0 && !(body.asleep && still)) dBodyEnable(body.id);
    }
    for (std::size_t j = 0; j < mechanism().joints.size(); ++j) {
      const Joint& joint = mechanism().joints[j];
      dJointFeedback* const feedback = dJointGetFeedback(joint.id);
      if (feedback == nullptr) continue;
      const auto put = [](const Wrench& wrench, dReal* force, dReal* torque) {
        std::copy_n(wrench.force.data(), 3, force);
        std::copy_n(wrench.torque.data(), 3, torque);
      };
      // ODE writes the force on the body it holds as the first.
      put(flight_.mover().force_on_a(j), feedback->f1, feedback->t1);
      if (joint.b != world_body) put(flight_.mover().force_on_b(j), feedback->f2, feedback->t2);
    }
  }

  dWorldID world_;
  dSpaceID space_;
  AccurateStepOptions options_;
  Motion motion_;
  Watch watch_;
  Collider collider_;
  Flight flight_;
  bool fresh_ = true;  // the first step since the mechanism was read
  State state_;
  Forces forces_;
  Saved saved_;
};

AccurateStep::AccurateStep(dxWorld* world, dxSpace* space, AccurateStepOptions options)
    : world_(std::make_unique<World>(world, space, std::move(options))) {}
AccurateStep::~AccurateStep() = default;
AccurateStep::AccurateStep(AccurateStep&&) noexcept = default;
AccurateStep& AccurateStep::operator=(AccurateStep&&) noexcept = default;
void AccurateStep::operator()(double h) { world_->step(h); }
const std::vector<Touch>& AccurateStep::touches() const { return world_->touches(); }
std::size_t AccurateStep::crowded_steps() const { return world_->crowded_steps(); }
std::size_t AccurateStep::bodies() const { return world_->mechanism().bodies.size(); }
std::size_t AccurateStep::joints() const { return world_->mechanism().joints.size(); }

}  // namespace odeval
