#include "engines/ode_rk4/impact.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "engines/ode_rk4/complementarity.hpp"
#include "engines/ode_rk4/islands.hpp"
#include "engines/ode_rk4/restitution.hpp"

namespace odeval::engine_rk4 {
namespace {

std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

constexpr double rounding = 1e-12;     // of the fastest speed, of the largest impulse
constexpr double still = 1e-15;        // m/s, rad/s: what is left after another impact; moves no pose beyond rounding
constexpr double sliding = 1e-7;       // m/s: slower is sticking, within 1e-10 m in a step of a millisecond
constexpr double sliding_way = 1e-11;  // m: what sticks before it has slid so far did all the while
// Of the largest: contacts that say what others say, nearly. Their gaps may contradict each other, and a way out of
// that would be long.
constexpr double same_row = 1e-3;
constexpr double farthest = 100;  // times what overlaps: out of its way, and at the ends of levers
constexpr int sweeps_out = 20;
constexpr double hovering = 1e-4;  // m: what left slower than it takes to leave is no higher, in a step of 0.1 s
// Of the largest change of a speed: a thousand roundings of that itself, and a hundredth of what a momentum may miss.
constexpr double momentum_rounding = 1e-13;
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

Vector3d relative_velocity(const Contact& contact, const State& found_at, const State& velocities) {
  const auto of = [&](std::size_t body) -> Vector3d {
    if (body == world_body) return Vector3d::Zero();
    const Twist& twist = velocities[body].twist;
    return twist.linear + twist.angular.cross(contact.point - found_at[body].pose.position);
  };
  return of(contact.a) - of(contact.b);
}

Vector3d slip(const Contact& contact, const State& found_at, const State& velocities) {
  const Vector3d apart = relative_velocity(contact, found_at, velocities);
  return apart - contact.normal * contact.normal.dot(apart);
}

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

Impact::Impact(Motion& motion, std::span<const Contact> contacts, const State& state, double& work,
               std::vector<LateMotor> motors)
    : motion_(motion),
      contacts_(contacts),
      work_(work),
      motors_(std::move(motors)),
      impulses_(state.size()),
      change_(state.size()) {
  rows_.assign(contacts.begin(), contacts.end());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Vector3d& n = contacts[i].normal;
    const Vector3d across = n.unitOrthogonal(), other = n.cross(across);
    add_rubbing(i, contacts[i].friction, across, other, false);
    add_rubbing(i, contacts[i].rho, across, other, true);
    add_rubbing(i, contacts[i].rhoN, n, Vector3d::Zero(), true);
  }
  for (const LateMotor& motor : motors_) {
    const Joint& joint = motion.mechanism().joints[motor.joint];
    const MotorLine line = motion.line(motor, state);
    Contact row{joint.a, joint.b, state[joint.a].pose.position + line.on_a, line.axis, 0, 0, {joint.id, nullptr}};
    row.turns = !motion.motor(motor).slides;
    rows_.push_back(row);
    rubbing_.limits.push_back({motor.least, motor.most});
  }
  const auto count = static_cast<Eigen::Index>(rows_.size());
  for (const Contact& contact : rows_) {
    for (const std::size_t body : {contact.a, contact.b}) {
      arms_.push_back(body == world_body ? Vector3d::Zero() : Vector3d(contact.point - state[body].pose.position));
    }
  }
  find_response(state.size());
  // What joints hold, an impulse moves by rounding only.
  for (Eigen::Index i = 0; i < count; ++i) {
    if (response_(i, i) > held * free_response(rows_[index(i)])) continue;
    response_.row(i).setZero();
    response_.col(i).setZero();
  }
  for (Eigen::Index i = 1; i < count; ++i) {
    if (rows_[index(i)].idle) response_(i, i) = response_(i - 1, i - 1);
  }
}

void Impact::add_rubbing(std::size_t contact, double coefficient, const Vector3d& one, const Vector3d& other,
                         bool turns) {
  if (coefficient <= 0) return;
  rubbing_.contact.push_back(static_cast<Eigen::Index>(contact));
  rubbing_.coefficient.push_back(coefficient);
  for (const Vector3d& along : {one, other}) {
    rows_.push_back(contacts_[contact]);
    rows_.back().normal = along;
    rows_.back().turns = turns;
    rows_.back().idle = along.isZero(0);
  }
}

/// How the contacts' speeds answer to an impulse at each.
void Impact::find_response(std::size_t bodies) {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  response_ = Eigen::MatrixXd::Zero(count, count);
  const auto speed = [this](Eigen::Index i) {
    const Contact& contact = rows_[index(i)];
    double sum = 0;
    if (contact.a != world_body) sum += along(contact, arms_[2 * index(i)], change_[contact.a]);
    if (contact.b != world_body) sum -= along(contact, arms_[2 * index(i) + 1], change_[contact.b]);
    return sum;
  };
  // Without joints an impulse moves its own two bodies only.
  std::vector<std::vector<Eigen::Index>> of_body(bodies);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (const std::size_t body : {rows_[index(i)].a, rows_[index(i)].b}) {
      if (body != world_body) of_body[body].push_back(i);
    }
  }
  for (Eigen::Index j = 0; j < count; ++j) {
    const Contact& contact = rows_[index(j)];
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
}

void Impact::respond(const Eigen::VectorXd& sizes) const {
  for (Wrench& impulse : impulses_) impulse = {Vector3d::Zero(), Vector3d::Zero()};
  const auto add = [this](const Contact& contact, std::size_t body, const Vector3d& arm, double size) {
    if (body == world_body) return;
    const Wrench impulse = push(contact, arm, size);
    impulses_[body].force += impulse.force;
    impulses_[body].torque += impulse.torque;
  };
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const double size = sizes[static_cast<Eigen::Index>(i)];
    if (size == 0) continue;
    add(rows_[i], rows_[i].a, arms_[2 * i], size);
    add(rows_[i], rows_[i].b, arms_[2 * i + 1], -size);
  }
  motion_.respond(impulses_, change_);
}

