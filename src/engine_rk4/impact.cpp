#include "engine_rk4/impact.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace odeval::engine_rk4 {
namespace {

void add_impulse(const Contact& contact, double size, const State& state, std::vector<Wrench>& impulses) {
  const auto push = [&](std::size_t body, double signed_size) {
    if (body == world_body) return;
    const Vector3d force = signed_size * contact.normal;
    impulses[body].force += force;
    impulses[body].torque += (contact.point - state[body].pose.position).cross(force);
  };
  push(contact.a, size);
  push(contact.b, -size);
}

double along_normal(const Contact& contact, const State& state, const std::vector<Twist>& twists) {
  const auto of = [&](std::size_t body) -> double {
    if (body == world_body) return 0;
    const Vector3d arm = contact.point - state[body].pose.position;
    return contact.normal.dot(twists[body].linear + twists[body].angular.cross(arm));
  };
  return of(contact.a) - of(contact.b);
}

/// p >= 0, A p + b >= 0, p (A p + b) = 0, by projected Gauss-Seidel: A is positive semidefinite, and several contacts
/// may say the same, which this leaves undecided between them without harm to the velocities.
Eigen::VectorXd complementary(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  constexpr int most = 20000;
  const double enough = 1e-15 * b.cwiseAbs().maxCoeff();
  Eigen::VectorXd p = Eigen::VectorXd::Zero(b.size());
  for (int round = 0; round < most; ++round) {
    double change = 0;
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      if (!(a(i, i) > 0)) continue;  // a joint holds this direction
      const double wanted = std::max(0.0, p[i] - (a.row(i).dot(p) + b[i]) / a(i, i));
      change = std::max(change, a(i, i) * std::fabs(wanted - p[i]));
      p[i] = wanted;
    }
    if (change <= enough) break;
  }
  return p;
}

/// The change of all twists by complementary impulses at the contacts, given the right-hand side b.
std::vector<Twist> response(Motion& motion, const std::vector<Contact>& contacts, const Eigen::VectorXd& b,
                            const State& state) {
  const auto count = static_cast<Eigen::Index>(contacts.size());
  const std::vector<Wrench> none(state.size(), {Vector3d::Zero(), Vector3d::Zero()});
  Eigen::MatrixXd a(count, count);
  std::vector<Twist> change;
  for (Eigen::Index j = 0; j < count; ++j) {
    std::vector<Wrench> impulses = none;
    add_impulse(contacts[static_cast<std::size_t>(j)], 1, state, impulses);
    motion.respond(impulses, change);
    for (Eigen::Index i = 0; i < count; ++i) {
      a(i, j) = along_normal(contacts[static_cast<std::size_t>(i)], state, change);
    }
  }
  const Eigen::VectorXd p = complementary(a, b);
  std::vector<Wrench> impulses = none;
  for (Eigen::Index i = 0; i < count; ++i) add_impulse(contacts[static_cast<std::size_t>(i)], p[i], state, impulses);
  motion.respond(impulses, change);
  return change;
}

}  // namespace

double normal_speed(const Contact& contact, const State& state) {
  std::vector<Twist> twists;
  for (const BodyNow& body : state) twists.push_back(body.twist);
  return along_normal(contact, state, twists);
}

void strike(Motion& motion, const std::vector<Contact>& contacts, double rest_speed, State& state) {
  Eigen::VectorXd b(static_cast<Eigen::Index>(contacts.size()));
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double before = normal_speed(contacts[i], state);
    b[static_cast<Eigen::Index>(i)] = before < -rest_speed ? (1 + contacts[i].restitution) * before : before;
  }
  const std::vector<Twist> change = response(motion, contacts, b, state);
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i].twist.linear += change[i].linear;
    state[i].twist.angular += change[i].angular;
  }
}

void push_out(Motion& motion, const std::vector<Contact>& contacts, double depth, State& state) {
  Eigen::VectorXd b(static_cast<Eigen::Index>(contacts.size()));
  for (std::size_t i = 0; i < contacts.size(); ++i) b[static_cast<Eigen::Index>(i)] = depth - contacts[i].depth;
  if ((b.array() >= 0).all()) return;
  motion.displace(response(motion, contacts, b, state), state);
}

}  // namespace odeval::engine_rk4
