#include "reference/tree/tree_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace odeval::reference {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// As in reference_solution.cpp.
constexpr double gain = 2;
constexpr double bias = 0.2;
constexpr double known_rad = 1;  // beyond, the bound never falls
constexpr double lost_rad = 1e6;

/// How far a stride may reach beside the fastest that the motion does: what a transition of third order leaves out is
/// 0.25^4 / 24, and its swings lose as much of their size.
constexpr double reach_of_transition = 0.25;

/// Rows of a body in the matrix of slopes_of_bodies: place, attitude and spin, three each.
constexpr Eigen::Index rows = 9;

/// Central differences of a function from states to vectors: column j is its slope along the state's number j.
template <class Function>
Eigen::MatrixXd differences(const Eigen::VectorXd& y, Eigen::Index size, Function&& difference) {
  Eigen::MatrixXd slopes(size, y.size());
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    const double off = std::cbrt(epsilon) * std::fmax(1, std::fabs(y[j]));
    Eigen::VectorXd above = y;
    Eigen::VectorXd below = y;
    above[j] += off;
    below[j] -= off;
    slopes.col(j) = difference(above, below) / (above[j] - below[j]);
  }
  return slopes;
}

/// The small turn that leads from one attitude to another, as a rotation vector in the world: (R S^T - S R^T) / 2.
Vec3 turn_between(const Rotation& to, const Rotation& from) {
  const auto product = [&](std::size_t i, std::size_t j) {
    return dot({to[3 * i], to[3 * i + 1], to[3 * i + 2]}, {from[3 * j], from[3 * j + 1], from[3 * j + 2]});
  };
  return {(product(2, 1) - product(1, 2)) / 2, (product(0, 2) - product(2, 0)) / 2,
          (product(1, 0) - product(0, 1)) / 2};
}

Eigen::VectorXd vector(const std::vector<double>& state) {
  return Eigen::Map<const Eigen::VectorXd>(state.data(), static_cast<Eigen::Index>(state.size()));
}

BodyUncertainty larger(const BodyUncertainty& a, const BodyUncertainty& b) {
  return {std::fmax(a.position_m, b.position_m), std::fmax(a.turn_rad, b.turn_rad),
          std::fmax(a.spin_rad_s, b.spin_rad_s)};
}

}  // namespace

TreeUncertainty::TreeUncertainty(const TreeEquations& equations, const Mechanism& mechanism, Tolerances tolerances,
                                 double start_error)
    : equations_(equations),
      chart_(equations.chart(equations.start())),
      mechanism_(mechanism),
      tolerances_(tolerances) {
  const Vector y = start_ = vector(chart_->small(equations.start()));
  const Vector error = (epsilon * (1 + y.array().abs()) + start_error).matrix();
  independent_ = aligned_ = Matrix(error.array().square().matrix().asDiagonal());
  strides_.push_back({0, bound(y)});
}

void TreeUncertainty::follow(TreeMotion& tight, TreeMotion& loose) {
  ++steps_;
  if (tight.change() || tight.end() - strides_.back().end_s >= longest_s_) finish(tight, loose);
  if (tight.change()) pass(tight);
}

void TreeUncertainty::finish(TreeMotion& tight, TreeMotion& loose) {
  const double t = tight.end();
  if (t <= strides_.back().end_s) return;
  if (strides_.back().bound.turn_rad >= lost_rad) {  // nothing is known, and never will be
    strides_.push_back({t, strides_.back().bound});
    return;
  }
  const Vector y = vector(chart_->small(tight.at(t)));
  stride(y, t, tight.grips());
  while (loose.end() < t) loose.advance();
  // Between a change of the one and that of the other they differ by it, which pass() bounds.
  if (tight.changes() - (tight.change() && tight.change()->cause ? 1 : 0) ==
      loose.changes() - (loose.change() && loose.change()->cause ? 1 : 0)) {
    compare(y, vector(chart_->small(loose.at(t))));
  }
  BodyUncertainty now = bound(y);
  if (strides_.back().bound.turn_rad > known_rad) now = larger(now, strides_.back().bound);
  strides_.push_back({t, now});
  steps_ = 0;
}

