// Contacts that crowd in a step: the scheme of Moreau and Jean.
#include <algorithm>
#include <cmath>
#include <span>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/flight.hpp"

namespace odeval::engine_rk4 {
namespace {

// Times that a crowd's step is solved anew, with what it comes to touch.
constexpr int most_looks = 5;
// m: what is no deeper is where rest is.
constexpr double deep_enough = 1.01 * rest_depth;
constexpr double same_point = 1e-6;  // m, and what bodies move: points of one pair of geoms nearer than this

/// By how much a way takes a contact's bodies apart.
double opening(const Contact& contact, const State& at, const std::vector<Twist>& way) {
  if (way.empty()) return 0;
  const auto of = [&](std::size_t body) {
    if (body == world_body) return 0.0;
    if (contact.turns) return contact.normal.dot(way[body].angular);
    return contact.normal.dot(way[body].linear + way[body].angular.cross(contact.point - at[body].pose.position));
  };
  return of(contact.a) - of(contact.b);
}

Vector3d moved(std::size_t body, const State& from, const State& to) {
  return body == world_body ? Vector3d(Vector3d::Zero()) : to[body].pose.position - from[body].pose.position;
}

}  // namespace

/// What impulses at the end of a time h would have moved poses by if they had acted evenly all the while: half of the
/// change of velocity times h. The contacts at hand get that much shallower.
std::vector<Twist> Flight::follow(const State& free, const State& held, double h) {
  std::vector<Twist> by(free.size());
  for (std::size_t i = 0; i < by.size(); ++i) {
    by[i].linear = h / 2 * (held[i].twist.linear - free[i].twist.linear);
    by[i].angular = h / 2 * (held[i].twist.angular - free[i].twist.angular);
  }
  for (Contact& contact : contacts_) {
    contact.depth -= h / 2 * (normal_speed(contact, held) - normal_speed(contact, free));
  }
  return by;
}

/// Velocities less what forces have changed of them in a time h, to the first order, at the pose of the last
/// projection.
State Flight::unforced(Motion& motion, const State& state, double h) {
  std::vector<Wrench> impulses = forces_->all(forces_->since + h, state);
  for (Wrench& impulse : impulses) impulse = {h * impulse.force, h * impulse.torque};
  std::vector<Twist> change;
  motion.respond(impulses, change);
  State bare = state;
  for (std::size_t i = 0; i < bare.size(); ++i) {
    bare[i].twist.linear -= change[i].linear;
    bare[i].twist.angular -= change[i].angular;
  }
  return bare;
}

/// Contacts that rest give nothing back, but elastic ones the energy of what closes them besides forces in a time h:
/// bodies that turn. What has been `halted_` of the state is no motion that closes them, but what forces did.
void Flight::bounce_elastic(Motion& motion, const Impact& impact, std::vector<Contact>& contacts, double h,
                            State& state) {
  if (std::ranges::none_of(contacts, [](const Contact& contact) { return contact.restitution == 1; })) return;
  State bare = unforced(motion, state, h);
  for (std::size_t i = 0; i < halted_.size(); ++i) {
    bare[i].twist.linear -= halted_[i].linear;
    bare[i].twist.angular -= halted_[i].angular;
  }
  bool bounces = false;
  for (Contact& contact : contacts) {
    if (contact.restitution < 1 || stopped(contact)) contact.restitution = 0;
    bounces = bounces || (contact.restitution == 1 && normal_speed(contact, bare) < -options_.rest_speed);
  }
  if (!bounces) return;
  const State before = bare;
  impact.strike(bare, options_.impact_order, options_.rest_speed);
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i].twist.linear += bare[i].twist.linear - before[i].twist.linear;
    state[i].twist.angular += bare[i].twist.angular - before[i].twist.angular;
  }
}

