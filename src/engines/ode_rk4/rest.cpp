// What rests pushes on within the step as it did in the last one. At the end of the step its contacts are solved for
// all that they do in it, so that what rests has nowhere to fall, and velocities within the step are true.
#include <algorithm>
#include <cmath>
#include <utility>

#include "engines/ode_rk4/flight.hpp"

namespace odeval::engine_rk4 {
namespace {

// m/s^2 and of the way that it goes: a contact that is farther than this from where it was going is another.
constexpr double most_acceleration = 100, most_change = 0.5;
// Bodies that count as struck, of those in touch, for all are moved where an impact is looked for.
constexpr std::size_t least_struck = 8;
// Of a step: what contacts do in less says less than what they did before.
constexpr double long_enough = 0.1;
constexpr double same_face = 0.999;  // cosine
// m or rad, in a step, by one contact that nothing else opposed: what moves as far falls freely instead. A push that
// another has to cancel so nearly, as on a plate that bears many times its own mass, would throw it out as soon as one
// moved.
constexpr double most_way = 0.05;
constexpr double probe = 0.1;  // of a height that is known to the first order

Vector3d turned(const Vector3d& vector, const Vector3d& spin, double time) {
  return (vector + time * spin.cross(vector)).normalized();
}

/// Of its two bodies: the point moves with the one in which it moves less, as a ball's with the ball.
std::size_t steadier(const Contact& contact) { return contact.drifts[0].norm() < contact.drifts[1].norm() ? 0 : 1; }

}  // namespace

/// Bodies, and those that joints and what rests connect with them.
std::vector<char> Flight::reached(std::vector<char> bodies) const {
  const Mechanism& mechanism = motion_.mechanism();
  const auto moves = [&](std::size_t body) { return body != world_body && mechanism.bodies[body].inverse_mass > 0; };
  bool more = std::ranges::find(bodies, 1) != bodies.end();
  const auto pass_on = [&](const auto& pair) {
    if (!moves(pair.a) || !moves(pair.b) || bodies[pair.a] == bodies[pair.b]) return;
    bodies[pair.a] = bodies[pair.b] = 1;
    more = true;
  };
  while (std::exchange(more, false)) {
    for (const Joint& joint : mechanism.joints) pass_on(joint);
    for (const Contact& contact : resting_) pass_on(contact);
  }
  return bodies;
}

/// Bodies among which motors push, and something rests of which it is not known what it does: what does not push there
/// leaves what motors do to the end of the step, too.
std::vector<char> Flight::unsteady() const {
  std::vector<char> driven(here_.size(), 0), unsteady = driven;
  const auto mark = [](const auto& pair, std::vector<char>& bodies) {
    for (const std::size_t body : {pair.a, pair.b}) {
      if (body != world_body) bodies[body] = 1;
    }
  };
  for (const Joint& joint : motion_.mechanism().joints) {
    if (std::ranges::any_of(joint.motors, [](const Motor& motor) { return motor.most > 0; })) mark(joint, driven);
  }
  for (const Contact& contact : resting_) {
    if (!pushes_on(contact) && !held_fast(contact)) mark(contact, unsteady);
  }
  driven = reached(std::move(driven));
  unsteady = reached(std::move(unsteady));
  for (std::size_t i = 0; i < driven.size(); ++i) unsteady[i] = driven[i] != 0 && unsteady[i] != 0 ? 1 : 0;
  return unsteady;
}

/// Contacts at hand and bodies that feel them.
std::size_t Flight::struck_at_once() const {
  std::vector<char> struck(here_.size(), 0);
  for (const Contact& contact : contacts_) {
    for (const std::size_t body : {contact.a, contact.b}) {
      if (body != world_body) struck[body] = 1;
    }
  }
  struck = reached(std::move(struck));
  const auto count = static_cast<std::size_t>(std::ranges::count(struck, 1));
  const auto all = static_cast<std::size_t>(std::ranges::count(in_touch_, 1));
  return contacts_.size() + std::max(count, std::min(all, least_struck));
}

/// From `here_`, which is `after` into the step; motors that contacts act on push on likewise. Where no force acts
/// nothing does, and impulses alone keep energy and momenta to rounding; so they do at elastic contacts.
void Flight::push_on(double after) {
  pushing_.clear();
  mover().expect({}, {});
  forces_->pushes.clear();
  forces_->since = after;
  bool acts = static_cast<bool>(forces_->renew);
  for (std::size_t i = 0; i < here_.size(); ++i) {
    const Wrench& wrench = forces_->now[i];
    acts = acts || (in_touch_[i] != 0 && !(wrench.force.isZero(0) && wrench.torque.isZero(0)));
  }
  if (crowded_ > 0 || !acts) return;
  const std::vector<char> off = unsteady();
  const auto is_off = [&](std::size_t body) { return body != world_body && off[body] != 0; };
  mover().expect(gave_, off);
  for (const Contact& contact : resting_) {
    if (!pushes_on(contact) || is_off(contact.a) || is_off(contact.b)) continue;
    pushing_.push_back(contact);
    const std::size_t with = steadier(contact);
    forces_->pushes.push_back({contact.a, contact.b, with == 0 ? contact.a : contact.b, contact.arms[with],
                               contact.force, contact.torque, contact.drifts[with], contact.spin});
  }
}

/// The contacts at a state that comes `passed` after `here_`, and what they did until then. What pushed and is not
/// found, since it pushed too much, is put where it should be: what it does in all may not pull.
void Flight::arrive(const State& at, double passed) {
  look(at);
  const std::size_t found = contacts_.size();
  std::vector<char> known(found, 0);
  for (std::size_t k = 0; k < pushing_.size(); ++k) {
    const Push& push = forces_->pushes[k];
    Contact now = pushing_[k];
    now.point = push.point_after(passed, at);
    now.felt = passed * push.force_after(passed);
    now.felt_turn = passed * push.torque_after(passed);
    double nearest =
        is_only_one(now) ? HUGE_VAL : most_change * passed * push.drift.norm() + most_acceleration * passed * passed;
    Contact* same = nullptr;
    for (std::size_t i = 0; i < found; ++i) {
      const double away = (contacts_[i].point - now.point).norm();
      if (known[i] != 0 || contacts_[i].geoms != now.geoms || away > nearest) continue;
      if (now.is_stop && contacts_[i].normal.dot(now.normal) < 0) continue;
      nearest = away;
      same = &contacts_[i];
    }
    if (same != nullptr) {
      known[static_cast<std::size_t>(same - contacts_.data())] = 1;
      const double sign = same->a == now.a ? 1 : -1;
      same->felt = sign * now.felt;
      same->felt_turn = sign * now.felt_turn;
      same->followed = normal_speed(pushing_[k], here_) >= -options_.rest_speed;
      continue;
    }
    now.normal = turned(now.normal, push.spin, passed);
    // Faces of one pair of geoms have one normal: to go on as it turned would turn it away from step to step.
    double nearest_normal = same_face;
    for (std::size_t i = 0; i < found; ++i) {
      const Vector3d normal = contacts_[i].a == now.a ? contacts_[i].normal : Vector3d(-contacts_[i].normal);
      if (contacts_[i].geoms != now.geoms || normal.dot(now.normal) < nearest_normal) continue;
      nearest_normal = normal.dot(now.normal);
      now.normal = normal;
    }
    const auto moved = [&](std::size_t body, const Vector3d& arm) -> Vector3d {
      if (body == world_body) return Vector3d::Zero();
      const Vector3d turn = passed / 2 * (here_[body].twist.angular + at[body].twist.angular);
      if (now.turns) return turn;
      return at[body].pose.position - here_[body].pose.position + turn.cross(arm);
    };
    const auto arm_of = [&](std::size_t body) -> Vector3d { return now.arms[body] + passed / 2 * now.drifts[body]; };
    now.depth = rest_depth - now.normal.dot(moved(now.a, arm_of(0)) - moved(now.b, arm_of(1)));
    // Put a little too deep, it is found and pushed out; else it is gone.
    now.depth = std::min(now.depth, rest_depth);
    const double arm = std::max(now.arms[0].norm(), now.arms[1].norm()), turn = passed * now.spin.norm();
    now.depth -= probe * (rest_depth - now.depth) + rest_depth + arm * turn * turn;
    now.missed = true;
    contacts_.push_back(now);
  }
}

void Flight::place(Contact& contact, const State& at) {
  const auto arm = [&](std::size_t body) {
    return body == world_body ? contact.point : Vector3d(contact.point - at[body].pose.position);
  };
  contact.arms = {arm(contact.a), arm(contact.b)};
  contact.placed = true;
}

/// One that rests, and is placed, where it is at `here_`.
Contact Flight::at_start(Contact contact) const {
  contact.point = contact.arms[0];
  if (contact.a != world_body) contact.point += here_[contact.a].pose.position;
  return contact;
}

/// Moves what rests to where it is at a state when a time has passed since `here_`.
void Flight::remember(const State& at, double passed) {
  for (Contact& contact : resting_) {
    if (!contact.steady) continue;
    const std::size_t with = steadier(contact), body = with == 0 ? contact.a : contact.b;
    contact.point = contact.arms[with] + passed * contact.drifts[with];
    if (body != world_body) contact.point += at[body].pose.position;
    place(contact, at);
    contact.normal = turned(contact.normal, contact.spin, passed);
    contact.force += passed * contact.spin.cross(contact.force);
    contact.torque += passed * contact.spin.cross(contact.torque);
  }
}

/// Contacts at hand that rested before begin with what they pushed then; how they moved in a time h is how they move
/// on.
void Flight::recall(const State& at, double h) {
  for (Contact& contact : contacts_) {
    const Contact* const before = nearest_resting(contact);
    place(contact, at);
    if (before == nullptr) continue;
    const double sign = before->a == contact.a ? 1 : -1;
    contact.push = sign * before->push;
    contact.turn = sign * before->turn;
    contact.force = sign * before->force;
    contact.torque = sign * before->torque;
    if (!(h > 0) || !before->placed) continue;
    const auto fastest = [&](std::size_t body) {
      if (body == world_body) return 0.0;
      const BodyNow& now = here_[body];
      return now.twist.linear.norm() + now.twist.angular.norm() * (contact.point - now.pose.position).norm();
    };
    const Vector3d on_a = contact.arms[0] - before->arms[sign > 0 ? 0 : 1];
    const Vector3d on_b = contact.arms[1] - before->arms[sign > 0 ? 1 : 0];
    const Vector3d& way = on_a.norm() < on_b.norm() ? on_a : on_b;
    contact.steady = way.norm() <= h * (fastest(contact.a) + fastest(contact.b)) + most_acceleration * h * h;
    contact.drifts = {on_a / h, on_b / h};
    contact.came = sign * relative_velocity(at_start(*before), here_, here_);
    contact.spin = sign / h * before->normal.cross(contact.normal);
  }
}

/// To the contacts at hand, and of motors, what they did in a time h.
void Flight::note(const Impact& impact, const Eigen::VectorXd& impulses, double h) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& contact = contacts_[i];
    impact.note(impulses, i, contact);
    if (h < long_enough * step_) continue;
    if (impact.own_change(impulses, i) * h > most_way) contact.steady = false;
    contact.force = contact.push / h;
    contact.torque = contact.turn / h;
  }
  if (h >= long_enough * step_) gave_ = mover().gave(h);
}

/// On the way to a state that comes `passed` after `here_`, J: to the third order in that.
double Flight::work_of_pushes(const State& at, double passed) const {
  double sum = 0;
  for (const Push& push : forces_->pushes) {
    const Vector3d force = push.force_after(passed / 2), torque = push.torque_after(passed / 2);
    const auto power = [&](const State& state, double time) {
      const auto of = [&](std::size_t body) {
        if (body == world_body) return 0.0;
        const BodyNow& now = state[body];
        const Vector3d arm = push.point_after(time, state) - now.pose.position;
        return force.dot(now.twist.linear) + (torque + arm.cross(force)).dot(now.twist.angular);
      };
      return of(push.a) - of(push.b);
    };
    sum += passed * (power(here_, 0) + power(at, passed)) / 2;
  }
  return sum;
}

}  // namespace odeval::engine_rk4
