#include "engines/ode_rk4/motion.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

// Rows that repeat others leave a pivot of rounding, 1e-16 of their diagonal element times the growth of elimination;
// a mechanism is within 1e-12 of a singular pose for no longer than it takes to pass it.
constexpr double redundant_pivot = 1e-12;

// m, rad. A correction of this size leaves its square, which is rounding; what a step of ordinary size needs is
// smaller.
constexpr double small_correction = 1e-7;
// Of a motor's velocity, and m/s or rad/s: it is there. Found to rounding by those who look for it.
constexpr double reached = 1e-9;
constexpr double no_time = 1e-3;          // of a step
constexpr double limit_rounding = 1e-12;  // of a motor's limit
// Of the stiffness that Runge's method of the fourth order bears: what turns with the motion may grow by the rest until
// the next check.
constexpr double bearable = 0.72;
constexpr double six_digits = 1e-5;  // that the error tells
constexpr int steps_between_checks = 16;
constexpr double closed = 1e-13;  // m, rad: a hundred roundings of a body's size

std::vector<Eigen::Index> rows_of(const std::vector<Joint>& joints) {
  std::vector<Eigen::Index> rows;
  for (const Joint& joint : joints) rows.push_back(joint.rows());
  return rows;
}

/// The largest L = h W (h k + d) that Runge's method of the fourth order bears, and all below it, of a spring of that
/// ERP: both roots z of z^2 + (1 - ERP) L z + ERP L = 0 are to keep |1 + z + z^2/2 + z^3/6 + z^4/24| <= 1. 2.78 of a
/// damper alone (ERP 0), 8 of a spring alone (ERP 1).
double stiffest(double erp) {
  using Complex = std::complex<double>;
  const auto grows = [erp](double large) {
    const double damping = (1 - erp) * large;
    const Complex root = std::sqrt(Complex(damping * damping - 4 * erp * large));
    for (const Complex z : {(-damping + root) / 2.0, (-damping - root) / 2.0}) {
      constexpr double rounding = 1e-12;
      if (std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))) > 1 + rounding) return true;
    }
    return false;
  };
  constexpr double grain = 0.01;
  constexpr int most = 800;
  int grains = 1;
  while (grains < most && !grows((grains + 1) * grain)) ++grains;
  return grains * grain;
}

}  // namespace

Eigen::Vector4d turn_rate(const Vector3d& w, const Eigen::Vector4d& q) {
  const Vector3d v = q.tail<3>();
  Eigen::Vector4d rate;
  rate[0] = -0.5 * w.dot(v);
  rate.tail<3>() = 0.5 * (q[0] * w + w.cross(v));
  return rate;
}

void turn_by(const Vector3d& angle, Eigen::Vector4d& q) {
  // Of half the angle; of a small one by series: what they leave out is below 1e-17.
  const double square = angle.squaredNorm() / 4;
  const bool small = square < 1e-8;
  const double half = small ? 0 : std::sqrt(square);
  const double sine = small ? 0.5 - square / 12 : std::sin(half) / (2 * half);
  const double w = small ? 1 - square / 2 : std::cos(half);
  const Vector3d u = sine * angle;
  const Vector3d v = q.tail<3>();
  const double scalar = w * q[0] - u.dot(v);
  q.tail<3>() = w * v + q[0] * u + u.cross(v);
  q[0] = scalar;
  // Of a length that is nearly 1 by series as well: what they leave out is below 1e-18.
  const double more = q.squaredNorm() - 1;
  if (std::fabs(more) < 1e-6) {
    q *= 1 - more * (0.5 - 0.375 * more);
  } else {
    q.normalize();
  }
}

