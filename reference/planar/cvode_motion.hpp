#pragma once
// A scenario moved by CVODE, piece after piece: steps of the solver, cut short where the link touches the wall.
//
// A touch is located on the solver's own polynomial: the first time the angle passes a stop while moving into the wall.
// Since an angle is monotone between its turning points, no touch hides inside a step. Then qd -> -e qd, and:
//
// - Weight against the wall and the link barely moving: it hops. The hops, too small for a solver with absolute
//   tolerances, are parabolas. Slower than `rest_speed_rad_s` the link is at rest, for ever.
// - Weight away from the wall and the link barely moving: it only grazes the wall, and swings on.
//
// Two balls (ball_wall.hpp): a touch is the first time a ball's distance from the wall passes 0 while it falls, found
// likewise. Balls that come to rest on the wall are not followed: that is a MachineError that says when.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "odeval/engine.hpp"
#include "odeval/error.hpp"
#include "odeval/scenario.hpp"
#include "reference/cvode_solver.hpp"
#include "reference/planar/ball_wall.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/wall_bounce.hpp"
#include "reference/planar/wall_contact.hpp"

namespace odeval::reference {

/// A touch slower than this, with the weight away from the wall, is a graze: the link would go less than 1e-13 rad into
/// the wall (v^2 / 2a at 10 rad/s^2), which is about what the solver knows of the angle.
inline constexpr double graze_speed_rad_s = 1e-6;

template <std::size_t N>
class CvodeMotion {
 public:
  using Equations = ChainEquations<double, N>;
  using State = typename Equations::State;
  enum class Phase { flight, hop, rest };
  /// Relative change of the acceleration over a hop that is ignored.
  static constexpr double hop_bend = 1e-9;

  CvodeMotion(const Scenario& scenario, Tolerances tolerances)
      : equations_(scenario),
        solver_(
            2 * N, [this](double, const double* y, double* dydt) { evaluate(y, dydt); }, tolerances, scenario.name,
            scenario.duration_s),
        begin_state_(start_state<State>(*scenario.planar)),
        end_state_(begin_state_) {
    if constexpr (N == 1) {
      if (scenario.planar->wall) meet_wall(scenario);
    }
    if constexpr (N == 2) {
      if (!scenario.planar->wall) return;
      balls_.emplace(scenario);
      name_ = scenario.name;
      meet_wall_with_balls();
    }
  }
  CvodeMotion(const CvodeMotion&) = delete;
  CvodeMotion& operator=(const CvodeMotion&) = delete;

  /// On to the next piece, [begin(), end()]. A piece at rest ends at infinity.
  void advance() {
    begin_ = end_;
    begin_state_ = end_state_;
    phase_ = next_;
    struck_ = false;
    turn_height_.reset();
    if (phase_ == Phase::flight) fly();
    if constexpr (N == 1) {
      if (phase_ == Phase::hop) hop();
    }
    if (phase_ == Phase::rest) end_ = std::numeric_limits<double>::infinity();
  }

  double begin() const { return begin_; }
  double end() const { return end_; }
  Phase phase() const { return phase_; }
  /// True when the piece ends with the last of `impacts()`.
  bool struck() const { return struck_; }
  /// Where the weight turned the link back from the wall in this piece: its height above the stop, rad.
  const std::optional<double>& turn_height() const { return turn_height_; }

  /// The state at a time of the piece. At an impact: before it at end(), after it at begin().
  State at(double t) const {
    if (t <= begin_ || phase_ == Phase::rest) return begin_state_;
    if (t >= end_ && !struck_) return end_state_;
    if constexpr (N == 1) {
      if (phase_ == Phase::hop) {
        const double s = t - begin_;
        const double pull = acceleration(begin_state_[0]);
        return {begin_state_[0] + begin_state_[1] * s + pull * s * s / 2, begin_state_[1] + pull * s};
      }
    }
    State y;
    solver_.interpolate(std::fmin(t, end_), y.data());
    return y;
  }

  const Equations& equations() const { return equations_; }
  /// All so far: the last step may have gone beyond the end of a grid.
  const std::vector<Impact>& impacts() const { return impacts_; }
  double restitution() const { return restitution_; }
  const std::optional<BallWall>& balls() const { return balls_; }
  /// rad, rounding of the angles of touch.
  double stop_uncertainty() const { return stop_uncertainty_; }
  double acceleration(double q) const requires(N == 1) {
    State slope;
    equations_(State{q, 0.0}, slope);
    return slope[1];
  }
  /// s; < 0: never.
  double at_rest_from() const { return at_rest_from_; }
  /// How high the bounces would be that rest leaves out, rad.
  double rest_height() const { return rest_height_; }
  long steps() const { return solver_.steps(); }
  long evaluations() const { return solver_.evaluations(); }

 private:
  struct Stop {
    double angle;
    double away;  // sign of the rate that leaves the wall
  };
  struct Touch {
    double t;
    double speed;  // into the wall
    Stop stop;
  };

