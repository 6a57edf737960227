#include "reference/planar/reference_solution.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>

#include "reference/planar/cvode.hpp"
#include "reference/planar/cvode_motion.hpp"
#include "reference/planar/error_spread.hpp"
#include "reference/planar/long_chain_reference.hpp"

namespace odeval::reference {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Follows the tight run piece by piece and bounds its angle error.
template <std::size_t N>
class Uncertainty {
 public:
  using Motion = CvodeMotion<N>;
  using State = typename Motion::State;

  Uncertainty(const Scenario& scenario, Tolerances tolerances) : motion_(scenario), tolerances_(tolerances) {}

  /// Takes in the piece that `tight` has just made; moves `loose` along.
  void follow(const Motion& tight, Motion& loose) {
    begin_ = end_;
    if (tight.phase() == Motion::Phase::flight) {
      fly(tight, loose);
      if constexpr (N == 1) touch(tight);
      if constexpr (N == 2) {
        if (tight.struck()) touch_of_ball(tight);
      }
    }
    if constexpr (N == 1) {
      if (tight.phase() == Motion::Phase::hop) hop(tight);
    }
    if (tight.phase() == Motion::Phase::rest) begin_ = end_ = tight.stop_uncertainty() + tight.rest_height();
  }

  /// Of any sample in the piece, rad.
  double angle(const State& y) const {
    double own = 0;
    for (std::size_t i = 0; i < N; ++i) own = std::max(own, step_error(y[i]));
    return std::max(begin_, end_) + own;
  }
  /// Of the impact that ends the piece, s.
  double impact_s() const { return impact_s_; }

 private:
  // The half and the fifth of the bound (reference_solution.hpp).
  static constexpr double gain = 2;
  static constexpr double bias = 0.2;

  static constexpr double known_rad = 1;  // beyond, the bound never falls
  static constexpr double lost_rad = 1e6;

  /// What one step may add to a component of that size.
  double step_error(double value) const { return (tolerances_.rtol + epsilon) * std::fabs(value) + tolerances_.atol; }

  void fly(const Motion& tight, Motion& loose) {
    if (end_ >= lost_rad) return;
    const double h = tight.end() - tight.begin();
    const auto map = motion_.transition(tight.at(tight.begin() + h / 2), h);
    const State y = tight.at(tight.end());
    State error;
    std::transform(y.begin(), y.end(), error.begin(), [this](double value) { return step_error(value); });
    independent_.carry(map);
    independent_.add_independent(error);
    aligned_.carry(map);
    aligned_.add_aligned(error);

    while (loose.end() < tight.end()) loose.advance();
    const State other = loose.at(tight.end());
    for (std::size_t i = 0; i < N; ++i) {
      factor_ = std::max(factor_, std::fabs(y[i] - other[i]) / independent_.reach(i) / gain);
    }
    update();
  }

  template <class Direction>
  double bound(const Direction& direction) const {
    return factor_ * independent_.reach(direction) + bias * aligned_.reach(direction);
  }

  void update() {
    const double before = end_;
    end_ = 0;
    for (std::size_t i = 0; i < N; ++i) end_ = std::max(end_, bound(i));
    end_ = std::min(end_, lost_rad);
    if (before > known_rad) end_ = std::max(end_, before);
  }

  /// An impact at the end of a flight, or a turn so near the wall that it may have been one.
  void touch(const Motion& tight) {
    if (!tight.struck() && !tight.turn_height()) return;
    const State y = tight.at(tight.end());
    const double pull = tight.acceleration(y[0]);
    // The link turns, or would turn, at q - qd^2 / 2 qdd. How far that is off leaves the speed at the wall unknown.
    const double unknown_height = pull == 0 ? 0 : bound(State{1, -y[1] / pull}) + tight.stop_uncertainty();
    const double unknown_speed = std::sqrt(2 * std::fabs(pull) * unknown_height);
    const double both_ways = 1 + tight.restitution();
    if (tight.struck()) {
      const Impact& impact = tight.impacts().back();
      const double rate = std::copysign(std::max(std::fabs(impact.qd_before), unknown_speed), impact.qd_before);
      const bool uncertain = std::fabs(impact.qd_before) < 2 * unknown_speed;
      impact_s_ = (end_ + tight.stop_uncertainty()) / std::fabs(rate) + time_rounding(tight.end());
      independent_.add_independent({tight.stop_uncertainty() / factor_, 0});
      independent_.carry(saltation(tight.restitution(), rate, pull));
      aligned_.carry(saltation(tight.restitution(), rate, pull));
      if (uncertain) independent_.add_independent({0, both_ways * unknown_speed / factor_});
    } else if (*tight.turn_height() < 2 * unknown_height) {
      // A graze that may have been a touch, as fast as a fall from the stop to the turn, early or late in the step.
      const double fall = unknown_height + std::max(-*tight.turn_height(), 0.0);
      const double change = both_ways * std::sqrt(2 * std::fabs(pull) * fall) / factor_;
      independent_.add_together({change * (tight.end() - tight.begin()), change});
      independent_.add_together({0, change});
    }
    update();
  }