/// Carries both ellipsoids on and adds the errors of the steps.
void TreeUncertainty::stride(const Vector& y, double end_s, const Grips& grips) {
  if (fresh_) slopes_ = slopes(strides_.back().end_s, start_, grips);
  fresh_ = false;
  const Matrix before = std::exchange(slopes_, slopes(end_s, y, grips));
  const Matrix step = (end_s - strides_.back().end_s) / 2 * (before + slopes_);
  const Matrix one = Matrix::Identity(y.size(), y.size());
  const Matrix map = one + step * (one + step / 2 * (one + step / 3));
  const double fastest = std::sqrt((slopes_ * slopes_).cwiseAbs().colwise().sum().maxCoeff());  // 1/s
  longest_s_ = fastest > 0 ? reach_of_transition / fastest : 0;

  const Vector error = step_error(y);
  independent_ = map * independent_ * map.transpose();
  independent_.diagonal() += steps_ * error.cwiseAbs2();
  aligned_ = map * aligned_ * map.transpose();
  // The ellipsoid about the sums of both, as Ellipsoid::add_aligned has it.
  const Vector added = steps_ * error;
  const double ratio = std::sqrt(added.squaredNorm() / aligned_.trace());
  aligned_ *= 1 + ratio;
  aligned_.diagonal() += (1 + 1 / ratio) * added.cwiseAbs2();
}

void TreeUncertainty::compare(const Vector& tight, const Vector& loose) {
  const Vector reach = independent_.diagonal().cwiseSqrt();
  factor_ = std::fmax(factor_, ((tight - loose).cwiseAbs().cwiseQuotient(reach)).maxCoeff() / gain);
}

/// Carries the errors through a change: S = R_y + (f+ - R_y f-) n^T / (n f-), of the jump R and the cause n (y), where
/// f is the slope before and after.
void TreeUncertainty::pass(const TreeMotion& tight) {
  const TreeMotion::Change& change = *tight.change();
  const Vector before = vector(chart_->small(change.before));
  start_ = vector(change.chart->small(change.after));
  fresh_ = true;
  const auto jumped = [&](const Vector& y) { return vector(change.chart->small(change.jump(whole(y)))); };
  Matrix map = differences(before, before.size(), [&](const Vector& above, const Vector& below) -> Vector {
    return jumped(above) - jumped(below);
  });
  Vector located = Vector::Zero(before.size());  // what rounding of the time leaves
  if (change.cause) {
    Vector slope_before(before.size()), slope_after(before.size());
    equations_.slope(*chart_, change.t, before.data(), slope_before.data(), tight.grips());
    equations_.slope(*change.chart, change.t, start_.data(), slope_after.data(), change.grips);
    const Vector normal =
        differences(before, 1, [&](const Vector& above, const Vector& below) {
          return Vector::Constant(1, change.cause(change.t, whole(above)) - change.cause(change.t, whole(below)))
              .eval();
        }).transpose();
    const double dt = std::cbrt(epsilon) * std::fmax(1, change.t);
    const double in_time =
        (change.cause(change.t + dt, change.before) - change.cause(change.t - dt, change.before)) / dt / 2;
    const double rate = normal.dot(slope_before) + in_time;
    const Vector jump = slope_after - map * slope_before;
    const double unknown_s =
        (factor_ * std::sqrt(normal.dot(independent_ * normal)) + bias * std::sqrt(normal.dot(aligned_ * normal))) /
            std::fabs(rate) +
        4 * epsilon * change.t;
    jumps_.push_back({change.t, unknown_s, spin_jump(change)});
    map += jump * normal.transpose() / rate;
    located = 4 * epsilon * change.t * jump;
  }
  chart_ = change.chart;
  // What holds has its speed, and what is held by a stop its way, whatever they were before.
  for (std::size_t i = 0; i < change.grips.size(); ++i) {
    const Grip& grip = change.grips[i];
    if (!grip.holds || !chart_->trivial()) continue;
    map.row(static_cast<Eigen::Index>(equations_.axes()[i].speed)).setZero();
    if (std::isinf(grip.least) || std::isinf(grip.most)) {
      map.row(static_cast<Eigen::Index>(equations_.axes()[i].way)).setZero();
    }
  }
  independent_ = map * independent_ * map.transpose() + located * located.transpose();
  aligned_ = map * aligned_ * map.transpose();
  independent_.diagonal() += step_error(start_).cwiseAbs2();
  aligned_.diagonal() += step_error(start_).cwiseAbs2();
  if (!change.passage) {
    strides_.push_back({change.t, larger(bound(start_), strides_.back().bound)});
    return;
  }
  const Vector unsure = vector(change.passage->unsure_end);
  independent_.diagonal() += unsure.cwiseAbs2();
  aligned_.diagonal() += unsure.cwiseAbs2();
  BodyUncertainty within = larger(bound(start_), strides_.back().bound);
  within.position_m += change.passage->unsure.position_m;
  within.turn_rad += change.passage->unsure.turn_rad;
  within.spin_rad_s += change.passage->unsure.spin_rad_s;
  strides_.push_back({change.end(), within});
}