/// What bounces in a crowd, and how: by the speeds at which contacts closed before the forces of the step. Returns true
/// if one does.
bool Flight::judge_bounces(const State& state, const State& bare, std::vector<Contact>& contacts) const {
  bool bounced = false;
  for (Contact& contact : contacts) {
    const bool elastic = contact.restitution == 1;
    const auto closes = [&](const State& velocities) {
      return normal_speed(contact, state, velocities) < -options_.rest_speed;
    };
    const State& before = elastic ? bare : here_;
    const bool comes = closes(before);
    bounced = bounced || comes;
    // An elastic one that does not close may have to, once others are struck.
    if (!comes && (!elastic || closes(state))) contact.restitution = 0;
    // Forces of the step are not given back: with what follows, v+ + v > 0 would be energy from nowhere.
    if (comes && closes(state)) {
      contact.restitution *= std::min(1.0, normal_speed(contact, state, before) / normal_speed(contact, state));
    }
  }
  return bounced;
}

/// What rested, stands still, and is not found since it is a little apart, stays a contact: else what it bears would
/// fall in this step, and be lifted again in another.
void Flight::add_still(const State& free) {
  const double still = options_.rest_speed * step_;
  const auto found = std::ssize(contacts_);
  for (Contact contact : resting_) {
    const Vector3d a = moved(contact.a, here_, free), b = moved(contact.b, here_, free);
    const double drift = step_ * std::max(contact.drifts[0].norm(), contact.drifts[1].norm());
    contact.depth -= contact.normal.dot(a - b);
    if (contact.turns || (a - b).norm() > still || drift > still || std::fabs(contact.depth) > still) continue;
    const auto is_it = [&](const Contact& other) { return same_geoms(contact, other); };
    if (std::any_of(contacts_.begin(), contacts_.begin() + found, is_it)) continue;
    contact.point += contact.a == world_body ? b : a;
    contacts_.push_back(contact);
  }
}

/// Compares the contacts at hand with what overlaps at the end of a way from where they are: adds what is not among
/// them, and deepens what is deeper there than it should be. `depths`: of the contacts at hand, there. Returns true if
/// there is anything of that.
bool Flight::missed_on_way(const State& free, const State& end, std::vector<double>& depths) {
  std::vector<Contact> there = std::move(contacts_);
  look(end);
  std::swap(there, contacts_);
  const std::size_t known = contacts_.size();
  std::vector<char> met(known, 0);
  bool missed = false;
  for (Contact& found : there) {
    const Vector3d a = moved(found.a, free, end), b = moved(found.b, free, end);
    double nearest = 2 * std::max(a.norm(), b.norm()) + same_point;
    std::size_t same = known;
    for (std::size_t i = 0; i < known; ++i) {
      const double away = (found.point - contacts_[i].point).norm();
      if (met[i] != 0 || !same_geoms(found, contacts_[i]) || away >= nearest) continue;
      nearest = away;
      same = i;
    }
    const bool deep = found.depth > deep_enough;
    missed = missed || deep;
    if (same < known) {
      met[same] = 1;
      if (deep) contacts_[same].depth += found.depth - depths[same];
      depths[same] = found.depth;
    } else if (deep) {
      depths.push_back(found.depth);
      if (!found.turns) found.depth += found.normal.dot(a - b);
      found.point -= found.a == world_body ? b : a;
      contacts_.push_back(found);
    }
  }
  return missed;
}