Eigen::VectorXd Impact::speeds(const State& state) const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(rows_.size()));
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = normal_speed(rows_[index(i)], state);
  for (std::size_t k = 0; k < motors_.size(); ++k) v[motor_row(k)] -= motion_.motor(motors_[k]).velocity;
  return v;
}

/// Of what nothing holds no impulse changes the momenta, and yet those that nearly cancel each other would by their
/// rounding: bodies that lean on each other close to the hinges that they share may push a million times as hard as
/// what struck them.
void Impact::keep_momenta(const State& state) const {
  const auto size = [](const Twist& twist) { return std::max(twist.linear.norm(), twist.angular.norm()); };
  for (const std::vector<std::size_t>& bodies : Islands(motion_.mechanism(), contacts_).afloat()) {
    State change = state;
    double fastest = 0, off = 0;
    for (const std::size_t i : bodies) {
      change[i].twist = change_[i];
      fastest = std::max(fastest, size(change_[i]));
    }
    const RigidMotion astray = shared_motion(motion_.mechanism(), change, bodies);
    for (const std::size_t i : bodies) off = std::max(off, size(astray.at(state[i].pose.position)));
    if (off <= momentum_rounding * fastest) continue;
    for (const std::size_t i : bodies) {
      const Twist by = astray.at(state[i].pose.position);
      change_[i].linear -= by.linear;
      change_[i].angular -= by.angular;
    }
  }
}

void Impact::strike_by(const Eigen::VectorXd& impulses, State& state) const {
  respond(impulses);
  keep_momenta(state);
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i].twist.linear += change_[i].linear;
    state[i].twist.angular += change_[i].angular;
  }
}