Motion::Motion(Mechanism mechanism, int order, bool along_trees)
    : mechanism_(std::move(mechanism)),
      formula_(&runge_kutta(order)),
      tree_(along_trees ? Tree::of(mechanism_) : std::nullopt),
      matrix_(rows_of(mechanism_.joints), mechanism_.neighbours) {
  const std::size_t bodies = mechanism_.bodies.size();
  const std::size_t joints = mechanism_.joints.size();
  turns_.resize(bodies);
  jointed_.resize(bodies, 0);
  for (std::size_t j = 0; j < joints; ++j) {
    const Joint& joint = mechanism_.joints[j];
    jointed_[joint.a] = 1;
    if (joint.b != world_body) jointed_[joint.b] = 1;
    for (std::size_t k = 0; k < joint.motors.size(); ++k) motors_.push_back({j, k});
    if (!joint.springs.empty()) sprung_.push_back(j);
  }
  for (std::size_t i = 0; i < bodies; ++i) {
    if (mechanism_.bodies[i].damped()) damped_.push_back(i);
  }
  inverse_inertias_.resize(bodies);
  acceleration_.resize(bodies);
  correction_.resize(bodies);
  stages_.assign(formula_->stages.size(),
                 {State(bodies), std::vector<Eigen::Vector4d>(bodies), std::vector<Twist>(bodies)});
  const JointRows none{Matrix6::Zero(), Matrix6::Zero(), Vector6::Zero(), Vector6::Zero()};
  rows_.assign(joints, none);
  weighted_.resize(joints);
  lambda_.resize(joints);
  joint_forces_.resize(joints);
}

void Motion::turn(const State& state) {
  for (std::size_t i = 0; i < state.size(); ++i) {
    turns_[i] = rotation(state[i].pose.turn);
    inverse_inertias_[i].noalias() = turns_[i] * mechanism_.bodies[i].inverse_inertia * turns_[i].transpose();
  }
}

void Motion::look(const State& state) {
  if (tree_) {
    tree_->look(state);
    return;
  }
  turn(state);
  for (std::size_t j = 0; j < rows_.size(); ++j) constrain(mechanism_.joints[j], state, turns_, rows_[j]);
}

/// The columns of a joint at a body, for A: (J M^-1) J'. The linear part of a joint with a point is plus or minus the
/// identity in the point's three rows, and the rows of squares have none.
void Motion::add_product(std::size_t i, std::size_t j, std::size_t body, Matrix6& block) const {
  if (body == world_body) return;
  const Joint& one = mechanism_.joints[i];
  const Joint& other = mechanism_.joints[j];
  const JointRows& rows = rows_[j];
  const bool first = body == other.a;
  if (!first && body != other.b) return;
  const Matrix6& weighted = weighted_[i][body == one.a ? 0 : 1];
  const Matrix6& row = first ? rows.of_a : rows.of_b;
  block.noalias() += weighted.rightCols<3>() * row.rightCols<3>().transpose();
  if (!one.points.empty() && !other.points.empty()) {
    const bool same_side = (body == one.a) == first;
    block.diagonal().head<3>().array() += (same_side ? 1 : -1) * mechanism_.bodies[body].inverse_mass;
  } else {
    block.noalias() += weighted.leftCols<3>() * row.leftCols<3>().transpose();
  }
}

void Motion::factor() {
  if (tree_) {
    tree_->factor();
    return;
  }
  matrix_.clear();
  const auto weigh = [this](const Matrix6& row, std::size_t body, Matrix6& weighted) {
    if (body == world_body) return;
    weighted.leftCols<3>() = mechanism_.bodies[body].inverse_mass * row.leftCols<3>();
    weighted.rightCols<3>().noalias() = row.rightCols<3>() * inverse_inertias_[body];
  };
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const Joint& joint = mechanism_.joints[j];
    weigh(rows_[j].of_a, joint.a, weighted_[j][0]);
    weigh(rows_[j].of_b, joint.b, weighted_[j][1]);
    Matrix6& diagonal = matrix_.diagonal(j);
    add_product(j, j, joint.a, diagonal);
    add_product(j, j, joint.b, diagonal);
    // Motors that do not hold have no equation.
    for (std::size_t k = 0; k < joint.motors.size(); ++k) {
      const Eigen::Index row = joint.constraints() + static_cast<Eigen::Index>(k);
      if (joint.motors[k].drive != Drive::holds) diagonal(row, row) = 1;
    }
  }
  for (std::size_t p = 0; p < mechanism_.neighbours.size(); ++p) {
    auto [i, j] = mechanism_.neighbours[p];
    if (!matrix_.first_has_rows(p)) std::swap(i, j);
    add_product(i, j, mechanism_.joints[i].a, matrix_.pair(p));
    add_product(i, j, mechanism_.joints[i].b, matrix_.pair(p));
  }
  matrix_.factor(redundant_pivot);
}

