// What contacts may give: no more than they took.
#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/flight.hpp"
#include "engines/ode_rk4/islands.hpp"

namespace odeval::engine_rk4 {
namespace {

constexpr double energy_rounding = 1e-14;  // of kinetic energy
constexpr double place_rounding = 1e-15;   // of a position: of what forces do along a way
constexpr int most_shortenings = 5;        // of a way out, which costs nearly as much as it is long

Eigen::Quaterniond turn_of(const Pose& pose) { return {pose.turn[0], pose.turn[1], pose.turn[2], pose.turn[3]}; }

double kinetic_energy(const Body& body, const BodyNow& now) {
  if (body.inverse_mass == 0) return 0;
  const Vector3d spin = turn_of(now.pose).conjugate() * now.twist.angular;
  return now.twist.linear.squaredNorm() / (2 * body.inverse_mass) + spin.dot(body.inertia * spin) / 2;
}

/// Velocities of two states at the poses of the second.
State mixed(const State& one, State other, double share_of_other) {
  for (std::size_t i = 0; i < other.size(); ++i) {
    Twist& twist = other[i].twist;
    twist.linear = one[i].twist.linear + share_of_other * (twist.linear - one[i].twist.linear);
    twist.angular = one[i].twist.angular + share_of_other * (twist.angular - one[i].twist.angular);
  }
  return other;
}

}  // namespace

/// Counts in what contacts reach: what nothing touches has errors of its own, which are not for contacts to pay.
void Flight::count_in(const std::vector<Contact>& contacts) {
  bool more = false;
  for (const Contact& contact : contacts) {
    for (const std::size_t body : {contact.a, contact.b}) {
      if (body == world_body || in_touch_[body] != 0) continue;
      in_touch_[body] = 1;
      more = true;
    }
  }
  if (more) in_touch_ = reached(std::move(in_touch_));
}

double Flight::rounding_of_energy(const State& state) const {
  double sum = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (in_touch_[i] == 0) continue;
    sum += energy_rounding * kinetic_energy(motion_.mechanism().bodies[i], state[i]);
    sum += place_rounding * forces_->now[i].force.norm() * state[i].pose.position.norm();
  }
  return sum;
}

/// Do only forces work that are the same all the while, on what is in touch, besides drag, which takes?
bool Flight::passive() const {
  if (forces_->renew) return false;
  const Mechanism& mechanism = motion_.mechanism();
  const auto is_in = [&](std::size_t body) { return body != world_body && in_touch_[body] != 0; };
  const auto works = [&](std::size_t body) {
    if (body == world_body) return false;
    const Twist& twist = here_[body].twist;
    const bool moves = !(twist.linear.isZero(0) && twist.angular.isZero(0));
    return (mechanism.bodies[body].inverse_mass <= 0 && moves) || !forces_->now[body].torque.isZero(0);
  };
  for (const Joint& joint : mechanism.joints) {
    if (!is_in(joint.a) && !is_in(joint.b)) continue;
    if (!joint.motors.empty() || !joint.springs.empty() || works(joint.a) || works(joint.b)) return false;
  }
  for (std::size_t i = 0; i < here_.size(); ++i) {
    if (is_in(i) && works(i)) return false;
  }
  return true;
}

/// And nothing drags.
bool Flight::conservative() const {
  for (std::size_t i = 0; i < here_.size(); ++i) {
    if (in_touch_[i] != 0 && motion_.mechanism().bodies[i].damped()) return false;
  }
  return passive();
}

/// Bodies that hang together by what touches and by joints.
struct Flight::Group {
  std::vector<char> bodies;
  bool touches = false;
  bool held = false;    // by something that they do not move
  bool driven = false;  // by something that moves of itself
  bool elastic = true;  // all contacts, and none rubs
};