Eigen::VectorXd Impact::strike(State& state, ImpactOrder order, double rest_speed) const {
  Restitution restitution{Eigen::VectorXd(normals()), rest_speed, pushed_before()};
  std::map<std::pair<const void*, const void*>, std::size_t> numbers;
  std::vector<std::size_t> pair;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    restitution.of[static_cast<Eigen::Index>(i)] = contacts_[i].restitution;
    pair.push_back(numbers.emplace(contacts_[i].geoms, numbers.size()).first->second);
  }
  const Eigen::VectorXd v = speeds(state);
  const Eigen::MatrixXd a = response_.topLeftCorner(normals(), normals());
  Eigen::VectorXd p = Eigen::VectorXd::Zero(response_.rows());
  const auto bounces = (v.head(normals()).array() < -rest_speed && restitution.of.array() > 0).any();
  Rubbing rubbing = rubbing_;  // what bounces does so in no time, in which motors give nothing
  rubbing.limits.clear();
  if (rubbing.rows() > 0 && !bounces) {
    p = hold(v, rubbing);
  } else {
    p.head(normals()) = order == ImpactOrder::together ? strike_together(a, v.head(normals()), restitution)
                                                       : strike_in_turn(a, v.head(normals()), restitution, pair);
    if (rubbing.rows() > 0) p = rubbed(v, std::move(p), rubbing);
  }
  strike_by(p, state);
  return p;
}

/// Normal impulses, when contacts were held last.
Eigen::VectorXd Impact::pushed_before() const {
  Eigen::VectorXd p(normals());
  for (Eigen::Index i = 0; i < normals(); ++i) {
    const Contact& contact = contacts_[index(i)];
    p[i] = (contact.turns ? contact.turn : contact.push).dot(contact.normal);
  }
  return p;
}

/// Without restitution. Of the rows that `rubbing` tells of: the others give nothing.
Eigen::VectorXd Impact::hold(const Eigen::VectorXd& v, const Rubbing& rubbing) const {
  const Eigen::Index n = normals(), count = n + rubbing.rows();
  const Eigen::MatrixXd a = response_.topLeftCorner(count, count);
  Eigen::VectorXd p = Eigen::VectorXd::Zero(v.size());
  if ((v.head(count).array().abs() <= still).all()) return p;
  const auto without = [&] {
    return strike_together(a.topLeftCorner(n, n), v.head(n), {Eigen::VectorXd::Zero(n), 0, pushed_before()});
  };
  if (count == n) {
    p.head(n) = without();
    return p;
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    const Contact& row = rows_[index(i)];
    p[i] = (row.turns ? row.turn : row.push).dot(row.normal);
  }
  for (std::size_t k = 0; k < rubbing.limits.size(); ++k) p[motor_row(k)] = motors_[k].before;
  p.head(count) = engine_rk4::hold(a, v.head(count), rubbing, p.head(count), work_);
  if (!adds_energy(a, v.head(count), p.head(count))) return p;
  // Not solved: without friction, and then what friction takes of that.
  p.setZero();
  p.head(n) = without();
  return rubbed(v, p, rubbing);
}

/// Friction takes what it can of what normal impulses leave, and what it makes to close is stopped: no part of it adds
/// energy.
Eigen::VectorXd Impact::rubbed(const Eigen::VectorXd& v, Eigen::VectorXd p, const Rubbing& rubbing) const {
  const Eigen::Index n = normals(), m = rubbing.rows();
  p.segment(n, m) = rub(response_.block(n, n, m, m), v.segment(n, m) + response_.block(n, 0, m, n) * p.head(n), rubbing,
                        p.head(n), Eigen::VectorXd::Zero(m));
  double closed_before = HUGE_VAL;
  while (n > 0) {
    const Eigen::VectorXd now = v + response_ * p;
    const double closes = -now.head(n).minCoeff();
    const bool can_give_way = closes <= closed_before / 2;
    if (closes <= rounding * v.cwiseAbs().maxCoeff() || !can_give_way) break;
    closed_before = closes;
    p.head(n) += strike_together(response_.topLeftCorner(n, n), now.head(n), {Eigen::VectorXd::Zero(n)});
  }
  return p;
}