/// Where bodies are too `poor` to pay for that, their poses follow half of all the change of velocity, which costs next
/// to nothing, and leave half of what overlaps besides to the next step: all of it at once would push a heap apart.
/// What that costs, the bounce pays, then what was taken before. The others are as they were. Returns the work of
/// motors.
double Flight::follow_crowd(const Impact& impact, const Eigen::VectorXd& impulses, std::vector<Contact>& contacts,
                            const std::vector<char>& poor, const State& free, State struck, double h, double work,
                            State& state) {
  const auto others_stay = [&](State& of) {
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (poor[i] == 0) of[i] = free[i];
    }
  };
  contacts = contacts_;
  const std::vector<Twist> by = impact.evenly(impulses, h, contacts, true);
  for (Contact& contact : contacts) contact.depth = (contact.depth - rest_depth) / 2;
  std::vector<Twist> way = impact.way_out(0, by, {}, impulses);
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (poor[i] == 0) way[i] = {Vector3d::Zero(), Vector3d::Zero()};
  }
  others_stay(struck);
  state = struck;
  move_out(motion_, free, way, HUGE_VAL, state);
  const double gain = gained(free, state) - work;
  if (gain <= rounding_of_energy(free)) return work;
  state = free;
  motion_.project(state);
  work = std::min(work, impact.work(impact.stop(state), here_, free, state));
  others_stay(state);
  state = slowed(state, struck, gain);
  move_out(motion_, free, way, taken_ + work, state);
  return work;
}

/// The rest of a step in which contacts crowd, by the scheme of Moreau and Jean: free motion to its end, there one
/// impact of all contacts, by the speeds at which they closed before the forces of the step. Poses are the nearest,
/// weighted by mass, that do not overlap; where friction acts, or what bounces, they first follow half of the change of
/// velocity that makes. What is touched on the way there takes part in it.
void Flight::settle_crowd(State& state, double h) {
  const auto elastic = [](const Contact& contact) { return contact.restitution == 1; };
  const State free = state;
  State bare;
  bool bounced = false;
  work_ = friction_work;
  const bool deep = deepest_of(contacts_) > options_.start_gap;  // rest takes no deeper overlaps
  std::vector<double> depths;
  add_still(free);
  recall(free, h);
  for (int looks = 0;; ++looks) {
    state = free;
    motion_.project(state);  // the matrix of this pose, for the impulses
    if (bare.empty() && std::ranges::any_of(contacts_, elastic)) bare = unforced(motion_, state, h);
    std::vector<Contact> contacts = contacts_;
    bounced = judge_bounces(state, bare, contacts);
    const Impact impact(motion_, contacts, state, work_, motion_.late(h));
    Eigen::VectorXd impulses = impact.strike(state, options_.impact_order, options_.rest_speed);
    double work = 0;
    if (impact.has_motors()) {  // against what rests then
      const Eigen::VectorXd pushes = impact.stop(state);
      impulses += pushes;
      work = impact.work(pushes, here_, free, state);
    }
    note(impact, impulses, h);
    const std::vector<Twist> way = impact.way_out(rest_depth, impact.evenly(impulses, h, contacts), {}, impulses);
    const State struck = state;
    move_out(motion_, free, way, HUGE_VAL, state);
    depths.clear();
    for (const Contact& contact : contacts_) depths.push_back(contact.depth - opening(contact, free, way));
    const auto solved = std::ssize(contacts_);
    if (missed_on_way(free, state, depths) && looks < most_looks) continue;
    contacts_.erase(contacts_.begin() + solved, contacts_.end());  // left to the next step
    State there = free;
    motion_.project(there);
    impact.answer(impulses);
    tell_joints(impact, impulses, there, h);
    resting_ = contacts_;
    const State& before = passive() ? here_ : free;
    const std::vector<char> poor = pay(before, work, state);
    if (std::ranges::find(poor, 1) != poor.end()) {
      State other;
      work = follow_crowd(impact, impulses, contacts, poor, free, struck, h, work, other);
      for (std::size_t i = 0; i < poor.size(); ++i) {
        if (poor[i] != 0) state[i] = other[i];
      }
    }
    taken_ -= gained(before, state) - work;
    break;
  }
  if (bounced || deep) crowd_on();
  resting_.clear();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    contacts_[i].depth = depths[i];
    if (normal_speed(contacts_[i], free, state) <= options_.rest_speed) resting_.push_back(contacts_[i]);
  }
}

}  // namespace odeval::engine_rk4
