#include "reference/tree/tree_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "odeval/error.hpp"
#include "reference/planar/wall_bounce.hpp"

namespace odeval::reference {
namespace {

using Axis = TreeEquations::Axis;

/// Times nearer than this, of t or of 1 s, are one.
constexpr double same_time = 1e-11;

/// Of places a metre apart, with a margin of a thousand: less is no overlap.
constexpr double rounding_m = 1e-13;

/// Where a step is looked at for what has no turning points to go by.
constexpr int looks = 4;

/// So many steps that come no further than this part of the run are none: loops near a pose in which they may branch
/// off are known ever less well, so that steps become ever smaller.
constexpr long steps_of_progress = 200;
constexpr double least_progress = 1e-6;

/// A passage is tried where the loops' margin has fallen to this part of its largest: in a four-bar linkage 0.5 rad
/// before it lies in a line, from where polynomials across are good to rounding.
constexpr double narrow = 0.5;
constexpr double anything = std::numeric_limits<double>::infinity();

/// So many changes without a way between them are no motion.
constexpr int most_in_a_row = 100;

/// Steps of CVODE in a millisecond, or in the scenario's step if that is shorter, and some to begin with. A motion that
/// needs more turns by many radians in a step, or has springs that do: no method with such a step follows it, and CVODE
/// takes hours to.
constexpr double most_steps_in_one = 100;
constexpr double usual_step_s = 1e-3;
constexpr double steps_to_begin_with = 20'000;

void add_bends(std::vector<double>& bends, const Signal& signal) {
  bends.insert(bends.end(), signal.times_s.begin(), signal.times_s.end());
}

double gap(const Axis& axis, const double* y, bool low) {
  return low ? axis.q(y) - axis.joint.stop->low : axis.joint.stop->high - axis.q(y);
}

}  // namespace

TreeMotion::TreeMotion(const TreeEquations& equations, const Scenario& scenario, Tolerances tolerances)
    : equations_(equations),
      name_(scenario.name),
      file_(scenario.file.empty() ? scenario.name : scenario.file),
      step_s_(scenario.step_s),
      duration_s_(scenario.duration_s),
      grips_(equations.grips(0, equations.start().data())),
      chart_(equations.chart(equations.start())),
      solver_(
          chart_->size(),
          [this](double t, const double* y, double* dydt) { equations_.slope(*chart_, t, y, dydt, grips_); },
          tolerances, scenario.name, scenario.duration_s),
      state_(equations.start()),
      may_pass_(
          !chart_->trivial() && !equations.samples() && equations.points().empty() &&
          std::ranges::none_of(equations.axes(), [](const Axis& axis) { return axis.joint.motor || axis.joint.stop; })),
      tried_(anything) {
  for (const Axis& axis : equations.axes()) {
    for (const Signal& torque : axis.joint.torques) add_bends(bends_, torque);
    for (const Controller& controller : axis.joint.controllers) add_bends(bends_, controller.target);
  }
  std::ranges::sort(bends_);
  for (const Body& body : scenario.mechanism.bodies) names_.push_back(body.name);
  require_clear_start();
  small_ = chart_->small(state_);
  solver_.start(0, small_.data());
}

void TreeMotion::require_clear_start() const {
  const std::vector<Meeting> all = equations_.meetings(state_.data());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].apart_m > TreeEquations::at_end || all[i].rate_m_s > TreeEquations::rest_speed) continue;
    const std::string how = all[i].apart_m < -rounding_m
                                ? fmt::format("lies {:.3g} m inside what it touches", -all[i].apart_m)
                                : "touches what it does not leave";
    throw UserError(fmt::format(
        "{}: at t = 0 body '{}' {}: the reference knows of impacts and not of rest; start it clear of that, "
        "or moving away",
        file_, names_[equations_.points()[i].body], how));
  }
}

void TreeMotion::require_progress() {
  const double step_s = std::fmin(step_s_, usual_step_s);
  if (static_cast<double>(solver_.steps()) <= steps_to_begin_with + most_steps_in_one * end_ / step_s) return;
  std::string text = fmt::format(
      "{}: the motion is too fast for its step: the reference has taken {} steps of CVODE at t = {:.3g} s, "
      "more than {} in each {:g} s",
      file_, solver_.steps(), end_, most_steps_in_one, step_s);
  const TreeEquations::Stiffness stiffest = equations_.stiffest(at(end_).data(), step_s_);
  if (stiffest.axis) {
    text += fmt::format(
        "; most of all springs, dampers and controllers of joint '{}' are too stiff, {:.3g} times what "
        "a step of that length could follow: make them softer, or the step shorter",
        equations_.axes()[*stiffest.axis].joint.name, stiffest.of_step);
  } else {
    text += "; make the motion slower, or the step shorter";
  }
  throw UserError(text);
}