void Impact::note(const Eigen::VectorXd& impulses, std::size_t number, Contact& contact) const {
  contact.push = contact.turn = Vector3d::Zero();
  const auto add = [&](std::size_t row) {
    (rows_[row].turns ? contact.turn : contact.push) += impulses[static_cast<Eigen::Index>(row)] * rows_[row].normal;
  };
  add(number);
  for (std::size_t k = 0; k < rubbing_.contact.size(); ++k) {
    if (index(rubbing_.contact[k]) != number) continue;
    add(contacts_.size() + 2 * k);
    add(contacts_.size() + 2 * k + 1);
  }
}

Eigen::VectorXd Impact::felt() const {
  Eigen::VectorXd felt = Eigen::VectorXd::Zero(response_.rows());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Contact& row = rows_[i];
    felt[static_cast<Eigen::Index>(i)] = (row.turns ? row.felt_turn : row.felt).dot(row.normal);
  }
  return felt;
}

Eigen::VectorXd Impact::stop(State& state) const {
  const Eigen::VectorXd before = felt(), p = hold(speeds(state) - response_ * before, rubbing_);
  strike_by(p - before, state);
  return p;
}

double Impact::work_of_driven(const Eigen::VectorXd& impulses, const State& state) const {
  const std::vector<Body>& bodies = motion_.mechanism().bodies;
  double sum = 0;
  for (std::size_t i = 0; i + motors_.size() < rows_.size(); ++i) {
    const Contact& row = rows_[i];
    const auto speed = [&](std::size_t body, const Vector3d& arm) {
      if (body == world_body || bodies[body].inverse_mass > 0) return 0.0;
      return along(row, arm, state[body].twist);
    };
    sum += impulses[static_cast<Eigen::Index>(i)] * (speed(row.b, arms_[2 * i + 1]) - speed(row.a, arms_[2 * i]));
  }
  return sum;
}

double Impact::work(const Eigen::VectorXd& impulses, const State& before, const State& free, const State& after) const {
  double sum = 0;
  for (std::size_t k = 0; k < motors_.size(); ++k) {
    const Contact& row = rows_[index(motor_row(k))];
    const double speed = normal_speed(row, before, after);
    sum += impulses[motor_row(k)] * (normal_speed(row, before) + speed) / 2;
    sum += motors_[k].within * (speed - normal_speed(row, before, free)) / 2;
  }
  return sum;
}

void Impact::spend(const Eigen::VectorXd& impulses, std::vector<LateMotor>& motors) const {
  for (std::size_t k = 0; k < motors.size(); ++k) {
    const double given = impulses[motor_row(k)];
    motors[k].least = std::min(0.0, motors[k].least - given);
    motors[k].most = std::max(0.0, motors[k].most - given);
    motors[k].before = 0;
  }
}

std::vector<Contact> Impact::note_motors(const Eigen::VectorXd& impulses) const {
  std::vector<Contact> found;
  for (std::size_t k = 0; k < motors_.size(); ++k) {
    const double given = impulses[motor_row(k)];
    motion_.note(motors_[k], given);
    Contact& contact = found.emplace_back(rows_[index(motor_row(k))]);
    (contact.turns ? contact.turn : contact.push) = given * contact.normal;
  }
  return found;
}

