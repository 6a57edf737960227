#include "engines/ode_rk4/flight.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

// Bodies and contacts of the impacts located in one step: more are a crowd. To locate one costs ten steps or so of all
// bodies, so a ball between walls may have 24 impacts in a step, and a figure of eleven bodies four.
constexpr std::size_t crowd = 48;
constexpr int most_bisections = 100;
constexpr int most_changes = 20;           // of motors in one step; after that they go on as they are
constexpr double time_rounding = 1e-15;    // of what is left of the step
constexpr double beyond_rounding = 1e-14;  // of a motor's limit or velocity
constexpr double almost = 0.95;
constexpr int most_splits = 4;       // of a step where something comes to stick
constexpr double moment = 1e-4;      // of a step, at which what sticks comes to slip
constexpr double same_turn = 1e-12;  // of a quaternion: ODE makes it a unit one, to rounding
constexpr int most_finds = 3;        // of footholds in a step: what comes to rest more often stands nowhere

}  // namespace

void Flight::advance(State& state, Forces& forces, double h, bool fresh) {
  const Memory before = memory();
  const int crowded = crowded_;
  touches_.clear();
  stopped_.clear();
  struck_.clear();
  bounced_.clear();
  all_stopped_ = slipped_ = renewed_ = false;
  finds_ = 0;
  work_ = friction_work;
  first_ = fresh;
  step_ = h;
  if (footholds_) footholds_->motion().prepare(h);
  forces_ = &forces;
  here_ = state;
  in_touch_.assign(state.size(), 0);
  count_in(resting_);
  halted_.clear();
  try {
    if (fresh) begin();
    if (collider_.works(motion_.mechanism())) {
      collider_.survey_ground(ground_);
      if (!fresh && (ground_ != ground_then_ || put_elsewhere(here_))) {
        footholds_.reset();
        allow_lift();
      }
    }
    const double lift = taken_;
    fly(h);
    const bool keeps = collider_.works(motion_.mechanism()) && passive();
    if (keeps && !keep_energy(state, before.resting, lift) && !fresh && crowded == 0) {
      // What rested pushed bodies up that have not the motion to pay for that: they fall freely instead.
      fall_freely(state, before, h);
      keep_energy(state, before.resting, lift);
    }
    if (collider_.works(motion_.mechanism()) && !finite(there_))
      refuse("the motion left the finite numbers; take a smaller step");
  } catch (...) {
    go_back(before);
    crowded_ = crowded;
    touches_.clear();
    throw;
  }
  if (crowded_ > 0) ++crowded_steps_;
  if (crowded_ > 0 && !renewed_) --crowded_;
  quiet_ = touches_.empty() && crowded_ == 0 ? std::min(quiet_ + 1, calm_steps) : 0;
  std::swap(state, there_);
  if (collider_.works(motion_.mechanism())) {
    left_ = state;
    std::swap(ground_then_, ground_);
  }
}

/// The step anew, as a crowd's. Impacts that were told stay told.
void Flight::fall_freely(const State& start, const Memory& before, double h) {
  go_back(before);
  stopped_.clear();
  struck_.clear();
  bounced_.clear();
  all_stopped_ = false;
  here_ = start;
  crowd_on();
  fly(h);
}

/// Joints are closed, and what overlaps may be lifted out of it.
void Flight::begin() {
  settle(here_, options_.start_gap);
  if (collider_.works(motion_.mechanism())) allow_lift();
}

/// Has the program put a body elsewhere since the last step?
bool Flight::put_elsewhere(const State& state) const {
  for (std::size_t i = 0; i < left_.size(); ++i) {
    const Pose &now = state[i].pose, &then = left_[i].pose;
    if (now.position != then.position || (now.turn - then.turn).norm() > same_turn) return true;
  }
  return false;
}

/// Of what overlaps, no farther than by all overlaps together.
void Flight::allow_lift() {
  look(here_);
  double overlaps = 0, forces = 0;
  for (const Contact& contact : contacts_) overlaps += std::max(0.0, contact.depth - rest_depth);
  for (std::size_t i = 0; i < here_.size(); ++i) forces += in_touch_[i] != 0 ? forces_->now[i].force.norm() : 0;
  taken_ = std::max(taken_, forces * overlaps);
}

