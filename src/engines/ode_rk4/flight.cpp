#include "engines/ode_rk4/flight.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

// An impact is located to this overlap, m: a thousand roundings of positions of a metre, and passed in 1e-12 s at 1
// m/s.
constexpr double touch_depth = 1e-12;
// Geoms this near, m, that an impact closes touched when it happened: rows and corners that touch do so to rounding.
constexpr double touching_distance = 1e-9;
// m: points of one pair of geoms nearer than this are one contact.
constexpr double same_point = 1e-6;
// Bodies and contacts of the impacts located in one step: more are a crowd. To locate one costs ten steps or so of all
// bodies, so a ball between walls may have 24 impacts in a step, and a figure of eleven bodies four.
constexpr std::size_t crowd = 48;
constexpr int most_bisections = 100;
constexpr int most_changes = 20;           // of motors in one step; after that they go on as they are
constexpr double time_rounding = 1e-15;    // of what is left of the step
constexpr double beyond_rounding = 1e-14;  // of a motor's limit or velocity
constexpr double near_newton = 0.02;       // of the bracket: Newton's method misses by the square of what it moved
constexpr int most_pushes = 10;
constexpr double almost = 0.95;
constexpr int most_splits = 4;   // of a step where something comes to stick
constexpr double moment = 1e-4;  // of a step, at which what sticks comes to slip
constexpr int most_finds = 3;    // of footholds in a step: what comes to rest more often stands nowhere