/// By how much the worst body's spin changes at once.
double TreeUncertainty::spin_jump(const TreeMotion::Change& change) const {
  std::vector<BodyState> before(mechanism_.bodies.size());
  std::vector<BodyState> after(mechanism_.bodies.size());
  equations_.show(change.before.data(), before);
  equations_.show(change.after.data(), after);
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) most = std::fmax(most, distance(before[i].spin, after[i].spin));
  return most;
}

/// The state that a small one stands for.
std::vector<double> TreeUncertainty::whole(const Vector& y) const {
  std::vector<double> state;
  if (!chart_->find(y.data(), state)) state.assign(equations_.size(), std::numeric_limits<double>::quiet_NaN());
  return state;
}

void TreeUncertainty::show(const Vector& y, std::vector<BodyState>& bodies) const {
  equations_.show(whole(y).data(), bodies);
}

TreeUncertainty::Matrix TreeUncertainty::slopes(double t, const Vector& y, const Grips& grips) const {
  Vector high(y.size());
  Vector low(y.size());
  return differences(y, y.size(), [&](const Vector& above, const Vector& below) -> Vector {
    equations_.slope(*chart_, t, above.data(), high.data(), grips);
    equations_.slope(*chart_, t, below.data(), low.data(), grips);
    return high - low;
  });
}

TreeUncertainty::Matrix TreeUncertainty::slopes_of_bodies(const Vector& y) const {
  const std::size_t bodies = mechanism_.bodies.size();
  std::vector<BodyState> high(bodies);
  std::vector<BodyState> low(bodies);
  Vector all(rows * static_cast<Eigen::Index>(bodies));
  return differences(y, all.size(), [&](const Vector& above, const Vector& below) -> const Vector& {
    show(above, high);
    show(below, low);
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < bodies; ++i) {
      for (const Vec3& part : {high[i].position - low[i].position, turn_between(high[i].rotation, low[i].rotation),
                               high[i].spin - low[i].spin}) {
        for (const double value : part) all[row++] = value;
      }
    }
    return all;
  });
}

/// What one step may add to each number of the state.
TreeUncertainty::Vector TreeUncertainty::step_error(const Vector& y) const {
  return ((tolerances_.rtol + epsilon) * y.array().abs() + tolerances_.atol).matrix();
}

/// Of the bodies where the state is y: the ellipsoids, what a step adds inside it, and the rounding of showing it.
BodyUncertainty TreeUncertainty::bound(const Vector& y) const {
  const Matrix shown = slopes_of_bodies(y);
  const Vector own = step_error(y);
  std::vector<BodyState> states(mechanism_.bodies.size());
  show(y, states);
  // Of showing it, and of closing loops; the least singular value is seldom less than a third of the least pivot.
  constexpr double few = 8;
  const double rounding = epsilon * (few + (chart_->trivial() ? 0 : 3 * chart_->closure(whole(y)).gain));
  BodyUncertainty worst;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto reach = [&](Eigen::Index part, double size) {
      const auto of = shown.middleRows(rows * static_cast<Eigen::Index>(i) + 3 * part, 3);
      const auto along = [&](const Matrix& errors) { return std::sqrt((of * errors * of.transpose()).trace()); };
      return std::fmin(factor_ * along(independent_) + bias * along(aligned_) + (of * own.asDiagonal()).norm() +
                           rounding * (1 + size),
                       lost_rad);
    };
    worst = larger(worst, {reach(0, length(states[i].position)), reach(1, 0), reach(2, length(states[i].spin))});
  }
  return worst;
}

BodyUncertainty TreeUncertainty::at(double t) const {
  const auto later = std::ranges::lower_bound(strides_, t, {}, &Stride::end_s);
  BodyUncertainty bound = later->bound;
  if (later != strides_.begin()) bound = larger(bound, (later - 1)->bound);
  for (const Jump& jump : jumps_) {
    if (std::fabs(t - jump.t) <= jump.unknown_s) bound.spin_rad_s += jump.spin_rad_s;
  }
  return bound;
}

}  // namespace odeval::reference