void Motion::solve_onto(std::vector<Twist>& twists) {
  const auto add = [](const Matrix6& row, const Twist& twist, Vector6& to) {
    to.noalias() += row.leftCols<3>() * twist.linear;
    to.noalias() += row.rightCols<3>() * twist.angular;
  };
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const Joint& joint = mechanism_.joints[j];
    add(rows_[j].of_a, twists[joint.a], lambda_[j]);
    if (joint.b != world_body) add(rows_[j].of_b, twists[joint.b], lambda_[j]);
    lambda_[j] = -lambda_[j];
  }
  matrix_.solve(lambda_);
  const auto push = [](const Matrix6& weighted, const Vector6& lambda, Twist& twist) {
    twist.linear.noalias() += weighted.leftCols<3>().transpose() * lambda;
    twist.angular.noalias() += weighted.rightCols<3>().transpose() * lambda;
  };
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const Joint& joint = mechanism_.joints[j];
    push(weighted_[j][0], lambda_[j], twists[joint.a]);
    if (joint.b != world_body) push(weighted_[j][1], lambda_[j], twists[joint.b]);
  }
}

void Motion::accelerate(const State& state, const std::vector<Wrench>& forces, std::vector<Twist>& accelerations) {
  look(state);
  factor();
  if (tree_) {
    tree_->accelerate(state, forces, accelerations);
    return;
  }
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Body& body = mechanism_.bodies[i];
    const Vector3d& w = state[i].twist.angular;
    const Vector3d spin = turns_[i] * (body.inertia * (turns_[i].transpose() * w));
    accelerations[i].linear = body.inverse_mass * forces[i].force;
    accelerations[i].angular.noalias() = inverse_inertias_[i] * (forces[i].torque - w.cross(spin));
  }
  for (const MotorPlace& place : motors_) {
    const Motor& motor = place.of(mechanism_);
    if (motor.drive != Drive::pushes) continue;
    const Joint& joint = mechanism_.joints[place.joint];
    push_along(joint, line_of(joint, motor, state, turns_), motor.slides, motor.force, accelerations);
  }
  for (const std::size_t j : sprung_) {
    const Joint& joint = mechanism_.joints[j];
    for (const Spring& spring : joint.springs) {
      push_along(joint, line_of(joint, spring, state, turns_), true, pull(joint, spring, state, turns_), accelerations);
    }
  }
  for (const std::size_t i : damped_) {
    const Body& body = mechanism_.bodies[i];
    const Twist& twist = state[i].twist;
    accelerations[i].linear -= body.linear.of(twist.linear) * twist.linear;
    accelerations[i].angular -= body.angular.of(twist.angular) * twist.angular;
  }
  for (std::size_t j = 0; j < rows_.size(); ++j) lambda_[j] = rows_[j].bias;
  solve_onto(accelerations);
}

/// On a, and the other way on b.
void Motion::push_along(const Joint& joint, const MotorLine& line, bool slides, double force,
                        std::vector<Twist>& accelerations) {
  const auto push = [&](std::size_t body, const Vector3d& arm, const Vector3d& by) {
    if (body == world_body) return;
    const Twist change = free_change(body, slides ? Wrench{by, arm.cross(by)} : Wrench{Vector3d::Zero(), by});
    accelerations[body].linear += change.linear;
    accelerations[body].angular += change.angular;
  };
  push(joint.a, line.on_a, force * line.axis);
  push(joint.b, line.on_b, -force * line.axis);
}