Sticks Impact::sticks_at(const Eigen::VectorXd& impulses, const State& before, const State& state, double h) const {
  // Every contact that sticks now slides on as it came.
  Eigen::VectorXd on = Eigen::VectorXd::Zero(impulses.size());
  std::vector<std::pair<Eigen::Index, Eigen::Vector2d>> stuck;
  const auto speeds_of = [this](const State& velocities, std::size_t k) {
    const std::size_t row = contacts_.size() + 2 * k;
    return Eigen::Vector2d(normal_speed(rows_[row], velocities), normal_speed(rows_[row + 1], velocities));
  };
  const auto came_at = [&](const State& velocities, std::size_t k) {
    const std::size_t row = contacts_.size() + 2 * k;
    const Contact& contact = rows_[row];
    if (!contact.steady || contact.turns) return speeds_of(velocities, k);
    return Eigen::Vector2d(contact.normal.dot(contact.came), rows_[row + 1].normal.dot(contact.came));
  };
  for (std::size_t k = 0; k < rubbing_.contact.size(); ++k) {
    State then = state;
    for (std::size_t i = 0; i < state.size(); ++i) then[i].twist = before[i].twist;
    const Eigen::Vector2d came = came_at(then, k), left = speeds_of(state, k);
    const Eigen::Index row = normals() + static_cast<Eigen::Index>(2 * k);
    if (came.norm() <= sliding || left.norm() > came.norm() / 1000) continue;
    const double most = rubbing_.coefficient[k] * impulses[rubbing_.contact[k]];
    on.segment<2>(row) = -most * came.normalized() - impulses.segment<2>(row);
    stuck.emplace_back(row, came);
  }
  Sticks first;
  const Eigen::VectorXd change = response_ * on;
  for (const auto& [row, came] : stuck) {
    const double back = -change.segment<2>(row).dot(came.normalized());
    const double share = came.norm() / (came.norm() + back);
    if (back > 0 && share < first.share && came.norm() * share * h > sliding_way) first = {share, came.norm()};
  }
  return first;
}

std::vector<Twist> Impact::evenly(const Eigen::VectorXd& impulses, double h, std::vector<Contact>& contacts,
                                  bool all) const {
  Eigen::VectorXd p = h / 2 * impulses;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!all && contacts[i].restitution <= 0) p[static_cast<Eigen::Index>(i)] = 0;
  }
  const Eigen::VectorXd by = response_ * p;
  for (std::size_t i = 0; i < contacts.size(); ++i) contacts[i].depth -= by[static_cast<Eigen::Index>(i)];
  respond(p);
  return change_;
}

std::vector<Twist> Impact::way_out(double depth, std::span<const Twist> besides, const Eigen::VectorXd& impulses,
                                   const Eigen::VectorXd& guess) const {
  Eigen::VectorXd b(static_cast<Eigen::Index>(contacts_.size()));
  for (std::size_t i = 0; i < contacts_.size(); ++i) b[static_cast<Eigen::Index>(i)] = depth - contacts_[i].depth;
  if (besides.empty() && (b.array() >= 0).all()) return {};
  if (contacts_.empty()) return {besides.begin(), besides.end()};
  Eigen::VectorXd p = Eigen::VectorXd::Zero(response_.rows());
  p.head(normals()) = complementary(response_.topLeftCorner(normals(), normals()), b,
                                    guess.size() > 0 ? Eigen::VectorXd(guess.head(normals())) : pushed_before());
  const Eigen::VectorXd moved = response_ * p;
  std::vector<Eigen::Index> pushing;
  double highest = 0, deepest = 0;
  for (Eigen::Index i = 0; i < std::min(impulses.size(), b.size()); ++i) {
    if (impulses[i] <= 0) continue;
    pushing.push_back(i);
    highest = std::max(highest, b[i] + moved[i] - depth);
    deepest = std::max(deepest, std::fabs(b[i]));
  }
  if (highest > 0 && deepest < hovering) {
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> down;
    down.setThreshold(same_row);  // which the decomposition is made with
    down.compute(response_(pushing, pushing));
    p(pushing) = -down.solve(b(pushing).eval());
  }
  respond(p);
  // Where contacts nearly contradict each other the way out may be long; a few sweeps go a part of it.
  const auto far = [&](const Twist& change) { return change.linear.norm() > farthest * b.cwiseAbs().maxCoeff(); };
  if (std::ranges::any_of(change_, far)) {
    p.setZero();
    for (int sweep = 0; sweep < sweeps_out; ++sweep) {
      for (Eigen::Index i = 0; i < normals(); ++i) {
        if (response_(i, i) > 0) p[i] = std::max(0.0, p[i] - (b[i] + response_.row(i).dot(p)) / response_(i, i));
      }
    }
    respond(p);
  }
  for (std::size_t i = 0; i < besides.size(); ++i) {
    change_[i].linear += besides[i].linear;
    change_[i].angular += besides[i].angular;
  }
  return change_;
}

}  // namespace odeval::engine_rk4