  // A link that starts this near the wall starts at it: about what the solver loses of the angle in a swing, so that it
  // could not tell whether the link touches when it comes back.
  static constexpr double contact_rad = 1e-12;
  static constexpr double contact_m = 1e-12;  // a ball this near the wall is at it; for the same reason
  static constexpr double no_pull = 1e-12;    // rad/s^2; weaker than this, nothing takes a link off the wall

  void evaluate(const double* y, double* dydt) {
    State state, slope;
    std::copy_n(y, 2 * N, state.begin());
    equations_(state, slope);
    std::copy_n(slope.begin(), 2 * N, dydt);
  }

  void fly() {
    if (restart_) solver_.start(end_, end_state_.data());
    restart_ = false;
    solver_.step();
    end_ = solver_.end();
    std::copy_n(solver_.state(), 2 * N, end_state_.begin());
    if constexpr (N == 1) {
      std::optional<Touch> first;
      for (const Stop& stop : stops_) {
        const std::optional<Touch> touch = first_touch(stop);
        if (touch && (!first || touch->t < first->t)) first = touch;
      }
      if (first) strike(*first);
    }
    if constexpr (N == 2) {
      if (balls_) fly_balls();
    }
  }

  // --- two balls ---

  struct BallTouch {
    double t;
    std::size_t ball;
  };

  void meet_wall_with_balls() requires(N == 2) {
    for (std::size_t ball = 0; ball < N; ++ball) {
      if (balls_->distance(ball, begin_state_) > contact_m || balls_->speed(ball, begin_state_) > 0) continue;
      strike_ball({0.0, ball}, begin_state_);
      begin_state_ = end_state_;
      return;
    }
  }

  void fly_balls() requires(N == 2) {
    std::optional<BallTouch> first;
    for (std::size_t ball = 0; ball < N; ++ball) {
      const std::optional<double> t = first_ball_touch(ball);
      if (t && (!first || *t < first->t)) first = BallTouch{*t, ball};
    }
    if (first) strike_ball(*first, at(first->t));
  }

  // As first_touch; within a step of the solver a ball turns once at most.
  std::optional<double> first_ball_touch(std::size_t ball) const requires(N == 2) {
    const auto height = [&](double t) { return balls_->distance(ball, at(t)); };
    const auto rate = [&](double t) { return balls_->speed(ball, at(t)); };
    const double rate_begin = balls_->speed(ball, begin_state_);
    const double rate_end = balls_->speed(ball, end_state_);
    double from = begin_;
    double to = end_;
    if (rate_begin < 0 && rate_end > 0) {
      to = root(rate, from, to, rate_begin, rate_end);
    } else if (rate_begin > 0 && rate_end < 0) {
      from = root(rate, from, to, rate_begin, rate_end);
    } else if (rate_end > 0) {
      return std::nullopt;
    }
    const double height_from = height(from);
    const double height_to = height(to);
    if (height_to >= 0) return std::nullopt;
    return height_from > 0 ? root(height, from, to, height_from, height_to) : from;
  }

  void strike_ball(const BallTouch& touch, const State& y) requires(N == 2) {
    std::array<bool, N> at_wall{};
    for (std::size_t ball = 0; ball < N; ++ball) {
      at_wall[ball] = ball == touch.ball || balls_->distance(ball, y) <= contact_m;
    }
    end_ = touch.t;
    end_state_ = balls_->struck(y, at_wall);
    restart_ = true;
    struck_ = true;
    for (std::size_t ball = 0; ball < N; ++ball) {
      if (!at_wall[ball]) continue;
      const double leaving = balls_->speed(ball, end_state_);
      if (ball == touch.ball || balls_->speed(ball, y) < 0) {
        impacts_.push_back({touch.t, y[0], balls_->speed(ball, y), leaving, 0.0, static_cast<int>(ball) + 1});
      }
      if (std::fabs(leaving) < rest_speed_rad_s && balls_->pull(ball, end_state_) < -no_pull) {
        std::ostringstream text;
        text << "reference for '" << name_ << "': at t = " << touch.t << " s ball " << ball + 1
             << " comes to rest on the wall, which is not followed; a shorter duration ends before it";
        throw MachineError(text.str());
      }
    }
  }

  void meet_wall(const Scenario& scenario) {
    restitution_ = scenario.planar->wall->restitution;
    const FreeArc arc = free_arc(scenario);
    if (!std::isfinite(arc.low)) return;
    stops_ = {{arc.low, 1.0}, {arc.high, -1.0}};
    const WallContact wall(*scenario.planar);
    for (const Stop& stop : stops_) stop_uncertainty_ = std::max(stop_uncertainty_, rounding(wall, stop.angle));
    for (const Stop& stop : stops_) {
      if (stop.away * (begin_state_[0] - stop.angle) > contact_rad) continue;
      begin_state_[0] = stop.angle;
      const double rate = stop.away * begin_state_[1];
      if (rate < 0) {
        strike({0.0, -rate, stop});
      } else {
        leave(0.0, stop, rate);
      }
      begin_state_ = end_state_;
      return;
    }
  }