/// As in ODE, who is joined to one that is awake is.
void Motion::wake() {
  bool some = false;
  for (Body& body : mechanism_.bodies) {
    body.asleep = dBodyIsEnabled(body.id) == 0;
    some = some || body.asleep;
  }
  const auto awake = [this](std::size_t body) {
    return body != world_body && !mechanism_.bodies[body].asleep && mechanism_.bodies[body].inverse_mass > 0;
  };
  for (bool woken = some; woken;) {
    woken = false;
    for (const Joint& joint : mechanism_.joints) {
      if (joint.b == world_body || awake(joint.a) == awake(joint.b)) continue;
      Body& other = mechanism_.bodies[awake(joint.a) ? joint.b : joint.a];
      woken = woken || other.asleep;
      other.asleep = false;
    }
  }
  if (!some) return;
  for (const MotorPlace& place : motors_) {
    const Joint& joint = mechanism_.joints[place.joint];
    if (!awake(joint.a) && !awake(joint.b)) place.of(mechanism_).most = 0;
  }
}

void Motion::prepare(double h) {
  if (h != step_) steps_unchecked_ = 0;
  step_ = h;
  if (has_motors()) read_motors(mechanism_);
  wake();
  for (const std::size_t i : damped_) {
    mechanism_.bodies[i].linear.stand_for(h);
    mechanism_.bodies[i].angular.stand_for(h);
  }
  for (const std::size_t j : sprung_) {
    Joint& joint = mechanism_.joints[j];
    for (Spring& spring : joint.springs) {
      spring.stiffness = spring.erp / (h * spring.cfm);
      spring.damping = (1 - spring.erp) / spring.cfm;
      if (mechanism_.bodies[joint.a].asleep) spring.stiffness = spring.damping = 0;
    }
  }
}

/// Runge's method follows u' = -W (h k + d) u, W the change of the springs' speeds by an impulse at each, joints kept,
/// where no eigenvalue of h W (h k + d) is too large for the least ERP among them: h k + d is 1 / CFM.
void Motion::check_springs(const State& state) {
  if (sprung_.empty() || steps_unchecked_++ % steps_between_checks != 0) return;
  struct Place {
    const Joint& joint;
    const Spring& spring;
    MotorLine line;
    double weight;  // the root of h / CFM
  };
  release();
  look(state);
  factor();
  std::vector<Place> places;
  double most = std::numeric_limits<double>::infinity();
  for (const std::size_t j : sprung_) {
    const Joint& joint = mechanism_.joints[j];
    if (mechanism_.bodies[joint.a].asleep) continue;
    for (const Spring& spring : joint.springs) {
      most = std::min(most, bearable * stiffest(spring.erp));
      places.push_back({joint, spring, line_of(joint, spring, state, turns_), std::sqrt(step_ / spring.cfm)});
    }
  }
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd answers(count, count);
  State moved = state;
  std::vector<Twist> change(state.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Place& from = places[static_cast<std::size_t>(k)];
    for (Twist& twist : change) twist = {Vector3d::Zero(), Vector3d::Zero()};
    push_along(from.joint, from.line, true, 1, change);
    for (Vector6& lambda : lambda_) lambda.setZero();
    solve_onto(change);
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i].twist = change[i];
    for (Eigen::Index i = 0; i < count; ++i) {
      const Place& to = places[static_cast<std::size_t>(i)];
      answers(i, k) = from.weight * to.weight * motor_speed(to.joint, to.line, true, moved);
    }
  }
  if (count == 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(answers);
  const double largest = modes.eigenvalues()[count - 1];
  if (largest <= most * (1 + six_digits)) return;
  Eigen::Index worst = 0;
  modes.eigenvectors().col(count - 1).cwiseAbs().maxCoeff(&worst);
  const auto& [joint, spring, line, weight] = places[static_cast<std::size_t>(worst)];
  refuse(name(joint) + " has a suspension that is stiffer than a step of " + shown(step_) +
             " s follows; raise its dParamSuspensionCFM to " + shown(spring.cfm * largest / most) +
             " or more, or set it to 0: rigid",
         mechanism_.bodies[joint.a].id, joint.id);
}

void Motion::release() {
  for (const MotorPlace& place : motors_) place.of(mechanism_).drive = Drive::released;
}