bool among(const std::vector<Contact>& contacts, const Contact& contact) {
  return std::ranges::any_of(contacts, [&](const Contact& other) { return same_geoms(contact, other); });
}
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
  try {
    if (fresh) begin();
    const double lift = taken_;
    fly(h);
    const bool keeps = collider_.works(motion_.mechanism()) && conservative();
    if (keeps && !keep_energy(state, before.resting, lift) && !fresh && crowded == 0 && touches_.empty()) {
      // What rested pushed bodies up that have not the motion to pay for that: they fall freely instead.
      go_back(before);
      here_ = state;
      crowd_on();
      fly(h);
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
}

/// Joints are closed, and what overlaps may be lifted out of it: no farther than by all overlaps together.
void Flight::begin() {
  settle(here_, options_.start_gap);
  if (!collider_.works(motion_.mechanism())) return;
  look(here_);
  double overlaps = 0, forces = 0;
  for (const Contact& contact : contacts_) overlaps += std::max(0.0, contact.depth - rest_depth);
  for (const Wrench& wrench : forces_->now) forces += wrench.force.norm();
  taken_ = forces * overlaps;
}

/// From `here_` to the end of the step, in `there_`: touch by touch, and slip by slip.
void Flight::fly(double h) {
  std::size_t struck = 0;
  int splits = 0;
  double slip = 0, last_part = 0;
  double t = 0;
  bool just_struck = false;
  for (int impacts = 1;; ++impacts) {
    find_footholds(t, just_struck);
    just_struck = false;
    push_on(t);
    move(t, h - t, there_);
    if (!collider_.works(motion_.mechanism())) break;
    arrive(there_, h - t);
    if (crowded_ > 0 && !contacts_.empty()) {
      settle_crowd(there_, h - t);
      break;
    }
    if (deepest(there_) == nullptr) {
      double passed = h - t;
      if (slips(t, passed)) {
        remember(there_, passed);
        t += passed;
        go_on();
        continue;
      }
      const Memory before = memory();
      hold(there_, h - t);
      // What slid and sticks is taken to the moment at which it does: first almost, then by how much that slowed it.
      if (sticks_.share < 1 && work_ > 0 && splits++ < most_splits) {
        double part = almost * sticks_.share * (h - t);
        if (splits % 2 == 0 && sticks_.slip < slip) {
          part = std::min(h - t, sticks_.slip / (slip - sticks_.slip) * last_part);
        }
        slip = sticks_.slip;
        last_part = part;
        go_back(before);
        move(t, part, there_);
        arrive(there_, part);
        hold(there_, part);
        t += part;
        std::swap(here_, there_);
        continue;
      }
      break;
    }
    // What rests has been let go for the step, and what it carries with it: is there still a touch once it is held?
    if (!resting_.empty()) {
      const State let_go = there_;
      const Memory before = memory();
      const bool touched = hold(there_, h - t);
      if (!touched) break;
      there_ = let_go;
      go_back(before);
      arrive(there_, h - t);
    }
    struck += struck_at_once();
    const bool first_in_a_while = touches_.empty() && quiet_ >= calm_steps;
    if ((struck > crowd && !first_in_a_while) || work_ <= 0) {
      crowd_on();
      continue;
    }
    double passed = locate(t, h - t);
    const bool slipped = slips(t, passed);
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
    break;
  }
}

/// From `there_`.
void Flight::go_on() {
  if (conservative()) taken_ -= gained(here_, there_);
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

/// Geoms that do not bounce any more in this step.
bool Flight::stopped(const Contact& contact) const { return all_stopped_ || among(stopped_, contact); }

const Contact* Flight::nearest_resting(const Contact& contact) const {
  const Contact* nearest = nullptr;
  for (const Contact& other : resting_) {
    if (!same_geoms(contact, other)) continue;
    if (contact.is_stop && contact.normal.dot(other.normal) < 0) continue;  // the other end of its way
    if (nearest == nullptr || (other.point - contact.point).norm() < (nearest->point - contact.point).norm()) {
      nearest = &other;
    }
  }
  return nearest;
}

/// A contact of geoms that rested when this part of the step began, and did not approach at this point then, along the
/// normal of that time: what approaches at its end is what the forces did.
bool Flight::rests(const Contact& contact, const State& at) const {
  if (stopped(contact)) return true;
  if (held_fast(contact) && !contact.is_stop) return footholds_->stand_on(contact, at);
  if (contact.followed) return true;
  const Contact* const nearest = nearest_resting(contact);
  if (nearest == nullptr) return false;
  Contact then = contact;
  then.normal = nearest->a == contact.a ? nearest->normal : Vector3d(-nearest->normal);
  if (normal_speed(then, at, here_) >= -options_.rest_speed) return true;
  // What is round touches with another point of its body since: where it did then it did not approach.
  return nearest->placed && is_round(contact) && normal_speed(at_start(*nearest), here_) >= -options_.rest_speed;
}

/// The deepest contact that is not at rest, if any. What lies side by side overlaps by rounding, and what was struck at
/// `here_` still does as it leaves: both have to close.
const Contact* Flight::deepest(const State& at) const {
  const Contact* found = nullptr;
  for (const Contact& contact : contacts_) {
    if (contact.depth <= 0 || (found != nullptr && contact.depth <= found->depth) || rests(contact, at)) continue;
    const bool leaves = contact.depth <= options_.start_gap && among(struck_, contact);
    const bool has_to_close = contact.depth <= touch_depth || leaves;
    if (has_to_close && normal_speed(contact, at) >= 0) continue;
    found = &contact;
  }
  return found;
}

/// The first touch on the way from `here_` to `there_`, `longest` seconds; `there_` becomes the state at it. Newton's
/// method on ODE's depth, which exists on one side only, within a bracket. Returns the time that passes until then.
double Flight::locate(double after, double longest) {
  double free = 0;
  double touching = longest;
  Contact touch = *deepest(there_);
  int fell_short =
      0;  // how often in a row: then the touch is near the last one, at a share of what is left, or it is not
  for (int round = 0; round < most_bisections && touch.depth > touch_depth; ++round) {
    const double closing = -normal_speed(touch, there_);
    const double newton = closing > 0 && fell_short == 0 ? touching - (touch.depth - touch_depth / 2) / closing : free;
    if ((newton <= 0 && round == 0) || (free <= 0 && round == 2)) {  // it may have begun in contact
      look(here_);
      const Contact* const at_once = deepest(here_);
      if (at_once != nullptr && at_once->depth > touch_depth) {
        there_ = here_;
        motion_.project(there_);
        return let_go_ = 0;
      }
    }
    // Depths jump where other corners come into play.
    if (round > 0 && closing > 0 && closing * (touching - free) <= touch_depth / 2) break;
    const double share = fell_short == 1 ? near_newton : 0.5;
    const double guess = newton > free && newton < touching ? newton : free + share * (touching - free);
    if (!(guess > free && guess < touching)) break;
    move(after, guess, trial_);
    look(trial_);
    const Contact* const found = deepest(trial_);
    fell_short = found == nullptr ? fell_short + 1 : 0;
    if (fell_short > 0) {
      free = guess;
      continue;
    }
    touching = guess;
    touch = *found;
    std::swap(there_, trial_);
  }
  arrive(there_, touching);
  motion_.project(there_);  // the matrix of this pose, for the impulses
  return let_go_ = touching;
}

/// Adds to the contacts at `there_` those that their impact, to the velocities of `struck`, closes within rounding.
/// Returns true if there are any.
bool Flight::add_closed_by(State struck) {
  std::vector<Twist> change(struck.size());
  double fastest = 0;
  for (std::size_t i = 0; i < struck.size(); ++i) {
    change[i].linear = struck[i].twist.linear - there_[i].twist.linear;
    change[i].angular = struck[i].twist.angular - there_[i].twist.angular;
    fastest = std::max({fastest, change[i].linear.norm(), change[i].angular.norm()});
  }
  if (fastest <= 0) return false;
  const double ahead = touching_distance / fastest;
  for (std::size_t i = 0; i < struck.size(); ++i) {
    struck[i].pose.position += ahead * change[i].linear;
    turn_by(ahead * change[i].angular, struck[i].pose.turn);
  }
  std::vector<Contact> closed = std::move(contacts_);
  look(struck);
  std::swap(contacts_, closed);
  return add_to_contacts(closed);
}

/// Those that are not among the contacts at hand. Returns true if there are any.
bool Flight::add_to_contacts(const std::vector<Contact>& more) {
  const std::size_t before = contacts_.size();
  for (const Contact& contact : more) {
    const auto is_it = [&](const Contact& other) {
      return same_geoms(contact, other) && (contact.point - other.point).norm() < same_point;
    };
    if (std::ranges::none_of(contacts_.begin(), contacts_.begin() + static_cast<std::ptrdiff_t>(before), is_it)) {
      contacts_.push_back(contact);
    }
  }
  return contacts_.size() > before;
}

void Flight::strike(State& state) {
  Impact(motion_, contacts_, state, work_).strike(state, options_.impact_order, options_.rest_speed);
}

/// At `there_`, which becomes `here_`: the next part of the step starts from it.
void Flight::impact(double t, bool at_once, bool last) {
  // What rests was let go since `here_`: it stops first, and gives nothing back of that.
  std::vector<Contact> resting = contacts_;
  std::erase_if(resting, [this](const Contact& contact) { return !rests(contact, there_); });
  const std::vector<LateMotor> motors = mover().late(let_go_);
  if (!resting.empty() || !motors.empty()) {
    const Impact held(motion_, resting, there_, work_, motors);
    bounce_elastic(motion_, held, resting, let_go_, there_);
    held.stop(there_);
  }
  State struck;
  std::span<Contact> striking;
  do {
    for (Contact& contact : contacts_) {
      if (last || stopped(contact)) contact.restitution = 0;
    }
    const auto rest =
        std::ranges::stable_partition(contacts_, [this](const Contact& contact) { return !rests(contact, there_); });
    striking = {contacts_.begin(), rest.begin()};
    struck = there_;
    strike(struck);
  } while (add_closed_by(struck));
  std::swap(here_, there_);
  const auto speed = [this](const Contact& contact) { return normal_speed(contact, here_); };
  const Contact& fastest = *std::ranges::min_element(striking, {}, speed);
  const std::size_t touch = touches_.size();
  touches_.push_back({t, -speed(fastest), 0, striking.size()});
  tell(options_.before_impact, touches_[touch]);
  taken_ -= gained(conservative() ? there_ : here_, struck);
  here_ = std::move(struck);
  touches_[touch].departure = speed(fastest);
  tell(options_.after_impact, touches_[touch]);

  // What leaves slowly stays, and so does what comes again without time passing.
  for (Contact& contact : striking) {
    if (speed(contact) <= options_.rest_speed) {
      place(contact, here_);
      resting_.push_back(contact);
    }
    if (at_once && among(struck_, contact)) stopped_.push_back(contact);
  }
  if (!at_once) struck_.clear();
  struck_.insert(struck_.end(), striking.begin(), striking.end());
  bounced_.insert(bounced_.end(), striking.begin(), striking.end());
  all_stopped_ = last;
}

void Flight::tell(const std::function<void(const Touch&)>& observer, const Touch& touch) const {
  if (!observer) return;
  show_poses(motion_.mechanism(), here_);
  show_twists(motion_.mechanism(), here_);
  observer(touch);
}

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

/// At the end of a step, with its contacts at hand: what rests stops and is pushed out of what it rests on. Returns
/// true if something touches that does not rest.
bool Flight::hold(State& state, double h) {
  Motion& motion = mover();
  std::vector<LateMotor> motors = motion.late(h);
  std::vector<Contact> fast = contacts_;
  std::erase_if(fast, [this](const Contact& contact) { return !held_fast(contact); });
  bool touched = false;
  sticks_ = {};
  const auto at_rest = [&] {
    touched = deepest(state) != nullptr;
    std::erase_if(contacts_, [&](const Contact& contact) { return !rests(contact, state) || held_fast(contact); });
  };
  at_rest();
  // The matrix of this pose, for the impulses.
  if (!contacts_.empty() || !motors.empty()) motion.stand(state);
  std::vector<Contact> rest = contacts_;
  const Eigen::VectorXd none;
  const auto is_gone = [this](const Contact& contact) { return contact.missed && !found_again(contact); };
  for (int push = 0; push < most_pushes && (!contacts_.empty() || !motors.empty()); ++push) {
    if (push > 0 && std::ranges::none_of(contacts_, &Contact::missed) && deepest_of(contacts_) <= 2 * rest_depth) break;
    const bool first = push == 0 && h > 0;
    if (first) recall(state, h);
    const bool pushed = !forces_->pushes.empty();
    const bool follows = first && (pushed || !motors.empty() || std::ranges::any_of(contacts_, &Contact::rubs));
    const Impact impact(motion, contacts_, state, work_, motors);
    const State free = state;
    bounce_elastic(motion, impact, contacts_, h, state);
    const Eigen::VectorXd impulses = impact.stop(state);
    const double work = impact.work(impulses, here_, free, state);
    if (first) tell_joints(impact, impulses, state, h);
    impact.spend(impulses, motors);  // what is found on the way out is borne by what they can give yet
    std::vector<Twist> by;
    const double done = !first ? 0 : conservative() ? gained(here_, free) : work_of_pushes(free, h);
    if (first) {
      note(impact, impulses, h);
      rest = contacts_;
    }
    if (follows) {
      sticks_ = impact.sticks_at(impulses, here_, state, h);
      by = follow(free, state, h);
    }
    const auto way = impact.way_out(rest_depth, by, follows ? impulses : push > 0 ? put_too_deep(rest) : none);
    // What only that would cost energy is paid at the end of the step: else it would be gone in many small parts.
    const double most = conservative() && !first_ ? HUGE_VAL : taken_ + work - done;
    const bool moved = move_out(motion, free, way, most, state);
    taken_ -= gained(free, state) + done - work;
    // Nothing comes deeper by that than what rests, nor out of reach.
    if (push == 0 && moved && lies_well(way)) break;
    if (moved) {
      look(state);
      at_rest();
    }
    if (!moved || push > 0) std::erase_if(rest, is_gone);
    if (!moved) break;  // between jaws of joints, or at the end of what can be lifted
    if (first) look_deeper(rest);
  }
  const double overlap = deepest_of(contacts_);
  if (overlap > options_.start_gap) {
    if (first_) look(here_);
    if (first_ && deepest_of(contacts_) > options_.start_gap) {
      refuse("an overlap of " + shown(overlap) + " m can not be pushed out; at most " + shown(options_.start_gap) +
             " are left to later steps");
    }
    crowd_on();  // what comes so near in a run, between jaws of joints, is left to the crowd's scheme
  }
  rest.insert(rest.end(), fast.begin(), fast.end());
  resting_ = std::move(rest);
  return touched;
}

}  // namespace odeval::engine_rk4