double TreeMotion::next_known_time() const {
  const double later = end_ + same_time * (1 + end_);
  const auto bend = std::ranges::upper_bound(bends_, later);
  double next = bend == bends_.end() ? std::numeric_limits<double>::infinity() : *bend;
  if (equations_.samples()) next = std::fmin(next, step_s_ * (std::floor(later / step_s_) + 1));
  return next;
}

void TreeMotion::advance() {
  if (change_) {
    grips_ = std::move(change_->grips);
    chart_ = std::move(change_->chart);
    begin_ = std::exchange(end_, change_->end());
    passage_ = std::move(change_->passage);
    margin_ = 0;
    solver_.start(end_, chart_->small(change_->after).data());
    change_.reset();
    if (passage_) return;
  }
  passage_.reset();
  require_progress();
  begin_ = end_;
  const double known = next_known_time();
  if (std::isfinite(known)) solver_.end_by(known);
  solver_.step();
  end_ = solver_.end();
  require_loops_that_go_on();
  if (const std::optional<Event> event = first_event()) {
    happen(*event);
  } else if (end_ >= known) {
    happen_at_known_time();
  } else if (std::shared_ptr<const Passage> passage = next_passage()) {
    happen(std::move(passage));
  } else if (!chart_->trivial() && chart_->is_left_by(at(end_))) {
    leave_chart();
  }
}

void TreeMotion::require_loops_that_go_on() {
  if (chart_->trivial() || solver_.steps() % steps_of_progress != 0) return;
  if (end_ - marked_s_ < least_progress * duration_s_) {
    throw MachineError(
        fmt::format("reference for '{}': at t = {} s its loops come to a pose in which they may branch off; a "
                    "shorter duration ends before it",
                    name_, end_));
  }
  marked_s_ = end_;
}

const TreeMotion::State& TreeMotion::at(double t) {
  if (passage_) return state_ = passage_->way.at(t);
  if (solver_.steps() == 0) return state_;
  solver_.interpolate(t, small_.data());
  if (chart_->find(small_.data(), state_)) return state_;
  throw MachineError(fmt::format("reference for '{}': at t = {} s its loops can not be closed", name_, t));
}

TreePiece TreeMotion::piece() {
  TreePiece last{end_, grips_, chart_, at(end_), {}, passage_};
  if (!passage_ && solver_.steps() > 0) last.way = solver_.polynomial();
  return last;
}

TreeEquations::State TreePiece::at(double t) const {
  if (passage) return passage->way.at(t);
  TreeEquations::State state = last;
  if (way.coefficients.empty()) return state;
  std::vector<double> small(chart->size());
  way.at(t, small.data(), small.size());
  if (chart->find_near(small.data(), state)) return state;
  throw MachineError(fmt::format("reference: at t = {} s its loops can not be closed", t));
}

std::optional<TreeMotion::Event> TreeMotion::first_event() {
  std::optional<Event> first;
  const auto take = [&](std::optional<double> t, std::size_t axis, std::optional<double> lets_go, bool strikes) {
    if (t && (!first || *t < first->t)) first = Event{*t, axis, lets_go, strikes};
  };
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    const Axis& axis = equations_.axes()[i];
    const Grip& grip = grips_[i];
    if (axis.joint.stop) {
      for (const bool low : {true, false}) {
        const bool lies = grip.holds && std::isinf(low ? grip.most : grip.least);
        if (!lies) take(first_touch(axis, low), i, {}, true);
      }
    }
    if (axis.joint.motor && axis.joint.motor->most > 0 && !grip.holds) {
      const double way = std::copysign(1, grip.force);
      const double slack = TreeEquations::at_speed;
      take(first_zero([&](double t) { return way * (axis.joint.motor->speed - axis.rate(at(t).data())); }, slack), i,
           {}, false);
    }
    if (grip.holds) {
      const auto force = [&](double t) { return equations_.holding(t, at(t).data(), grips_)[i]; };
      const double slack = 0;
      if (std::isfinite(grip.least)) {
        take(first_zero([&](double t) { return force(t) - grip.least; }, slack), i, grip.least, false);
      }
      if (std::isfinite(grip.most)) {
        take(first_zero([&](double t) { return grip.most - force(t); }, slack), i, grip.most, false);
      }
    }
  }
  const std::optional<Event> meeting = first_meeting();
  return meeting && (!first || meeting->t < first->t) ? meeting : first;
}