void Motion::feel(const State& state, Forces& forces, double t) {
  if (forces.renew) forces.renew(t, state, forces.now);
  accelerate(state, forces.now, acceleration_);
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
      motor.drive = motor.late ? Drive::released : Drive::pushes;
      motor.force = motor.late ? 0 : std::copysign(motor.most, -fast);
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
      const bool comes = motor.drive == Drive::pushes && at_speed[m] == 0 && motor.most > 0;
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
    } else {
      const double fast = too_fast(motors_[m], state);
      shares[m] = (motor.force > 0 ? fast : motor.force < 0 ? -fast : -1) / (1 + std::fabs(motor.velocity));
    }
  }
}

void Motion::put_off(const std::vector<char>& bodies) {
  for (const MotorPlace& place : motors_) {
    const Joint& joint = mechanism_.joints[place.joint];
    place.of(mechanism_).late = bodies[joint.a] != 0 || (joint.b != world_body && bodies[joint.b] != 0);
  }
}

std::vector<LateMotor> Motion::late(double h) const {
  std::vector<LateMotor> found;
  for (const MotorPlace& place : motors_) {
    const Motor& motor = place.of(mechanism_);
    if (!motor.late || h <= 0 || motor.most <= 0) continue;
    const double least = std::min(0.0, (-motor.most - motor.force) * h);
    const double most = std::max(0.0, (motor.most - motor.force) * h);
    found.push_back({place.joint, place.motor, least, most, std::clamp(motor.at_end, least, most)});
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

JointErrors Motion::step(const State& from, Forces& forces, double h, State& to, bool driven) {
  JointError start_error;
  for (std::size_t s = 0; s < stages_.size(); ++s) {
    Stage& stage = stages_[s];
    if (s > 0) combine(from, formula_->stages[s].from, h, stage.state);
    const State& at = s > 0 ? stage.state : from;
    if (driven && s == 0) {
      stage.accelerations = driven_acceleration_;
      start_error = driven_error_;
    } else {
      if (forces.renew) forces.renew(forces.start + formula_->stages[s].at * h, at, forces.now);
      accelerate(at, forces.now, stage.accelerations);
      if (s == 0) start_error = largest_error();
    }
    for (std::size_t i = 0; i < from.size(); ++i) {
      stage.turn_rates[i] = turn_rate(at[i].twist.angular, at[i].pose.turn);
    }
  }
  to.resize(from.size());
  combine(from, formula_->weights, h, to);
  tell_forces(stages_.back().state);
  for (const MotorPlace& place : motors_) {
    Motor& motor = place.of(mechanism_);
    if (motor.drive == Drive::holds) motor.force = motor_force(place);
  }
  look(to);
  const JointError found = largest_error();
  if (!(found.size < small_correction)) factor();  // or the last stage's matrix, near enough, will do
  return {start_error, finish(to, found).after};   // which makes unit quaternions
}

JointError Motion::largest_error() {
  if (tree_) return tree_->find_gaps();
  JointError largest;
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const double error = rows_[j].error.cwiseAbs().maxCoeff();
    if (error > largest.size || std::isnan(error)) largest = {error, j};
  }
  return largest;
}

JointError Motion::displace(const std::vector<Twist>& by, State& state) {
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i].pose.position += by[i].linear;
    turn_by(by[i].angular, state[i].pose.turn);
  }
  return project(state).after;
}

JointErrors Motion::project(State& state) {
  release();
  if (tree_) turn(state);  // for `free_change`
  look(state);
  factor();
  return finish(state, largest_error());
}

/// Newton's method on the rows at hand, with the matrix at hand or, where that is not enough, newer ones.
JointErrors Motion::finish(State& state, const JointError& found) {
  JointErrors errors{found, {}};
  const bool small = errors.before.size < small_correction;
  if (small) project_velocities(state);
  // It at least halves the error a round or has failed: then the caller judges what is left.
  for (double error = errors.before.size;;) {
    correct(state);
    if (error < small_correction && matrix_.left_out() == 0) {
      errors.after = {};  // its square
      break;
    }
    look(state);
    errors.after = largest_error();
    if (errors.after.size <= closed || !(errors.after.size < error / 2)) break;
    error = errors.after.size;
    factor();
  }
  if (!small) project_velocities(state);
  return errors;
}

