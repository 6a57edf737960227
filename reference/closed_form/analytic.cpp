#include "reference/closed_form/analytic.hpp"

#include <algorithm>
#include <boost/math/special_functions/ellint_rf.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "odeval/error.hpp"
#include "reference/closed_form/body_solution.hpp"
#include "reference/closed_form/jacobi.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/wall_bounce.hpp"

namespace odeval::reference {
namespace {

using boost::math::ellint_rf;
using std::numbers::pi;

}  // namespace

FreePendulum::FreePendulum(const Scenario& scenario, const State& start) : start_(start) {
  const Link& link = scenario.planar->links.at(0);
  const double c = link.centre_m();
  const double inertia = link.inertia_kgm2() + link.mass_kg * c * c;
  omega_ = std::sqrt(link.mass_kg * std::fabs(scenario.gravity) * c / inertia);

  // Sine and cosine of phi/2, phi = q + up pi/2. The smaller of the two follows from sin(phi) = up cos(q) with all
  // its digits, so that a start close to an equilibrium is that close.
  const double up = scenario.gravity < 0 ? -1 : 1;
  const double sin_phi = up * std::cos(start[0]);
  double sine = std::fabs(std::sin(start[0] / 2) + up * std::cos(start[0] / 2)) / std::numbers::sqrt2;
  double cosine = std::fabs(std::cos(start[0] / 2) - up * std::sin(start[0] / 2)) / std::numbers::sqrt2;
  (sine < cosine ? sine : cosine) = std::fabs(sin_phi) / (2 * std::max(sine, cosine));
  sine = std::copysign(sine, sin_phi);
  offset_ = 2 * std::atan2(sine, cosine);
  bottom_ = 2 * pi * std::round((start[0] - offset_ + up * pi / 2) / (2 * pi)) - up * pi / 2;

  const double half_speed = start[1] / 2;
  const double speed = std::fabs(half_speed);
  w_ = std::hypot(half_speed, omega_ * sine);
  rotates_ = speed >= omega_ * cosine;
  if (w_ == 0) return;  // hangs, or nothing moves it
  const double above = (omega_ * cosine - speed) * (omega_ * cosine + speed);
  complement_ = rotates_ ? -above / (w_ * w_) : above / (omega_ * omega_);
  quarter_ = complement_ > 0 ? ellint_rf(0.0, complement_, 1.0) : std::numeric_limits<double>::infinity();
  if (rotates_) {
    sense_ = half_speed < 0 ? -1 : 1;
    phase_ = phase_at(sense_ * sine, cosine, speed / w_ * (speed / w_));
  } else {
    phase_ = phase_at(omega_ * sine / w_, half_speed / w_, cosine * cosine);
  }
}

// F of an amplitude within +-pi, given by its sine and cosine; delta_squared = 1 - k^2 sine^2.
double FreePendulum::phase_at(double sine, double cosine, double delta_squared) const {
  const double within_quarter = sine * ellint_rf(cosine * cosine, delta_squared, 1.0);
  return cosine >= 0 ? within_quarter : std::copysign(2 * quarter_, sine) - within_quarter;
}

FreePendulum::State FreePendulum::at(double t_s) const {
  if (w_ == 0) return start_;
  if (rotates_) {
    const double u = phase_ + w_ * t_s;
    const double turns = std::isinf(quarter_) ? 0 : std::round(u / (2 * quarter_));
    const double rest = turns == 0 ? u : std::fma(-2 * quarter_, turns, u);
    const Jacobi f = jacobi(rest, complement_);
    return {bottom_ + sense_ * 2 * (turns * pi + std::atan2(f.sn, f.cn)), sense_ * 2 * w_ * f.dn};
  }
  const double u = std::remainder(phase_ + omega_ * t_s, 4 * quarter_);
  const Jacobi f = jacobi(u, complement_);
  return {bottom_ + 2 * std::atan2(w_ / omega_ * f.sn, f.dn), 2 * w_ * f.cn};
}

std::optional<FreePendulum::Passage> FreePendulum::passage(double q, bool rising) const {
  if (w_ == 0 || std::isinf(q)) return std::nullopt;
  const double phi = q - bottom_;
  // Energy: (phi'/2)^2 there, without cancellation between kinetic and potential energy.
  const double squared =
      start_[1] / 2 * (start_[1] / 2) + omega_ * omega_ * std::sin((start_[0] - q) / 2) * std::sin((offset_ + phi) / 2);
  if (!(squared >= 0)) return std::nullopt;
  const double half_speed = std::sqrt(squared);
  const double qd = rising ? 2 * half_speed : -2 * half_speed;
  if (rotates_) {
    if (rising != (sense_ > 0)) return std::nullopt;
    const double amplitude = sense_ * phi / 2;
    const double turns = std::round(amplitude / pi);
    if (turns != 0 && std::isinf(quarter_)) return std::nullopt;
    const double rest = amplitude - turns * pi;
    const double phase = phase_at(std::sin(rest), std::cos(rest), squared / (w_ * w_));
    return Passage{std::max(0.0, ((turns == 0 ? 0 : 2 * quarter_ * turns) + phase - phase_) / w_), qd};
  }
  const double sine = std::sin(phi / 2);
  const double cosine = std::cos(phi / 2);
  if (std::fabs(phi) >= pi) return std::nullopt;
  // It arrives with no speed to speak of and its weight turns it: it grazes the angle.
  if (std::fabs(qd) < rest_speed_rad_s && (sine > 0) == rising) return std::nullopt;
  const double w = std::hypot(half_speed, omega_ * sine);
  const double phase = phase_at(omega_ * sine / w, qd / 2 / w, cosine * cosine);
  const double ahead = phase - phase_;
  constexpr double rounding = 1e-13;
  return Passage{(ahead < -rounding ? ahead + 4 * quarter_ : std::max(0.0, ahead)) / omega_, qd};
}

ClosedFormPendulum::ClosedFormPendulum(const Scenario& scenario, double until_s) {
  const WallBounce wall(scenario);
  FreePendulum::State y = start_state<FreePendulum::State>(*scenario.planar);
  if (wall.rests(y)) {
    outcome_.at_rest_from = 0;
    rest_ = y;
    return;
  }
  for (double t = 0;;) {
    const FreePendulum& swing = pieces_.emplace_back(Piece{t, FreePendulum(scenario, y)}).swing;
    const auto high = swing.passage(wall.arc().high, true);
    const auto low = swing.passage(wall.arc().low, false);
    const bool upward = high && (!low || high->t_s < low->t_s);
    const auto& first = upward ? high : low;
    if (!first || t + first->t_s > until_s) return;
    t += first->t_s;
    y[1] = first->qd;
    if (!wall.bounce(t, {first->t_s, upward ? wall.arc().high : wall.arc().low, upward}, y, outcome_)) break;
  }
  rest_ = y;
}

FreePendulum::State ClosedFormPendulum::at(double t_s) const {
  if (outcome_.at_rest_from >= 0 && (t_s > outcome_.at_rest_from || pieces_.empty())) return rest_;
  const auto after = std::ranges::lower_bound(pieces_, t_s, {}, &Piece::begin_s);
  const Piece& piece = after == pieces_.begin() ? *after : *(after - 1);
  return piece.swing.at(t_s - piece.begin_s);
}

bool has_closed_form(const PlanarView& view) { return view.links.size() == 1; }

namespace {

class Analytic final : public Simulation {
 public:
  Analytic(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid), motion_(scenario, grid.time(grid.rows - 1)) {}

  SampleShape shape() const override { return {.coordinates = 1}; }

  Outcome run(Recorder recorder) override {
    Outcome outcome = motion_.outcome();
    for (long row = 0; row < grid_.rows; ++row) {
      const double t = grid_.time(row);
      if (outcome.diverged && t > outcome.impacts.back().t) break;
      const FreePendulum::State y = motion_.at(t);
      if (!finite(y)) {
        set_not_finite(outcome, y, t);
        return outcome;
      }
      record(recorder, y);
      outcome.steps = row;
    }
    return outcome;
  }

 private:
  SampleGrid grid_;
  ClosedFormPendulum motion_;
};

}  // namespace

std::unique_ptr<Simulation> make_analytic(const Scenario& scenario, const SampleGrid& grid) {
  if (!scenario.planar) return make_body_analytic(scenario, grid);
  if (!has_closed_form(*scenario.planar)) {
    throw UserError("method 'analytic' has no closed form for " + std::to_string(scenario.planar->links.size()) +
                    " links; it does one link");
  }
  return std::make_unique<Analytic>(scenario, grid);
}

}  // namespace odeval::reference
