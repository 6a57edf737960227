// At the end of a step: what rests stops, and is pushed out of what it rests on.
#include <algorithm>
#include <cmath>

#include "engines/ode_rk4/flight.hpp"
#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

constexpr int most_pushes = 10;

}  // namespace

/// Of the impulses at the contacts at hand, which stood for forces over a time h, and of those of stops and motors.
void Flight::tell_joints(const Impact& impact, const Eigen::VectorXd& impulses, const State& state, double h) {
  mover().add_forces(h);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact contact = contacts_[i];
    impact.note(impulses, i, contact);
    tell_joint(contact, state, h);
  }
  for (const Contact& motor : impact.note_motors(impulses)) tell_joint(motor, state, h);
}

void Flight::tell_joint(const Contact& contact, const State& state, double h) {
  const auto on = [&](std::size_t body, double sign) {
    const Vector3d at = body == world_body ? Vector3d(Vector3d::Zero()) : state[body].pose.position;
    const Vector3d force = sign / h * contact.push;
    return Wrench{force, (contact.point - at).cross(force) + sign / h * contact.turn};
  };
  mover().add_force(contact.geoms.first, on(contact.a, 1), on(contact.b, -1));  // a stop's or a motor's joint
}

/// Of the contacts at hand, 1 at those of pairs of geoms of which `arrive` put some a little too deep: pushed out by
/// others they would part again.
Eigen::VectorXd Flight::put_too_deep(const std::vector<Contact>& rest) const {
  Eigen::VectorXd found = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(contacts_.size()));
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const auto put = [&](const Contact& contact) { return contact.missed && same_geoms(contact, contacts_[i]); };
    if (std::ranges::any_of(rest, put)) found[static_cast<Eigen::Index>(i)] = 1;
  }
  return found;
}

/// Are the contacts at hand found, as deep as what rests, and is a way less than that?
bool Flight::lies_well(std::span<const Twist> way) const {
  const auto is_well = [](const Contact& contact) { return !contact.missed && contact.depth <= 2 * rest_depth; };
  const auto stays = [](const Twist& by) { return by.linear.norm() + by.angular.norm() < rest_depth; };
  return std::ranges::all_of(contacts_, is_well) && std::ranges::all_of(way, stays);
}

bool Flight::found_again(const Contact& contact) const {
  const auto is_it = [&](const Contact& other) { return !other.missed && same_geoms(contact, other); };
  return std::ranges::any_of(contacts_, is_it);
}

/// Of what rests, what has to push and was not found a little too deep is put as far as anything was off, once: how far
/// it is away is known to the order of the step. Else it is gone.
void Flight::look_deeper(std::vector<Contact>& rest) {
  const auto pushes = [](const Contact& contact) {
    return (contact.turns ? contact.turn : contact.push).dot(contact.normal) > 0;
  };
  double farthest = 0;
  for (const Contact& contact : rest) farthest = std::max(farthest, pushes(contact) ? std::fabs(contact.depth) : 0);
  std::vector<Contact> again;
  std::erase_if(rest, [&](Contact& contact) {
    if (!contact.missed || found_again(contact)) return false;
    if (pushes(contact)) again.push_back(contact);
    return !pushes(contact);
  });
  for (Contact& contact : again) contact.depth = -farthest;
  contacts_.insert(contacts_.end(), again.begin(), again.end());
}