Flight::Group Flight::group_of(std::size_t first, const State& state) const {
  const Mechanism& mechanism = motion_.mechanism();
  Group group{std::vector<char>(state.size(), 0)};
  group.bodies[first] = 1;
  group.bodies = reached(std::move(group.bodies));
  const auto is_in = [&](std::size_t body) { return body != world_body && group.bodies[body] != 0; };
  const auto look = [&](std::size_t body) {
    if (is_in(body)) return;
    group.held = true;
    if (body == world_body) return;
    const Twist& twist = state[body].twist;
    group.driven = group.driven || !(twist.linear.isZero(0) && twist.angular.isZero(0));
  };
  for (const Joint& joint : mechanism.joints) {
    if (is_in(joint.a) || is_in(joint.b)) look(joint.a), look(joint.b);
  }
  for (const Contact& contact : resting_) {
    if (!is_in(contact.a) && !is_in(contact.b)) continue;
    look(contact.a), look(contact.b);
    group.touches = true;
    group.elastic = group.elastic && contact.restitution == 1 && contact.friction + contact.rho + contact.rhoN == 0;
  }
  return group;
}

/// Bodies that nothing holds move on as one, with the momenta that they have; others stand.
void Flight::move_rigidly(const Group& group, State& state) const {
  std::vector<std::size_t> bodies;
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (group.bodies[i] != 0) bodies.push_back(i);
  }
  const Twist still{Vector3d::Zero(), Vector3d::Zero()};
  const RigidMotion whole = group.held ? RigidMotion{} : shared_motion(motion_.mechanism(), state, bodies);
  for (const std::size_t i : bodies) state[i].twist = group.held ? still : whole.at(state[i].pose.position);
}

/// Groups that touch something pay by their motion for what more energy they have than before, and get back what they
/// have less where all is elastic; their momenta stay where nothing holds them. What moves of itself works, and pays
/// nothing. `work`: of motors. Returns the bodies of those that have not so much.
std::vector<char> Flight::pay(const State& before, double work, State& state) const {
  std::vector<char> met(state.size(), 0), poor(state.size(), 0);
  for (std::size_t first = 0; first < state.size(); ++first) {
    if (met[first] != 0 || motion_.mechanism().bodies[first].inverse_mass <= 0) continue;
    const Group group = group_of(first, state);
    State moved = before, slow = state;
    for (std::size_t i = 0; i < state.size(); ++i) {
      if (group.bodies[i] == 0) continue;
      met[i] = 1;
      moved[i] = state[i];
    }
    if (!group.touches || group.driven) continue;
    const double gain = gained(before, moved) - work;
    const bool gives_back = group.elastic && conservative() && gain < 0;
    if (gain <= rounding_of_energy(before) && !gives_back) continue;
    move_rigidly(group, slow);
    const double kinetic = gained(slow, state);
    const bool can = kinetic > std::fabs(gain);
    const double share = can ? std::sqrt(1 - gain / kinetic) : 1;
    for (std::size_t i = 0; i < state.size(); ++i) {
      if (group.bodies[i] == 0) continue;
      poor[i] = can || gain < 0 ? 0 : 1;
      Twist& twist = state[i].twist;
      twist.linear = slow[i].twist.linear + share * (twist.linear - slow[i].twist.linear);
      twist.angular = slow[i].twist.angular + share * (twist.angular - slow[i].twist.angular);
    }
  }
  return poor;
}

/// Of the bodies that can not pay for what they gained since `start`, those that stand, on something that does too, and
/// are off by no more than what joints are mended by, stay where they were. Returns whether all of them do.
bool Flight::stay(const State& start, const std::vector<char>& poor, State& state) const {
  std::vector<char> met(state.size(), 0);
  bool all = true;
  for (std::size_t first = 0; first < state.size(); ++first) {
    if (poor[first] == 0 || met[first] != 0) continue;
    const Group group = group_of(first, state);
    double farthest = 0;
    for (std::size_t i = 0; i < state.size(); ++i) {
      if (group.bodies[i] == 0) continue;
      met[i] = 1;
      const Vector3d way = state[i].pose.position - start[i].pose.position;
      const Vector3d turn = 2 * (turn_of(state[i].pose) * turn_of(start[i].pose).conjugate()).vec();
      farthest = std::max({farthest, way.norm(), turn.norm()});
    }
    const bool stands = group.held && farthest <= mendable;
    all = all && stands;
    for (std::size_t i = 0; stands && i < state.size(); ++i) {
      if (group.bodies[i] != 0) state[i] = start[i];
    }
  }
  return all;
}