  /// An impact of a ball at the end of a flight. A touch so slow that it may have been none leaves its speed unknown.
  void touch_of_ball(const Motion& tight) requires(N == 2) {
    const BallWall& wall = *tight.balls();
    const State y = tight.at(tight.end());
    const Impact& impact = tight.impacts().back();
    const auto ball = static_cast<std::size_t>(*impact.link - 1);
    std::array<bool, 2> at_wall{};
    at_wall[ball] = true;
    for (const Impact& other : tight.impacts()) {
      if (other.t == impact.t) at_wall[static_cast<std::size_t>(*other.link - 1)] = true;
    }
    const auto slope = wall.slope(ball, y);
    const double unknown_distance = bound(State{slope[0], slope[1], 0, 0});
    const double unknown_speed = std::sqrt(2 * std::fabs(wall.pull(ball, y)) * unknown_distance);
    impact_s_ = unknown_distance / std::max(std::fabs(impact.qd_before), unknown_speed) + time_rounding(tight.end());
    const auto map = saltation(wall, ball, at_wall, y);
    independent_.carry(map);
    aligned_.carry(map);
    update();
  }

  /// Hops differ from the true ones in time only: by what was unknown when they began, and by a part of the time since.
  void hop(const Motion& tight) {
    const double speed = std::fabs(tight.impacts().back().qd_before);
    if (hopping_since_ < 0) {
      hopping_since_ = tight.begin();
      late_ = end_ / speed;
      drift_ = bound(std::size_t{1}) / speed + Motion::hop_bend;
    }
    const double late = late_ + drift_ * (tight.end() - hopping_since_);
    const double height = speed * speed / (2 * std::fabs(tight.acceleration(tight.impacts().back().q1)));
    begin_ = end_ = std::min(speed * late, height) + tight.stop_uncertainty();
    impact_s_ = late + time_rounding(tight.end());
  }

  static double time_rounding(double t) { return 4 * epsilon * t; }

  FreeMotion<N> motion_;
  Tolerances tolerances_;  // of the tight run
  Ellipsoid<2 * N> independent_;
  Ellipsoid<2 * N> aligned_;
  double factor_ = 1;
  double begin_ = 0;  // rad, at the ends of the piece
  double end_ = 0;
  double impact_s_ = 0;
  double hopping_since_ = -1;
  double late_ = 0;
  double drift_ = 0;
};

/// The force of joint i on link i by Newton's law: all masses from link i on, as they are accelerated, and their
/// weight. `slope` is dy/dt.
template <std::size_t N>
std::array<Vec3, N> joint_forces(const Scenario& scenario, const std::array<double, 2 * N>& y,
                                 const std::array<double, 2 * N>& slope) {
  using Equations = ChainEquations<double, N>;
  const PlanarView& view = *scenario.planar;
  typename Equations::Angles angle, rate, unused, acceleration;
  Equations::absolute(y, angle, rate);
  Equations::absolute(slope, unused, acceleration);

  std::array<std::array<double, 2>, N> inertial;  // mass times acceleration and weight, along horizontal and up
  std::array<double, 2> hinge{0, scenario.gravity};
  for (std::size_t i = 0; i < N; ++i) {
    const Link& link = view.links[i];
    // Of a point at s against the near hinge: s (a'' e_normal - a'^2 e_along).
    const std::array<double, 2> along{std::cos(angle[i]), std::sin(angle[i])};
    const std::array<double, 2> normal{-along[1], along[0]};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double turning = acceleration[i] * normal[axis] - rate[i] * rate[i] * along[axis];
      inertial[i][axis] = link.mass_kg * (hinge[axis] + link.centre_m() * turning);
      hinge[axis] += link.length_m * turning;
    }
  }

