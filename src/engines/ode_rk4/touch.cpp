// Where on its way a step touches something, and what that does.
#include <algorithm>
#include <span>
#include <utility>

#include "engines/ode_rk4/bodies.hpp"
#include "engines/ode_rk4/flight.hpp"

namespace odeval::engine_rk4 {
namespace {

// An impact is located to this overlap, m: a thousand roundings of positions of a metre, and passed in 1e-12 s at 1
// m/s.
constexpr double touch_depth = 1e-12;
// Geoms this near, m, that an impact closes touched when it happened: rows and corners that touch do so to rounding.
constexpr double touching_distance = 1e-9;
// m: points of one pair of geoms nearer than this are one contact.
constexpr double same_point = 1e-6;
constexpr int most_bisections = 100;
constexpr double near_newton = 0.02;  // of the bracket: Newton's method misses by the square of what it moved

bool among(const std::vector<Contact>& contacts, const Contact& contact) {
  return std::ranges::any_of(contacts, [&](const Contact& other) { return same_geoms(contact, other); });
}

}  // namespace

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
  taken_ -= gained(passive() ? there_ : here_, struck);
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

}  // namespace odeval::engine_rk4
