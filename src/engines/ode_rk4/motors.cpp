// What motors do within a motion: hold, push, or wait for contacts.
#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {
namespace {

// Of a motor's velocity, and m/s or rad/s: it is there. Found to rounding by those who look for it.
constexpr double reached = 1e-9;
constexpr double no_time = 1e-3;          // of a step
constexpr double limit_rounding = 1e-12;  // of a motor's limit

}  // namespace

void Motion::release() {
  for (const MotorPlace& place : motors_) place.of(mechanism_).drive = Drive::released;
}

void Motion::feel(const State& state, Forces& forces, double t) {
  accelerate(state, forces.at(t, state), acceleration_);
}

double Motion::too_fast(const MotorPlace& place, const State& state) const {
  const Joint& joint = mechanism_.joints[place.joint];
  const Motor& motor = place.of(mechanism_);
  return motor_speed(joint, line_of(joint, motor, state, turns_), motor.slides, state) - motor.velocity;
}

/// That it holds with.
double Motion::motor_force(const MotorPlace& place) const {
  const Eigen::Index row = mechanism_.joints[place.joint].constraints() + static_cast<Eigen::Index>(place.motor);
  return lambda_[place.joint][row];
}

/// In which its limit brings it to its velocity, at the accelerations at hand; infinite if it does not.
double Motion::time_to_speed(const MotorPlace& place, const State& state) const {
  const Joint& joint = mechanism_.joints[place.joint];
  const Motor& motor = place.of(mechanism_);
  const MotorLine line = line_of(joint, motor, state, turns_);
  State rates = state;
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i].twist = acceleration_[i];
  const double fast = too_fast(place, state), rate = motor_speed(joint, line, motor.slides, rates);
  return fast * rate < 0 ? -fast / rate : INFINITY;
}

void Motion::drive(const State& state, Forces& forces, double t, std::span<const std::size_t> broken) {
  look(state);
  std::vector<char> at_speed(motors_.size(), 0), decided(motors_.size(), 0);
  for (std::size_t m = 0; m < motors_.size(); ++m) {
    Motor& motor = motors_[m].of(mechanism_);
    const double fast = too_fast(motors_[m], state);
    const bool there = std::fabs(fast) <= reached * (1 + std::fabs(motor.velocity));
    const bool at_once = std::isinf(motor.most) && !motor.late;  // the projection brings it there
    at_speed[m] = (there || at_once) && motor.most > 0 ? 1 : 0;
    if (at_speed[m] == 0) {
      motor.drive = Drive::pushes;
      motor.force = motor.late ? std::clamp(motor.expected, -motor.most, motor.most) : std::copysign(motor.most, -fast);
    } else if (std::ranges::find(broken, m) == broken.end()) {
      motor.drive = Drive::holds;
    }
  }
  // Each that can not hold changes what the others have to hold. One comes to its velocity once, and lets go once.
  // To look for a moment that is as good as now would cost more than the step.
  for (bool changed = true; changed;) {
    feel(state, forces, t);
    changed = false;
    for (std::size_t m = 0; m < motors_.size(); ++m) {
      Motor& motor = motors_[m].of(mechanism_);
      const bool comes = motor.drive == Drive::pushes && at_speed[m] == 0 && motor.most > 0 && !motor.late;
      if (comes && time_to_speed(motors_[m], state) <= no_time * step_) {
        at_speed[m] = 1;
        motor.drive = Drive::holds;
        changed = true;
        continue;
      }
      if (at_speed[m] == 0 || decided[m] != 0) continue;
      if (motor.drive == Drive::holds && std::fabs(motor_force(motors_[m])) > motor.most * (1 + limit_rounding)) {
        let_slip(m);
        decided[m] = 1;
        changed = true;
      }
    }
  }
  driven_acceleration_ = acceleration_;
  driven_error_ = largest_error();
}

void Motion::let_slip(std::size_t m) {
  Motor& motor = motors_[m].of(mechanism_);
  motor.force = std::copysign(motor.most, motor_force(motors_[m]));
  motor.drive = Drive::pushes;
}

void Motion::beyond(const State& state, Forces& forces, double t, std::vector<double>& shares) {
  feel(state, forces, t);
  shares.resize(motors_.size());
  for (std::size_t m = 0; m < motors_.size(); ++m) {
    Motor& motor = motors_[m].of(mechanism_);
    if (motor.drive == Drive::holds) {
      motor.force = motor_force(motors_[m]);
      shares[m] = std::fabs(motor.force) / motor.most - 1 - limit_rounding;
    } else if (motor.late) {
      shares[m] = -1;  // it comes to its velocity at the end
    } else {
      const double fast = too_fast(motors_[m], state);
      shares[m] = (motor.force > 0 ? fast : motor.force < 0 ? -fast : -1) / (1 + std::fabs(motor.velocity));
    }
  }
}

bool Motion::can_wait() const {
  return std::ranges::all_of(motors_, [this](const MotorPlace& place) {
    const Motor& motor = place.of(mechanism_);
    return motor.most <= 0 || (motor.late && std::fabs(motor.force) <= motor.most);
  });
}

void Motion::put_off(const std::vector<char>& bodies) {
  for (const MotorPlace& place : motors_) place.of(mechanism_).late = moves(place, bodies);
}

void Motion::expect(std::span<const double> gave, const std::vector<char>& off) {
  for (std::size_t m = 0; m < motors_.size(); ++m) {
    motors_[m].of(mechanism_).expected = gave.empty() || moves(motors_[m], off) ? 0 : gave[m];
  }
}

std::vector<double> Motion::gave(double h) const {
  std::vector<double> forces;
  for (const MotorPlace& place : motors_) {
    const Motor& motor = place.of(mechanism_);
    forces.push_back(motor.late && motor.most > 0 ? motor.force + motor.at_end / h : 0);
  }
  return forces;
}

std::vector<LateMotor> Motion::late(double h) const {
  std::vector<LateMotor> found;
  for (const MotorPlace& place : motors_) {
    const Motor& motor = place.of(mechanism_);
    if (!motor.late || h <= 0 || motor.most <= 0) continue;
    const double least = std::min(0.0, (-motor.most - motor.force) * h);
    const double most = std::max(0.0, (motor.most - motor.force) * h);
    found.push_back({place.joint, place.motor, least, most, std::clamp(motor.at_end, least, most), motor.force * h});
  }
  return found;
}

/// A state moved by the slopes of some stages; the first is of `from` itself.
void Motion::combine(const State& from, std::span<const RungeKutta::Part> parts, double h, State& sum) const {
  struct Slope {
    double time;
    const BodyNow* states;
    const Eigen::Vector4d* turn_rates;
    const Twist* accelerations;
  };
  std::array<Slope, most_stages> slopes;
  std::size_t count = 0;
  for (const auto& [stage, share] : parts) {
    const Stage& of = stages_[stage];
    slopes[count++] = {share * h, stage == 0 ? from.data() : of.state.data(), of.turn_rates.data(),
                       of.accelerations.data()};
  }
  for (std::size_t i = 0; i < from.size(); ++i) {
    BodyNow body = from[i];
    for (const Slope& slope : std::span(slopes).first(count)) {
      body.pose.position += slope.time * slope.states[i].twist.linear;
      body.pose.turn += slope.time * slope.turn_rates[i];
      body.twist.linear += slope.time * slope.accelerations[i].linear;
      body.twist.angular += slope.time * slope.accelerations[i].angular;
    }
    sum[i] = body;
  }
}

}  // namespace odeval::engine_rk4