/// At the end of a step: what rests on each other, or `rested` when it began, has no more energy than then, but for
/// what lifts bodies out of the overlaps that they started with, and where all is elastic no less. Errors of the order
/// of the step are paid by the motion; what stands has none to pay with. Bodies that struck each other share theirs.
bool Flight::keep_energy(const State& start, const std::vector<Contact>& rested, double lift) {
  bool paid = true;
  const std::vector<Contact> rest = resting_;
  resting_.insert(resting_.end(), rested.begin(), rested.end());
  if (!resting_.empty()) {
    resting_.insert(resting_.end(), bounced_.begin(), bounced_.end());
    const double gain = gained(start, there_), rounding = rounding_of_energy(there_);
    const auto elastic = [](const Contact& contact) { return contact.restitution == 1; };
    const bool lost = gain < -rounding && conservative() && std::ranges::any_of(resting_, elastic);
    if (gain > lift + rounding || lost) {
      paid = stay(start, pay(start, 0, there_), there_);
    }
  }
  resting_ = rest;
  taken_ = std::clamp(taken_, 0.0, lift);
  return paid;
}

/// Energy that comes from nowhere from one state to another, J: of motion, less the work of forces; of what is in
/// touch.
double Flight::gained(const State& from, const State& to) const {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (in_touch_[i] == 0) continue;
    const Body& body = motion_.mechanism().bodies[i];
    sum += kinetic_energy(body, to[i]) - kinetic_energy(body, from[i]);
    if (body.inverse_mass > 0) sum -= forces_->now[i].force.dot(to[i].pose.position - from[i].pose.position);
  }
  return sum;
}

/// With poses moved on, joints not kept.
double Flight::gained(const State& from, const State& to, std::span<const Twist> by) const {
  State moved = to;
  for (std::size_t i = 0; i < by.size(); ++i) {
    moved[i].pose.position += by[i].linear;
    turn_by(by[i].angular, moved[i].pose.turn);
  }
  return gained(from, moved);
}

/// A bounce with less energy, down to none: of velocities between those without restitution and those with.
State Flight::slowed(const State& still, const State& struck, double by) const {
  const double most = gained(still, struck);  // s of a bounce has a s^2 + b s
  const double a = 2 * (most - 2 * gained(still, mixed(still, struck, 0.5)));
  const double b = most - a;
  const double left = std::max(0.0, most - by);
  const double root = b + std::sqrt(std::max(0.0, b * b + 4 * a * left));
  return mixed(still, struck, root > 0 ? std::clamp(2 * left / root, 0.0, 1.0) : 0);
}

/// Moves poses along a way, as far as joints keep, and as far as no more than `most` is gained since the contacts at
/// hand struck bodies that were `free`. Returns false if it had to stay. Where `most` is `taken_`, energy is never more
/// than at first and what lifts bodies out of the overlaps that they start with (`begin`), but for rounding; but for
/// the work of forces that change along the way, and of torques.
bool Flight::move_out(Motion& motion, const State& free, std::span<const Twist> way, double most, State& state) {
  if (way.empty()) return true;
  const State before = state;
  const double taken = gained(free, before);
  const double allowed = most + rounding_of_energy(free);
  std::vector<Twist> part(way.begin(), way.end());
  for (int round = 0; round < most_shortenings; ++round) {
    if (!(motion.displace(part, state).size <= mendable)) break;
    const double gain = gained(free, state);
    if (gain <= allowed) return true;
    const double share = std::clamp((most - taken) / (gain - taken), 0.0, 1.0);
    for (Twist& twist : part) twist = {share * twist.linear, share * twist.angular};
    state = before;
  }
  state = before;
  return false;
}

}  // namespace odeval::engine_rk4