  const PlanarFrame& frame = view.frame;
  std::array<Vec3, N> forces;
  std::array<double, 2> sum{0, 0};
  for (std::size_t i = N; i-- > 0;) {
    for (std::size_t axis = 0; axis < 2; ++axis) sum[axis] += inertial[i][axis];
    for (std::size_t k = 0; k < 3; ++k) forces[i][k] = sum[0] * frame.horizontal[k] + sum[1] * frame.up[k];
  }
  return forces;
}

template <std::size_t N>
Reference solve(const Scenario& scenario, const SampleGrid& grid, Tolerances tight_run, Tolerances loose_run) {
  const auto rows = static_cast<std::size_t>(grid.rows);
  Reference reference;
  Trace& trace = reference.trace;
  for (Column* column : {&trace.t, &trace.kinetic, &trace.potential, &reference.uncertainty_q}) column->reserve(rows);
  trace.q.assign(N, Column(rows));
  trace.qd.assign(N, Column(rows));
  trace.gap.assign(rows, 0.0);
  trace.out_of_plane.assign(rows, 0.0);
  trace.contacts.assign(rows, 0.0);
  reference.joint_force.assign(N, {Column(rows), Column(rows), Column(rows)});

  CvodeMotion<N> tight(scenario, tight_run);
  CvodeMotion<N> loose(scenario, loose_run);
  Uncertainty<N> uncertainty(scenario, tight_run);
  reference.impacts = tight.impacts();  // at t = 0
  reference.impact_uncertainty_s.assign(reference.impacts.size(), 0.0);
  const double last = grid.time(grid.rows - 1);
  for (std::size_t k = 0; k < rows; ++k) {
    const double t = grid.time(static_cast<long>(k));
    while (tight.end() < t) {
      tight.advance();
      uncertainty.follow(tight, loose);
      if (tight.struck() && tight.end() <= last) {
        reference.impacts.push_back(tight.impacts().back());
        reference.impact_uncertainty_s.push_back(uncertainty.impact_s());
      }
    }
    const auto y = tight.at(t);
    trace.t.push_back(t);
    for (std::size_t i = 0; i < N; ++i) {
      trace.q[i][k] = y[i];
      trace.qd[i][k] = y[N + i];
    }
    trace.kinetic.push_back(tight.equations().kinetic(y));
    trace.potential.push_back(tight.equations().potential(y));
    reference.uncertainty_q.push_back(k == 0 ? 0 : uncertainty.angle(y));
    auto slope = y;
    tight.equations()(y, slope);
    if (tight.at_rest_from() >= 0 && t >= tight.at_rest_from()) {
      trace.contacts[k] = 1;
      slope = {};
    }
    const auto forces = joint_forces<N>(scenario, y, slope);
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) reference.joint_force[i][axis][k] = forces[i][axis];
    }
  }
  if (tight.at_rest_from() <= last) reference.at_rest_from = tight.at_rest_from();
  reference.origin = origin_of(tight_run, loose_run);
  return reference;
}

}  // namespace

std::string origin_of(Tolerances tight, Tolerances loose) {
  std::ostringstream text;
  text << "CVODE " << CvodeSolver::version() << " Adams, rtol " << tight.rtol << ", atol " << tight.atol
       << "; uncertainty from a second run at rtol " << loose.rtol;
  return text.str();
}

Reference solve_reference(const Scenario& scenario, const SampleGrid& grid) {
  return solve_reference(scenario, grid, tight_tolerances, loose_tolerances);
}

Reference solve_reference(const Scenario& scenario, const SampleGrid& grid, Tolerances tight, Tolerances loose) {
  if (scenario.planar->links.size() > 2) {
    Reference reference = solve_long_chain(scenario, grid, tight, loose);
    reference.origin = origin_of(tight, loose);
    return reference;
  }
  return with_equations(scenario, [&]<std::size_t N>(const ChainEquations<double, N>&) {
    return solve<N>(scenario, grid, tight, loose);
  });
}

}  // namespace odeval::reference
