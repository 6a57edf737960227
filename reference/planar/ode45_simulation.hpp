#pragma once
// The steps of ode45.hpp, for any equations of motion.
#include <algorithm>
#include <array>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>
#include <cstddef>
#include <optional>
#include <sstream>
#include <utility>

#include "odeval/engine.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/wall_bounce.hpp"

namespace odeval::reference {

/// Equations have `dof`, a `State` of (q, qd), an array of 2 dof numbers or, with dof 0, a vector of any, and give
/// dy/dt by operator()(y, dydt).
template <class Equations>
class Ode45 final : public Simulation {
 public:
  using State = typename Equations::State;

  /// A wall is for one joint only.
  Ode45(Equations equations, const SampleGrid& grid, const State& start, double rtol, double atol,
        std::optional<WallBounce> wall = {})
      : equations_(std::move(equations)),
        grid_(grid),
        start_(start),
        rtol_(rtol),
        atol_(atol),
        wall_(std::move(wall)) {}

  SampleShape shape() const override { return {.coordinates = start_.size() / 2}; }

  Outcome run(Recorder recorder) override {
    outcome_ = {};
    recorder_ = recorder;
    next_row_ = 0;
    const double end = grid_.time(grid_.rows - 1);
    State y = start_;
    double t = 0;
    record_row(y);
    bool moving = true;
    if constexpr (Equations::dof == 1) {
      if (wall_ && wall_->rests(y)) {
        outcome_.at_rest_from = 0;
        moving = false;
      }
    }
    while (moving && t < end) moving = smooth_motion(t, y, end);
    if (outcome_.diverged) return outcome_;
    while (next_row_ < grid_.rows) record_row(y);  // a touch at the last moment, or rest
    return outcome_;
  }

 private:
  static constexpr double power = 1.0 / 5;

  // Moves (t, y) to the end or through the next touch. False: the motion ends there.
  bool smooth_motion(double& t, State& y, double end) {
    const double longest = end / 10;
    State rate = y;
    evaluate(y, rate);
    State y_new = y;
    State rate_new = y;
    State error = y;
    double h = first_step(y, rate, std::min(longest, end - t));
    bool failed = false;
    while (t < end) {
      // ode45 gives up at 16 units in the last place of t, below which time no longer moves.
      const double shortest = 16 * (std::nextafter(t, end) - t);
      h = std::clamp(h, shortest, std::max(longest, shortest));
      const bool last = 1.1 * h >= end - t;
      if (last) h = end - t;
      dopri5_.do_step([this](const State& at, State& out, double) { evaluate(at, out); }, y, rate, t, y_new, rate_new,
                      h, error);
      const double excess = worst(error, y, y_new);
      if (excess > 1) {
        if (h <= shortest) return give_up(t);
        h = std::max(shortest, h * (failed ? 0.5 : std::max(0.1, 0.8 * std::pow(excess, -power))));
        failed = true;
        continue;
      }
      ++outcome_.steps;
      const double t_new = last ? end : t + h;
      if (!finite(y_new)) {
        set_not_finite(outcome_, y_new, t_new);
        return false;
      }
      const auto after = [&](double s) {
        State at = y;
        dopri5_.calc_state(s, at, y, rate, 0.0, y_new, rate_new, h);
        return at;
      };
      if constexpr (Equations::dof == 1) {
        if (wall_) {
          if (const auto touch = wall_->first_touch(y, y_new, h, after)) {
            const double t_touch = std::min(t + touch->after_s, end);
            record_before(t_touch, t, after);
            y = after(touch->after_s);
            t = t_touch;
            return wall_->bounce(t, *touch, y, outcome_);
          }
        }
      }
      record_before(t_new, t, after);
      if (last) record_row(y_new);
      if (!failed) h /= std::max(0.2, 1.25 * std::pow(excess, power));
      failed = false;
      t = t_new;
      y = y_new;
      rate = rate_new;
    }
    return true;
  }

  void evaluate(const State& y, State& rate) {
    ++outcome_.evaluations;
    equations_(y, rate);
  }

  // The largest component of v in units of what the tolerances allow it.
  double worst(const State& v, const State& y, const State& y_new) const {
    double most = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double allowed = std::max(atol_, rtol_ * std::max(std::fabs(y[i]), std::fabs(y_new[i])));
      most = std::max(most, std::fabs(v[i]) / allowed);
    }
    return most;
  }

  double first_step(const State& y, const State& rate, double longest) const {
    const double inverse = worst(rate, y, y) * std::pow(rtol_, 1 - power) / 0.8;
    return longest * inverse > 1 ? 1 / inverse : longest;
  }

  bool give_up(double t) {
    outcome_.diverged = true;
    std::ostringstream text;
    text << "no step is short enough for rtol " << rtol_ << " (t = " << t << " s)";
    outcome_.reason = text.str();
    return false;
  }

  void record_row(const State& y) {
    record(recorder_, y);
    ++next_row_;
  }

  // The rows due before `limit`, from the dense output of the step that began at t.
  template <class After>
  void record_before(double limit, double t, const After& after) {
    if (!recorder_) return;
    while (next_row_ < grid_.rows && grid_.time(next_row_) < limit) record_row(after(grid_.time(next_row_) - t));
  }

  Equations equations_;
  SampleGrid grid_;
  State start_;
  double rtol_;
  double atol_;
  std::optional<WallBounce> wall_;
  boost::numeric::odeint::runge_kutta_dopri5<State> dopri5_;
  Outcome outcome_;
  Recorder recorder_;
  long next_row_ = 0;
};

}  // namespace odeval::reference