void Motion::project_velocities(State& state) {
  if (tree_) {
    tree_->agree(state, correction_);
    for (std::size_t i = 0; i < state.size(); ++i) {
      state[i].twist.linear += correction_[i].linear;
      state[i].twist.angular += correction_[i].angular;
    }
    return;
  }
  for (std::size_t i = 0; i < state.size(); ++i) correction_[i] = state[i].twist;
  for (Vector6& lambda : lambda_) lambda.setZero();
  for (const MotorPlace& place : motors_) {
    const Motor& motor = place.of(mechanism_);
    const Joint& joint = mechanism_.joints[place.joint];
    const Eigen::Index row = joint.constraints() + static_cast<Eigen::Index>(place.motor);
    if (motor.drive == Drive::holds) lambda_[place.joint][row] = -motor.velocity;
  }
  solve_onto(correction_);
  for (std::size_t i = 0; i < state.size(); ++i) state[i].twist = correction_[i];
}

void Motion::correct(State& state) {
  if (tree_) {
    tree_->close(correction_);
  } else {
    for (std::size_t j = 0; j < rows_.size(); ++j) lambda_[j] = rows_[j].error;
    for (Twist& twist : correction_) twist = {Vector3d::Zero(), Vector3d::Zero()};
    solve_onto(correction_);
  }
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i].pose.position += correction_[i].linear;
    turn_by(correction_[i].angular, state[i].pose.turn);
  }
}

void Motion::respond(const std::vector<Wrench>& impulses, std::vector<Twist>& change) {
  change.resize(impulses.size());
  if (tree_) {
    tree_->respond(impulses, change);
    return;
  }
  for (std::size_t i = 0; i < impulses.size(); ++i) {
    change[i] = free_change(i, impulses[i]);
  }
  for (Vector6& lambda : lambda_) lambda.setZero();
  solve_onto(change);
}

/// Of a joint's equations, at the last solution.
Motion::JointForce Motion::reaction(std::size_t joint) const {
  if (tree_) return {tree_->force(joint, true), tree_->force(joint, false)};
  const auto of = [&](const Matrix6& row) {
    const Vector6 f = row.transpose() * lambda_[joint];
    return Wrench{f.head<3>(), f.tail<3>()};
  };
  return {of(rows_[joint].of_a), of(rows_[joint].of_b)};
}

/// At the state of the last `accelerate`.
void Motion::tell_forces(const State& state) {
  for (std::size_t j = 0; j < joint_forces_.size(); ++j) {
    const Joint& joint = mechanism_.joints[j];
    if (!tells(joint)) continue;
    JointForce& sum = joint_forces_[j];
    sum = reaction(j);
    const auto add = [&](const MotorLine& line, bool slides, double size) {
      const Vector3d force = size * line.axis;
      if (slides) {
        sum.on_a += {force, line.on_a.cross(force)};
        sum.on_b += {-force, -line.on_b.cross(force)};
      } else {
        sum.on_a.torque += force;
        sum.on_b.torque -= force;
      }
    };
    for (const Motor& motor : joint.motors) {
      if (motor.drive == Drive::pushes) add(line_of(joint, motor, state, turns_), motor.slides, motor.force);
    }
    for (const Spring& spring : joint.springs) {
      add(line_of(joint, spring, state, turns_), true, pull(joint, spring, state, turns_));
    }
  }
}

void Motion::find_forces(const State& state, Forces& forces, double t) {
  feel(state, forces, t);
  tell_forces(state);
}

void Motion::add_forces(double time) {
  for (std::size_t j = 0; j < joint_forces_.size(); ++j) {
    if (!tells(mechanism_.joints[j])) continue;
    const auto [on_a, on_b] = reaction(j);
    joint_forces_[j].on_a += {on_a.force / time, on_a.torque / time};
    joint_forces_[j].on_b += {on_b.force / time, on_b.torque / time};
  }
}

void Motion::add_force(const void* id, const Wrench& on_a, const Wrench& on_b) {
  for (std::size_t j = 0; j < joint_forces_.size(); ++j) {
    if (mechanism_.joints[j].id != id) continue;
    joint_forces_[j].on_a += on_a;
    joint_forces_[j].on_b += on_b;
  }
}

}  // namespace odeval::engine_rk4