/// From `here_` to the end of the step, in `there_`: touch by touch, and slip by slip.
void Flight::fly(double h) {
  std::size_t struck = 0;
  Slowing slowing;
  double t = 0;
  bool just_struck = false;
  for (int impacts = 1;; ++impacts) {
    find_footholds(t, just_struck);
    just_struck = false;
    push_on(t);
    move(t, h - t, there_);
    if (!collider_.works(motion_.mechanism())) return;
    arrive(there_, h - t);
    if (crowded_ > 0 && !contacts_.empty()) return settle_crowd(there_, h - t);
    double passed = h - t;
    const bool touching = deepest(there_) != nullptr;
    if (touching) {
      if (!touches_once_held(h - t)) return;
      struck += struck_at_once();
      const bool first_in_a_while = touches_.empty() && quiet_ >= calm_steps;
      if ((struck > crowd && !first_in_a_while) || work_ <= 0) {
        crowd_on();
        continue;
      }
      passed = locate(t, h - t);
    }
    const bool slipped = slips(t, passed);
    if (!touching && !slipped) {
      if (hold_or_stick(t, h, slowing)) return;
      continue;
    }
    remember(there_, passed);
    t += passed;
    if (slipped) {
      go_on();
      continue;
    }
    impact(t, passed <= 0, impacts >= options_.most_impacts);
    just_struck = true;
    if (t < h) continue;
    there_ = here_;
    hold(there_, 0);
    return;
  }
}

/// What rests has been let go for what is left of the step, and what it carries with it: is there still a touch once it
/// is held? Else it is.
bool Flight::touches_once_held(double left) {
  if (resting_.empty()) return true;
  const State let_go = there_;
  const Memory before = memory();
  if (!hold(there_, left)) return false;
  there_ = let_go;
  go_back(before);
  arrive(there_, left);
  return true;
}

/// Holds what rests at the end of the step. What slid and sticks is taken to the moment at which it does: first almost,
/// then by how much that slowed it. Returns false if it was, and the step goes on from there.
bool Flight::hold_or_stick(double& t, double h, Slowing& slowing) {
  const Memory before = memory();
  hold(there_, h - t);
  if (!(sticks_.share < 1 && work_ > 0 && slowing.splits++ < most_splits)) return true;
  double part = almost * sticks_.share * (h - t);
  if (slowing.splits % 2 == 0 && sticks_.slip < slowing.slip) {
    part = std::min(h - t, sticks_.slip / (slowing.slip - sticks_.slip) * slowing.last_part);
  }
  slowing.slip = sticks_.slip;
  slowing.last_part = part;
  go_back(before);
  move(t, part, there_);
  arrive(there_, part);
  hold(there_, part);
  t += part;
  std::swap(here_, there_);
  return false;
}

/// From `there_`.
void Flight::go_on() {
  if (passive()) taken_ -= gained(here_, there_);
  std::swap(here_, there_);
}

/// Holds what rests at `here_` and can stick there.
void Flight::find_footholds(double after, bool struck) {
  if (slipped_ || crowded_ > 0) footholds_.reset();
  if (footholds_ && (!footholds_->fit(here_) || disturbed())) footholds_.reset();
  const bool found = !footholds_;
  if (found) {
    const auto can_hold = [this](const Contact& contact) { return Footholds::can_hold(motion_.mechanism(), contact); };
    if (slipped_ || crowded_ > 0 || std::ranges::none_of(resting_, can_hold)) return;
    look(here_);
    if (struck) add_to_contacts(struck_);
    footholds_ = Footholds::of(motion_.mechanism(), options_, contacts_, here_, struck);
    if (!footholds_ || ++finds_ > most_finds) return footholds_.reset();
    footholds_->motion().prepare(step_);
  } else {
    contacts_ = resting_;
  }
  State held = here_;
  if (found) mover().project(held);  // what leaves slowly rests from now on, not by and by
  // Joints that nearly say what these do stay open by what that asks of both.
  const bool closed = !found || mover().project(held).before.size <= mendable;
  // What closes their gaps is paid for as ways out are.
  const double gain = found ? gained(here_, held) : 0;
  const bool paid = gain <= std::max(0.0, taken_) + rounding_of_energy(here_);
  if (mover().has_motors()) drive(held, after);
  if (!closed || !paid || !footholds_->bear(held, *forces_, after, contacts_)) {
    footholds_.reset();
  } else if (found) {
    const auto leaves = [&](const Contact& contact) { return normal_speed(contact, here_) > options_.rest_speed; };
    resting_ = contacts_;
    std::erase_if(resting_, leaves);
    taken_ -= gain;
    here_ = held;
  }
}

/// Does what came to rest since, and is not held, act on what is?
bool Flight::disturbed() const {
  const std::vector<char> pushed = pushed_late();
  return std::ranges::any_of(resting_, [&](const Contact& contact) {
    const auto is = [&](std::size_t body) { return body != world_body && pushed[body] != 0; };
    return held_fast(contact) && (is(contact.a) || is(contact.b));
  });
}

