#include "engines/ode_rk4/impact.hpp"

#include <map>

#include "engines/ode_rk4/complementarity.hpp"
#include "engines/ode_rk4/restitution.hpp"

namespace odeval::engine_rk4 {
namespace {

std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

constexpr double held = 1e-12;  // of the change of speed that bodies without joints would have: a thousand roundings

double along(const Contact& contact, const Vector3d& arm, const Twist& twist) {
  if (contact.turns) return contact.normal.dot(twist.angular);
  return contact.normal.dot(twist.linear + twist.angular.cross(arm));
}

Wrench push(const Contact& contact, const Vector3d& arm, double size) {
  if (contact.turns) return {Vector3d::Zero(), size * contact.normal};
  return {size * contact.normal, size * arm.cross(contact.normal)};
}

}  // namespace

double normal_speed(const Contact& contact, const State& state) { return normal_speed(contact, state, state); }

double normal_speed(const Contact& contact, const State& found_at, const State& velocities) {
  const auto of = [&](std::size_t body) {
    if (body == world_body) return 0.0;
    return along(contact, contact.point - found_at[body].pose.position, velocities[body].twist);
  };
  return of(contact.a) - of(contact.b);
}

/// What a unit impulse changes of the speed between two bodies without joints.
double Impact::free_response(const Contact& contact) const {
  double sum = 0;
  for (const std::size_t body : {contact.a, contact.b}) {
    if (body == world_body) continue;
    const Vector3d arm = Vector3d::Zero();
    sum += along(contact, arm, motion_.free_change(body, push(contact, arm, 1)));
  }
  return sum;
}

Impact::Impact(Motion& motion, std::span<const Contact> contacts, const State& state)
    : motion_(motion), contacts_(contacts), impulses_(state.size()), change_(state.size()) {
  const auto count = static_cast<Eigen::Index>(contacts.size());
  for (const Contact& contact : contacts) {
    for (const std::size_t body : {contact.a, contact.b}) {
      arms_.push_back(body == world_body ? Vector3d::Zero() : Vector3d(contact.point - state[body].pose.position));
    }
  }
  response_ = Eigen::MatrixXd::Zero(count, count);
  const auto speed = [this](Eigen::Index i) {
    const Contact& contact = contacts_[index(i)];
    double sum = 0;
    if (contact.a != world_body) sum += along(contact, arms_[2 * index(i)], change_[contact.a]);
    if (contact.b != world_body) sum -= along(contact, arms_[2 * index(i) + 1], change_[contact.b]);
    return sum;
  };
  // Without joints an impulse moves its own two bodies only.
  std::vector<std::vector<Eigen::Index>> of_body(state.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    for (const std::size_t body : {contacts[index(i)].a, contacts[index(i)].b}) {
      if (body != world_body) of_body[body].push_back(i);
    }
  }
  for (Eigen::Index j = 0; j < count; ++j) {
    const Contact& contact = contacts[index(j)];
    if (motion_.jointed(contact.a) || motion_.jointed(contact.b)) {
      respond(Eigen::VectorXd::Unit(count, j));
      for (Eigen::Index i = 0; i < count; ++i) response_(i, j) = speed(i);
      continue;
    }
    for (Twist& twist : change_) twist = {Vector3d::Zero(), Vector3d::Zero()};
    double sign = 1;
    for (const std::size_t body : {contact.a, contact.b}) {
      if (body != world_body) {
        const Vector3d& arm = arms_[2 * index(j) + (sign > 0 ? 0 : 1)];
        change_[body] = motion_.free_change(body, push(contact, arm, sign));
      }
      sign = -1;
    }
    for (const std::size_t body : {contact.a, contact.b}) {
      if (body == world_body) continue;
      for (const Eigen::Index i : of_body[body]) response_(i, j) = speed(i);
    }
  }
  // What joints hold, an impulse moves by rounding only.
  for (Eigen::Index i = 0; i < count; ++i) {
    if (response_(i, i) > held * free_response(contacts[index(i)])) continue;
    response_.row(i).setZero();
    response_.col(i).setZero();
  }
}

void Impact::respond(const Eigen::VectorXd& sizes) const {
  for (Wrench& impulse : impulses_) impulse = {Vector3d::Zero(), Vector3d::Zero()};
  const auto add = [this](const Contact& contact, std::size_t body, const Vector3d& arm, double size) {
    if (body == world_body) return;
    const Wrench impulse = push(contact, arm, size);
    impulses_[body].force += impulse.force;
    impulses_[body].torque += impulse.torque;
  };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const double size = sizes[static_cast<Eigen::Index>(i)];
    if (size == 0) continue;
    add(contacts_[i], contacts_[i].a, arms_[2 * i], size);
    add(contacts_[i], contacts_[i].b, arms_[2 * i + 1], -size);
  }
  motion_.respond(impulses_, change_);
}

Eigen::VectorXd Impact::speeds(const State& state) const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(contacts_.size()));
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = normal_speed(contacts_[index(i)], state);
  return v;
}

void Impact::strike_by(const Eigen::VectorXd& impulses, State& state) const {
  respond(impulses);
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i].twist.linear += change_[i].linear;
    state[i].twist.angular += change_[i].angular;
  }
}

void Impact::strike(State& state, ImpactOrder order, double rest_speed) const {
  Restitution restitution{Eigen::VectorXd(static_cast<Eigen::Index>(contacts_.size())), rest_speed};
  std::map<std::pair<const void*, const void*>, std::size_t> numbers;
  std::vector<std::size_t> pair;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    restitution.of[static_cast<Eigen::Index>(i)] = contacts_[i].restitution;
    pair.push_back(numbers.emplace(contacts_[i].geoms, numbers.size()).first->second);
  }
  const Eigen::VectorXd before = speeds(state);
  strike_by(order == ImpactOrder::together ? strike_together(response_, before, restitution)
                                           : strike_in_turn(response_, before, restitution, pair),
            state);
}

void Impact::stop(State& state) const {
  const Eigen::VectorXd before = speeds(state);
  strike_by(strike_together(response_, before, {Eigen::VectorXd::Zero(before.size())}), state);
}

JointError Impact::push_out(double depth, State& state, std::span<const Twist> besides) const {
  Eigen::VectorXd b(static_cast<Eigen::Index>(contacts_.size()));
  for (std::size_t i = 0; i < contacts_.size(); ++i) b[static_cast<Eigen::Index>(i)] = depth - contacts_[i].depth;
  if (besides.empty() && (b.array() >= 0).all()) return {};
  respond(complementary(response_, b));
  for (std::size_t i = 0; i < besides.size(); ++i) {
    change_[i].linear += besides[i].linear;
    change_[i].angular += besides[i].angular;
  }
  return motion_.displace(change_, state);
}

}  // namespace odeval::engine_rk4