  /// How far an angle of touch may be off: by a few roundings of itself and of the distances of the corner that is
  /// there.
  static double rounding(const WallContact& wall, double angle) {
    constexpr double few = 8 * std::numeric_limits<double>::epsilon();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t corner = 0; corner < WallContact::corners; ++corner) {
      const double reach = std::hypot(wall.slope(corner, 0.0), wall.slope(corner, std::acos(0.0)));
      const double off = std::fabs(wall.distance(corner, angle)) + few * reach;
      least = std::min(least, off / std::fabs(wall.slope(corner, angle)));
    }
    return least + few * std::fabs(angle);
  }

  /// The earliest touch of a stop within the step.
  std::optional<Touch> first_touch(const Stop& stop) {
    const auto height = [&](double t) { return stop.away * (at(t)[0] - stop.angle); };
    const auto rate = [&](double t) { return stop.away * at(t)[1]; };
    const double rate_begin = stop.away * begin_state_[1];
    const double rate_end = stop.away * end_state_[1];
    double from = begin_;
    double to = end_;
    if (rate_begin < 0 && rate_end > 0) {
      to = root(rate, from, to, rate_begin, rate_end);
      turn_height_ = height(to);
    } else if (rate_begin > 0 && rate_end < 0) {
      from = root(rate, from, to, rate_begin, rate_end);
    } else if (rate_end > 0) {
      return std::nullopt;
    }
    const double height_from = height(from);
    const double height_to = height(to);
    if (height_to >= 0) return std::nullopt;
    const double t = height_from > 0 ? root(height, from, to, height_from, height_to) : from;
    const double speed = std::fmax(-rate(t), 0.0);
    // A link comes back to a stop as fast as it left it, which is known better than a small speed can be integrated.
    const double known = left_stop_ == stop.angle ? left_speed_ : speed;
    if (known < graze_speed_rad_s && stop.away * acceleration(stop.angle) > no_pull) return std::nullopt;
    return Touch{t, speed, stop};
  }

  void strike(const Touch& touch) {
    const double leaving = restitution_ * touch.speed;
    // Adding 0 turns -0 into 0.
    impacts_.push_back(
        {touch.t, touch.stop.angle, -touch.stop.away * touch.speed + 0.0, touch.stop.away * leaving + 0.0, 0.0});
    struck_ = true;
    leave(touch.t, touch.stop, leaving);
  }

  /// What a link does that leaves a stop with a speed >= 0.
  void leave(double t, const Stop& stop, double speed) {
    const double pull = stop.away * acceleration(stop.angle);
    left_stop_ = stop.angle;
    left_speed_ = speed;
    end_ = t;
    end_state_ = {stop.angle, stop.away * speed + 0.0};
    next_ = Phase::flight;
    restart_ = true;
    if (pull > no_pull) return;
    // How high it will go: a parabola's height, or a swing's where the pull is weak; for ever where there is none.
    const double stiffness = std::fabs(acceleration(0.0));
    const double height =
        speed == 0 ? 0 : std::fmin(speed * speed / (2 * std::fabs(pull)), speed / std::sqrt(stiffness));
    // Past the cap WallBounce gives up; a reference owes every sample a value, so the link rests, at a known height.
    if ((speed < rest_speed_rad_s && std::isfinite(height)) || impacts_.size() >= most_impacts) {
      next_ = Phase::rest;
      at_rest_from_ = t;
      rest_height_ = height;
      end_state_[1] = 0;
    } else if (speed * speed * stiffness < hop_bend * pull * pull) {
      next_ = Phase::hop;
    }
  }

  void hop() {
    const double pull = acceleration(begin_state_[0]);
    const Stop stop{begin_state_[0], begin_state_[1] > 0 ? 1.0 : -1.0};
    strike({begin_ + 2 * std::fabs(begin_state_[1] / pull), std::fabs(begin_state_[1]), stop});
  }

  Equations equations_;
  CvodeSolver solver_;
  std::vector<Stop> stops_;  // none, or the low and the high end of the free arc
  std::optional<BallWall> balls_;
  std::string name_;
  double restitution_ = 1;
  double stop_uncertainty_ = 0;

  Phase phase_ = Phase::flight;
  Phase next_ = Phase::flight;
  bool restart_ = true;
  bool struck_ = false;
  std::optional<double> turn_height_;
  double begin_ = 0;
  double end_ = 0;
  State begin_state_;
  State end_state_;
  std::vector<Impact> impacts_;
  double left_stop_ = std::numeric_limits<double>::quiet_NaN();
  double left_speed_ = 0;
  double at_rest_from_ = -1;
  double rest_height_ = 0;
};

}  // namespace odeval::reference