/// The contacts at hand, which rest, after a time h; `again`: after they moved by that once. Writes what they did to
/// `rest`, and what motors can give yet.
Flight::Out Flight::stop_and_push_out(State& state, double h, bool again, std::vector<LateMotor>& motors,
                                      std::vector<Contact>& rest) {
  Motion& motion = mover();
  const bool first = !again && h > 0;
  if (first) recall(state, h);
  const bool pushed = !forces_->pushes.empty();
  const bool follows = first && (pushed || !motors.empty() || std::ranges::any_of(contacts_, &Contact::rubs));
  const Impact impact(motion, contacts_, state, work_, motors);
  const State free = state;
  bounce_elastic(motion, impact, contacts_, h, state);
  const State falling = state;
  const Eigen::VectorXd impulses = impact.stop(state);
  for (std::size_t i = 0; i < state.size(); ++i) {
    halted_[i].linear += state[i].twist.linear - falling[i].twist.linear;
    halted_[i].angular += state[i].twist.angular - falling[i].twist.angular;
  }
  const double work =
      impact.work(impulses, here_, free, state) + impact.work_of_driven(impulses - impact.felt(), state);
  if (first) tell_joints(impact, impulses, state, h);
  impact.spend(impulses, motors);  // what is found on the way out is borne by what they can give yet
  const double done = !first ? 0 : passive() ? gained(here_, free) : work_of_pushes(free, h);
  if (first) {
    note(impact, impulses, h);
    rest = contacts_;
  }
  std::vector<Twist> by;
  if (follows) {
    sticks_ = impact.sticks_at(impulses, here_, state, h);
    by = follow(free, state, h);
  }
  const Eigen::VectorXd guess = again && !follows ? put_too_deep(rest) : Eigen::VectorXd();
  const auto way = impact.way_out(rest_depth, by, follows ? impulses : guess);
  // What only that would cost energy is paid at the end of the step: else it would be gone in many small parts.
  const double most = passive() && !first_ ? HUGE_VAL : taken_ + work - done;
  const bool moved = move_out(motion, free, way, most, state);
  taken_ -= gained(free, state) + done - work;
  return {moved, !again && moved && lies_well(way)};
}

/// At the end of a step, with its contacts at hand: what rests stops and is pushed out of what it rests on. Returns
/// true if something touches that does not rest.
bool Flight::hold(State& state, double h) {
  Motion& motion = mover();
  std::vector<LateMotor> motors = motion.late(h);
  std::vector<Contact> fast = contacts_;
  std::erase_if(fast, [this](const Contact& contact) { return !held_fast(contact); });
  bool touched = false;
  sticks_ = {};
  halted_.assign(state.size(), {Vector3d::Zero(), Vector3d::Zero()});
  const auto at_rest = [&] {
    touched = deepest(state) != nullptr;
    std::erase_if(contacts_, [&](const Contact& contact) { return !rests(contact, state) || held_fast(contact); });
  };
  at_rest();
  // The matrix of this pose, for the impulses.
  if (!contacts_.empty() || !motors.empty()) motion.stand(state);
  std::vector<Contact> rest = contacts_;
  const auto is_gone = [this](const Contact& contact) { return contact.missed && !found_again(contact); };
  for (int push = 0; push < most_pushes && (!contacts_.empty() || !motors.empty()); ++push) {
    if (push > 0 && std::ranges::none_of(contacts_, &Contact::missed) && deepest_of(contacts_) <= 2 * rest_depth) break;
    const auto [moved, well] = stop_and_push_out(state, h, push > 0, motors, rest);
    if (well) break;  // nothing comes deeper by that than what rests, nor out of reach
    if (moved) {
      look(state);
      at_rest();
    }
    if (!moved || push > 0) std::erase_if(rest, is_gone);
    if (!moved) break;  // between jaws of joints, or at the end of what can be lifted
    if (push == 0 && h > 0) look_deeper(rest);
  }
  halted_.clear();
  leave_what_is_deep();
  rest.insert(rest.end(), fast.begin(), fast.end());
  resting_ = std::move(rest);
  return touched;
}

/// Overlaps that could not be pushed out: at the start of a run they are refused; what comes so near later, between
/// jaws of joints, is left to the crowd's scheme.
void Flight::leave_what_is_deep() {
  const double overlap = deepest_of(contacts_);
  if (overlap <= options_.start_gap) return;
  if (first_) look(here_);
  if (first_ && deepest_of(contacts_) > options_.start_gap) {
    refuse("an overlap of " + shown(overlap) + " m can not be pushed out; at most " + shown(options_.start_gap) +
           " are left to later steps");
  }
  crowd_on();
}

}  // namespace odeval::engine_rk4