std::optional<TreeMotion::Event> TreeMotion::first_meeting() {
  const std::size_t count = equations_.points().size();
  if (count == 0) return std::nullopt;
  const std::vector<Meeting> at_begin = equations_.meetings(at(begin_).data());
  const std::vector<Meeting> at_end = equations_.meetings(at(end_).data());
  std::optional<Event> first;
  for (std::size_t i = 0; i < count; ++i) {
    const bool falls = at_begin[i].rate_m_s < 0 || at_end[i].rate_m_s < 0;
    if (!falls) continue;
    const auto now = [this, i](double t) { return equations_.meeting_at(at(t).data(), i); };
    const std::optional<double> t =
        first_fall([&](double s) { return now(s).apart_m; }, [&](double s) { return now(s).rate_m_s; });
    if (t && (!first || *t < first->t)) first = Event{*t, 0, {}, false, i};
  }
  return first;
}

/// The earliest time in the step at which the joint passes an end of its way. Within a step it turns once at most.
std::optional<double> TreeMotion::first_touch(const Axis& axis, bool low) {
  const auto height = [&](double t) { return gap(axis, at(t).data(), low); };
  const auto rate = [&](double t) { return (low ? 1 : -1) * axis.rate(at(t).data()); };
  return first_fall(height, rate);
}

std::optional<double> TreeMotion::first_fall(const Number& height, const Number& rate) const {
  const double rate_begin = rate(begin_);
  const double rate_end = rate(end_);
  double from = begin_;
  double to = end_;
  if (rate_begin < 0 && rate_end > 0) {
    to = root(rate, from, to, rate_begin, rate_end);
  } else if (rate_begin > 0 && rate_end < 0) {
    from = root(rate, from, to, rate_begin, rate_end);
  } else if (rate_end >= 0) {
    return std::nullopt;
  }
  const double height_from = height(from);
  const double height_to = height(to);
  if (height_to >= 0) return std::nullopt;
  return height_from > 0 ? root(height, from, to, height_from, height_to) : from;
}

/// The earliest time in the step at which a margin falls to 0 that is not below it at first, by more than a slack.
std::optional<double> TreeMotion::first_zero(const std::function<double(double)>& margin, double slack) {
  double from = begin_;
  double at_from = margin(from);
  for (int k = 1; k <= looks; ++k) {
    const double to = k == looks ? end_ : begin_ + (end_ - begin_) * k / looks;
    const double at_to = margin(to);
    if (at_to < -slack) return at_from > 0 ? root(margin, from, to, at_from, at_to) : from;
    from = to;
    at_from = at_to;
  }
  return std::nullopt;
}

void TreeMotion::happen(const Event& event) {
  if (event.point) return meet(event);
  const Axis& axis = equations_.axes()[event.axis];
  Change change{event.t, at(event.t), {}, {}, {}, {}, {}};
  if (event.strikes) {
    const double* const now = change.before.data();
    const bool low = gap(axis, now, true) < gap(axis, now, false);
    change.jump = [this, strike = equations_.strike(now, event.axis)](const State& y) {
      return equations_.struck(y.data(), strike);
    };
    change.cause = [axis, low](double, const State& y) { return gap(axis, y.data(), low); };
  } else if (event.lets_go) {
    change.jump = [](const State& y) { return y; };
    change.cause = [this, i = event.axis, grips = grips_](double t, const State& y) {
      return equations_.holding(t, y.data(), grips)[i];
    };
  } else {
    change.jump = [axis](State y) {
      y[axis.speed] = axis.sign * axis.joint.motor->speed;
      return y;
    };
    change.cause = [axis](double, const State& y) { return axis.rate(y.data()); };
  }
  change.after = change.jump(change.before);
  std::optional<TreeEquations::Released> released;
  if (event.lets_go) released = {event.axis, *event.lets_go};
  change.grips = equations_.grips(event.t, change.after.data(), released);
  ++changes_;
  change_to(std::move(change));
}