/// Did what is held slip, or lift off, on the way from `here_` to `there_`, with the contacts there at hand? Then
/// `there_` becomes the last state at which it did not, after less time, and it is held no more in this step.
bool Flight::slips(double after, double& passed) {
  if (!footholds_ || footholds_->bear(there_, *forces_, after + passed, contacts_)) return false;
  double high = passed;
  passed = 0;
  // What is wanting at first grows with the time, so that an error of the moment comes in by its square.
  while (high - passed > moment * step_) {
    const double middle = (passed + high) / 2;
    move(after, middle, trial_);
    look(trial_);
    (footholds_->bear(trial_, *forces_, after + middle, contacts_) ? passed : high) = middle;
  }
  move(after, passed, there_);
  footholds_.reset();
  slipped_ = true;
  return true;
}

/// From `here_`, which is `after` seconds into the step.
void Flight::move(double after, double h, State& to) {
  if (motion_.has_motors()) {
    move_by_motors(after, h, to);
  } else {
    go(here_, after, h, to);
  }
}

/// As far as motors do what they do, then on from where one reaches or leaves its limit of force.
void Flight::move_by_motors(double after, double h, State& to) {
  Motion& motion = mover();
  State from = here_;
  std::vector<std::size_t> broken;
  std::vector<double> shares;
  const double end = after + h;
  for (int change = 0;; ++change) {
    const double longest = end - after;
    drive(from, after, broken);
    go(from, after, longest, to);
    if (motion.can_wait()) return;
    motion.beyond(to, *forces_, end, shares);
    const auto most = [&] { return *std::ranges::max_element(shares); };
    if (most() <= 0 || change == most_changes) return;
    // The first moment at which one is beyond: regula falsi after Illinois.
    double low = 0, high = longest, at_low = -1, at_high = most();
    for (int round = 0; round < most_bisections && high - low > time_rounding * longest; ++round) {
      double guess =
          round % 3 == 2 || at_low == -1 ? (low + high) / 2 : low + (high - low) * at_low / (at_low - at_high);
      if (!(guess > low && guess < high)) break;
      go(from, after, guess, to);
      motion.beyond(to, *forces_, after + guess, shares);
      const bool found = std::fabs(most()) < beyond_rounding;
      (found || most() > 0 ? high : low) = guess;
      (found || most() > 0 ? at_high : at_low) = most();
      if (found) break;
    }
    if (most() <= -beyond_rounding) {
      go(from, after, high, to);
      motion.beyond(to, *forces_, after + high, shares);
    }
    broken.clear();
    for (std::size_t m = 0; m < shares.size(); ++m) {
      if (shares[m] <= -beyond_rounding || !motion.holds(m)) continue;
      motion.let_slip(m);
      broken.push_back(m);
    }
    after += high;
    from = to;
  }
}

void Flight::drive(const State& from, double after, std::span<const std::size_t> broken) {
  mover().put_off(pushed_late());
  mover().drive(from, *forces_, after, broken);
}

/// Bodies that what rests acts on at the end of a step, directly or through joints and others that rest.
std::vector<char> Flight::pushed_late() const {
  std::vector<char> pushed(here_.size(), 0);
  for (const Contact& contact : resting_) {
    if (held_fast(contact)) continue;
    for (const std::size_t body : {contact.a, contact.b}) {
      if (body != world_body && motion_.mechanism().bodies[body].inverse_mass > 0) pushed[body] = 1;
    }
  }
  return reached(std::move(pushed));
}

void Flight::go(State& from, double after, double h, State& to) {
  Motion& motion = mover();
  forces_->start = after;
  JointErrors errors = motion.step(from, *forces_, h, to, motion.has_motors());
  if (errors.before.size > mendable) {
    settle(from, options_.start_gap);
    if (motion.has_motors()) drive(from, after);
    errors = motion.step(from, *forces_, h, to, motion.has_motors());
  }
  if (!finite(to)) refuse("the motion left the finite numbers; take a smaller step");
  // Equations that repeat others are left out: a closed loop that does not quite close keeps its gap.
  if (!(errors.after.size <= (motion.redundant() ? options_.start_gap : mendable))) {
    refuse_apart(errors.after, "at the end of a step of " + shown(h) + " s; take a smaller one");
  }
}

void Flight::settle(State& state, double most) {
  const JointErrors errors = mover().project(state);
  for (const JointError& error : {errors.before, errors.after}) {
    if (error.size <= most) continue;
    refuse_apart(error, "at the start of the step; at most " + shown(most) + " are mended");
  }
}

void Flight::refuse_apart(const JointError& error, const std::string& when) const {
  const Joint& joint = mover().mechanism().joints[error.joint];
  refuse(name(joint) + " is " + shown(error.size) + " m or rad apart " + when, motion_.mechanism().bodies[joint.a].id,
         joint.id);
}

}  // namespace odeval::engine_rk4
