// What contacts may give: no more than they took.
#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/flight.hpp"

namespace odeval::engine_rk4 {
namespace {

constexpr double energy_rounding = 1e-14;  // of kinetic energy
constexpr int most_shortenings = 5;        // of a way out, which costs nearly as much as it is long

double kinetic_energy(const Body& body, const BodyNow& now) {
  if (body.inverse_mass == 0) return 0;
  const Eigen::Quaterniond turn(now.pose.turn[0], now.pose.turn[1], now.pose.turn[2], now.pose.turn[3]);
  const Vector3d spin = turn.conjugate() * now.twist.angular;
  return now.twist.linear.squaredNorm() / (2 * body.inverse_mass) + spin.dot(body.inertia * spin) / 2;
}

double kinetic_energy(const Mechanism& mechanism, const State& state) {
  double sum = 0;
  for (std::size_t i = 0; i < state.size(); ++i) sum += kinetic_energy(mechanism.bodies[i], state[i]);
  return sum;
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

double Flight::rounding_of_energy(const State& state) const {
  return energy_rounding * kinetic_energy(motion_.mechanism(), state);
}

/// Energy that comes from nowhere from one state to another, J: of motion, less the work of forces.
double Flight::gained(const State& from, const State& to) const {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
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
