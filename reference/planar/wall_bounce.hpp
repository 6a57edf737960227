#pragma once
// The arc a link may swing through without entering the wall, and what happens at its ends. One link on one hinge; the
// state is (q, qd).
//
// The arc, the root finder and the cap on impacts serve every method that locates its touches; WallBounce serves the
// closed form, the fixed steps and ode45. CVODE keeps its own bounces (cvode_motion.hpp), since a bound on their error
// asks for more: grazes told from touches, hops too low for its tolerances, a known height where they are cut short.
//
// Since the outline is a rectangle and the wall is flat, every angle of touch has a closed form. A corner at
// (s, side w/2), R = hypot(s, w/2), beta = atan2(side w/2, s), is inside the wall (wall_contact.hpp) when
//
//   hinge_x - face + R cos(q + beta) < 0,  that is  |q - (pi - beta)| < acos((hinge_x - face) / R)  (mod 2 pi)
//
// so a touch is nothing but the angle that reaches an end of the arc left free around q0.
#include <algorithm>
#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>

#include "odeval/engine.hpp"
#include "odeval/error.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/wall_contact.hpp"

namespace odeval::reference {

/// rad; both ends are angles of touch, infinite where the link never touches.
struct FreeArc {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// The free arc around q0. A start up to 1e-9 rad inside the wall counts as contact; deeper is a UserError.
/// A corner that would dip into the wall by no more than rounding grazes it and is no touch.
inline FreeArc free_arc(const Scenario& scenario) {
  using std::numbers::pi;
  constexpr double start_slack = 1e-9;
  const PlanarView& view = *scenario.planar;
  const Link& link = view.links.at(0);
  const double q0 = view.q0.at(0);
  const double hinge = view.frame.hinge_m[0];
  const double face = view.wall.value().face_m;
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * (std::fabs(hinge) + std::fabs(face));
  FreeArc arc;
  for (const double along : {0.0, link.length_m}) {
    for (const double across : {link.width_m / 2, -link.width_m / 2}) {
      const double reach = std::hypot(along, across);
      if (hinge - face >= reach - rounding) continue;
      const double half = std::acos(std::max((hinge - face) / reach, -1.0));
      const double first_middle = pi - std::atan2(across, along);
      const double middle = first_middle + 2 * pi * std::round((q0 - first_middle) / (2 * pi));
      if (std::fabs(q0 - middle) < half - start_slack) {
        std::ostringstream text;
        text << "scenario '" << scenario.name << "': q0 = " << q0 << " starts inside the wall, whose face is at "
             << face << " m; the link has to start clear of it";
        throw UserError(text.str());
      }
      const bool above = q0 > middle;
      arc.low = std::max(arc.low, middle + half - (above ? 0 : 2 * pi));
      arc.high = std::min(arc.high, middle - half + (above ? 2 * pi : 0));
    }
  }
  return arc;
}

/// Bounces of 1e-7 rad/s that lose nothing would be 5e8 in 10 s: a run has to end.
inline constexpr std::size_t most_impacts = 1'000'000;

/// The zero of f between a and b, where f has the values fa and fb of unlike sign, to the last bits.
template <class Function>
double root(Function&& f, double a, double b, double fa, double fb) {
  std::uintmax_t most = 200;
  const auto bracket =
      boost::math::tools::toms748_solve(f, a, b, fa, fb, boost::math::tools::eps_tolerance<double>(), most);
  return bracket.first + (bracket.second - bracket.first) / 2;
}

/// A touch inside a step.
struct Touch {
  double after_s;  // since the step's start
  double angle;    // the end of the free arc that was reached
  bool upward;     // it is the arc's high end
};

class WallBounce {
 public:
  using State = std::array<double, 2>;

  explicit WallBounce(const Scenario& scenario) : equations_(scenario) {
    if (!scenario.planar->wall) return;
    arc_ = free_arc(scenario);
    restitution_ = scenario.planar->wall->restitution;
  }

  const FreeArc& arc() const { return arc_; }

  /// The first touch in a step of length_s from `start` to `end`, which lie `at(0)` and `at(length_s)`.
  /// A step in which the link turns is taken as two swings, one each way, so that a touch between two states
  /// on the free side, or a second touch soon after the first, is found as well.
  template <class At>
  std::optional<Touch> first_touch(const State& start, const State& end, double length_s, At&& at) const {
    const bool turns = start[1] * end[1] < 0;
    if (!turns && arc_.low < end[0] && end[0] < arc_.high) return std::nullopt;
    const double heading = start[1] != 0 ? start[1] : end[1];
    if (heading == 0 || !std::isfinite(end[0]) || !std::isfinite(end[1])) return std::nullopt;
    const bool upward = heading > 0;
    if (!turns) return touch_in_swing(upward, 0, start, length_s, end, at);
    const double turn = root([&](double s) { return at(s)[1]; }, 0, length_s, start[1], end[1]);
    const State turned = at(turn);
    if (const auto touch = touch_in_swing(upward, 0, start, turn, turned, at)) return touch;
    return touch_in_swing(!upward, turn, turned, length_s, end, at);
  }

  /// The link touches at time t in state y: records the impact and reverses the link.
  /// False when the run ends here: the link has come to rest, or bounces without end.
  bool bounce(double t, const Touch& touch, State& y, Outcome& outcome) const {
    const double before = y[1];
    y = {touch.angle, -restitution_ * before};
    outcome.impacts.push_back({t, touch.angle, before, y[1], 0});
    if (leans_on_wall(touch.angle, touch.upward) && std::fabs(y[1]) < rest_speed_rad_s) {
      y[1] = 0;
      outcome.at_rest_from = t;
      return false;
    }
    if (outcome.impacts.size() >= most_impacts) {
      outcome.diverged = true;
      std::ostringstream text;
      text << "gave up after " << most_impacts << " impacts (t = " << t << " s)";
      outcome.reason = text.str();
      return false;
    }
    return true;
  }

  /// A start in contact, without speed and with the link's weight against the wall.
  bool rests(const State& y) const {
    // Rounding of an angle of touch: these methods can follow bounces lower than what CVODE counts as contact.
    constexpr double contact = 1e-15;  // rad
    return std::fabs(y[1]) < rest_speed_rad_s && ((y[0] >= arc_.high - contact && leans_on_wall(arc_.high, true)) ||
                                                  (y[0] <= arc_.low + contact && leans_on_wall(arc_.low, false)));
  }

 private:
  bool leans_on_wall(double angle, bool upward) const {
    State rate;
    equations_({angle, 0}, rate);
    return upward ? rate[1] > 0 : rate[1] < 0;
  }

  template <class At>
  std::optional<Touch> touch_in_swing(bool upward, double begin, const State& from, double end, const State& to,
                                      At&& at) const {
    const double angle = upward ? arc_.high : arc_.low;
    const auto beyond = [&](const State& y) { return upward ? y[0] - angle : angle - y[0]; };
    if (!(beyond(to) >= 0)) return std::nullopt;
    if (beyond(from) >= 0) return Touch{begin, angle, upward};
    return Touch{root([&](double s) { return beyond(at(s)); }, begin, end, beyond(from), beyond(to)), angle, upward};
  }

  ChainEquations<double, 1> equations_;
  FreeArc arc_;
  double restitution_ = 1;
};

}  // namespace odeval::reference