void TreeMotion::meet(const Event& event) {
  Change change{event.t, at(event.t), {}, {}, {}, {}, {}};
  const double* const now = change.before.data();
  const TreeEquations::Hit hit = equations_.hit(now, *event.point);
  if (std::ranges::min(hit.restitution) == 0) {
    throw UserError(
        fmt::format("{}: at t = {:.9g} s body '{}' comes to rest on what it touches: the reference knows of "
                    "impacts and not of rest; a shorter duration ends before it",
                    file_, event.t, names_[equations_.points()[*event.point].body]));
  }
  change.jump = [this, hit](const State& y) { return equations_.rebounded(y.data(), hit); };
  change.cause = [this, point = *event.point](double, const State& y) {
    return equations_.meeting_at(y.data(), point).apart_m;
  };
  change.after = change.jump(change.before);
  change.grips = equations_.grips(event.t, change.after.data());
  ++changes_;
  change_to(std::move(change));
}

void TreeMotion::happen_at_known_time() {
  Change change{end_, at(end_), {}, {}, {}, {}, {}};
  change.jump = [this, t = end_](const State& y) { return equations_.sampled(t, y.data()); };
  change.after = change.jump(change.before);
  change.grips = equations_.grips(end_, change.after.data());
  change_to(std::move(change));
}

void TreeMotion::leave_chart() {
  Change change{end_, at(end_), {}, grips_, {}, {}, {}};
  change.jump = [](const State& y) { return y; };
  change.after = change.before;
  change_to(std::move(change));
}

/// Where the loops' margin falls to 0 soon, if it goes on as it does.
std::shared_ptr<const Passage> TreeMotion::next_passage() {
  if (!may_pass_) return nullptr;
  const State& now = at(end_);
  const double margin = chart_->closure(now).margin;
  const double rate = (margin - std::exchange(margin_, margin)) / (end_ - begin_);
  widest_ = std::fmax(widest_, margin);
  if (margin > narrow * widest_) tried_ = anything;
  if (rate >= 0 || margin > narrow * widest_ || margin > tried_ / 2) return nullptr;
  tried_ = margin;
  State here = now;
  std::optional<Passage> passage = pass({equations_, chart_, grips_, end_, end_ - 2 * margin / rate}, here);
  if (passage && passage->way.end() <= next_known_time()) return std::make_shared<const Passage>(*std::move(passage));
  const State small =
      chart_->small(here);  // what was tried last lies beyond the pose, from where nothing is found here
  if (!chart_->find_near(small.data(), here)) {
    throw MachineError(fmt::format("reference for '{}': at t = {} s its loops can not be closed", name_, end_));
  }
  return nullptr;
}

void TreeMotion::happen(std::shared_ptr<const Passage> passage) {
  Change change{end_, at(end_), passage->way.last(), grips_, {}, {}, {}, passage};
  const Across across{equations_, chart_, grips_, end_, passage->way.end()};
  change.jump = [across, passage](const State& y) {
    const std::optional<Way> way = pass_near(across, y, passage->way);
    return way ? way->last() : State(y.size(), std::numeric_limits<double>::quiet_NaN());
  };
  change_to(std::move(change));
}

void TreeMotion::change_to(Change change) {
  in_a_row_ = change.t > begin_ ? 0 : in_a_row_ + 1;
  if (in_a_row_ > most_in_a_row) {
    throw MachineError(
        fmt::format("reference for '{}': at t = {} s motors and stops change what they do without end; a "
                    "shorter duration ends before it",
                    name_, change.t));
  }
  // What locating leaves of the speed of a joint that holds.
  for (std::size_t i = 0; i < change.grips.size(); ++i) {
    if (!change.grips[i].holds) continue;
    const Axis& axis = equations_.axes()[i];
    const std::optional<Motor>& motor = axis.joint.motor;
    const bool driven = motor && std::fabs(axis.rate(change.after.data()) - motor->speed) <= TreeEquations::at_speed;
    change.after[axis.speed] = driven ? axis.sign * motor->speed : 0;
  }
  end_ = change.t;
  change.chart = equations_.chart(change.after);
  change_ = std::move(change);
}

}  // namespace odeval::reference
