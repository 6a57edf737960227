// Contacts that crowd in a step: the scheme of Moreau and Jean.
#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/flight.hpp"

namespace odeval::engine_rk4 {

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
/// bodies that turn.
void Flight::bounce_elastic(Motion& motion, const Impact& impact, std::vector<Contact>& contacts, double h,
                            State& state) {
  if (std::ranges::none_of(contacts, [](const Contact& contact) { return contact.restitution == 1; })) return;
  State bare = unforced(motion, state, h);
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

/// The rest of a step in which contacts crowd, by the scheme of Moreau and Jean: free motion to its end, there one
/// impact of all contacts, by the speeds at which they closed before the forces of the step. Poses follow half of the
/// change of velocity, which is what holds what rests in its place, and leave half of what overlaps besides to the next
/// step: all of it at once would push a heap apart.
void Flight::settle_crowd(State& state, double h) {
  bool bounced = false;
  motion_.project(state);  // the matrix of this pose, for the impulses
  const auto elastic = [](const Contact& contact) { return contact.restitution == 1; };
  const State bare = std::ranges::any_of(contacts_, elastic) ? unforced(motion_, state, h) : State();
  for (Contact& contact : contacts_) {
    const auto closes = [&](const State& velocities) {
      return normal_speed(contact, state, velocities) < -options_.rest_speed;
    };
    const State& before = elastic(contact) ? bare : here_;
    const bool comes = closes(before);
    bounced = bounced || comes;
    // An elastic one that does not close may have to, once others are struck.
    if (!comes && (!elastic(contact) || closes(state))) contact.restitution = 0;
    // Forces of the step are not given back: with what follows, v+ + v > 0 would be energy from nowhere.
    if (comes && closes(state)) {
      contact.restitution *= std::min(1.0, normal_speed(contact, state, before) / normal_speed(contact, state));
    }
  }
  // Rest takes no deeper overlaps.
  if (bounced || deepest_of(contacts_) > options_.start_gap) crowd_on();
  recall(state, 0);
  const Impact impact(motion_, contacts_, state, motion_.late(h));
  const State free = state;
  Eigen::VectorXd impulses = impact.strike(state, options_.impact_order, options_.rest_speed);
  tell_joints(impact, impulses, state, h);
  double work = 0;
  const auto push_on = [&] {  // motors, against what rests then
    const Eigen::VectorXd pushes = impact.stop(state);
    tell_joints(impact, pushes, state, h);
    impulses += pushes;
    work = impact.work(pushes, here_, free, state);
  };
  if (impact.has_motors()) push_on();
  impact.note_motors(impulses);
  for (std::size_t i = 0; i < contacts_.size(); ++i) impact.note(impulses, i, contacts_[i]);
  resting_.clear();
  const std::vector<Twist> by = follow(free, state, h);
  for (Contact& contact : contacts_) {
    if (normal_speed(contact, state) <= options_.rest_speed) resting_.push_back(contact);
    contact.depth = (contact.depth - rest_depth) / 2;
  }
  const std::vector<Twist> way = impact.way_out(0, by);
  const State struck = state;
  move_out(motion_, free, way, HUGE_VAL, state);  // what that costs, the bounce pays, then what was taken before
  const double gain = gained(free, state) - work;
  if (gain > rounding_of_energy(free)) {
    state = free;
    motion_.project(state);
    work = std::min(work, impact.work(impact.stop(state), here_, free, state));
    state = slowed(state, struck, gain);
    move_out(motion_, free, way, taken_ + work, state);
  }
  taken_ -= gained(free, state) - work;
}

}  // namespace odeval::engine_rk4
