#include "engines/ode_rk4/motion.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::engine_rk4 {
namespace {

// Rows that repeat others leave a pivot of rounding, 1e-16 of their diagonal element times the growth of elimination;
// a mechanism is within 1e-12 of a singular pose for no longer than it takes to pass it.
constexpr double redundant_pivot = 1e-12;

// m, rad. A correction of this size leaves its square, which is rounding; what a step of ordinary size needs is
// smaller.
constexpr double small_correction = 1e-7;
constexpr double opened = 1e-11;  // m, rad: by more, speeds along joints that close are no rounding
constexpr double closed = 1e-13;  // m, rad: a hundred roundings of a body's size

std::vector<Eigen::Index> rows_of(const std::vector<Joint>& joints) {
  std::vector<Eigen::Index> rows;
  for (const Joint& joint : joints) rows.push_back(joint.rows());
  return rows;
}

}  // namespace

const std::vector<Wrench>& Forces::all(double t, const State& state) {
  if (pushes.empty()) return now;
  sum_ = now;
  for (const Push& push : pushes) {
    const double time = t - since;
    const Vector3d point = push.point_after(time, state), force = push.force_after(time),
                   torque = push.torque_after(time);
    const auto add = [&](std::size_t body, double sign) {
      if (body == world_body) return;
      sum_[body] += {sign * force, sign * (torque + (point - state[body].pose.position).cross(force))};
    };
    add(push.a, 1);
    add(push.b, -1);
  }
  return sum_;
}

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
  q.normalize();
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
      accelerate(at, forces.at(forces.start + formula_->stages[s].at * h, at), stage.accelerations);
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
  const JointErrors errors = project(state);
  // Velocities were taken to the joints before they closed.
  return errors.before.size > opened ? project(state).after : errors.after;
}

void Motion::stand(const State& state) {
  release();
  if (tree_) turn(state);  // for `free_change`
  look(state);
  factor();
}

JointErrors Motion::project(State& state) {
  stand(state);
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
