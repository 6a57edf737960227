// Suspensions: how stiff a motion bears them.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "engines/ode_rk4/motion.hpp"
#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

// Of the stiffness that Runge's method of the fourth order bears: what turns with the motion may grow by the rest until
// the next check.
constexpr double bearable = 0.72;
constexpr double six_digits = 1e-5;  // that the error tells
constexpr int steps_between_checks = 16;

/// The largest L = h W (h k + d) that Runge's method of the fourth order bears, and all below it, of a spring of that
/// ERP: both roots z of z^2 + (1 - ERP) L z + ERP L = 0 are to keep |1 + z + z^2/2 + z^3/6 + z^4/24| <= 1. 2.78 of a
/// damper alone (ERP 0), 8 of a spring alone (ERP 1).
double stiffest(double erp) {
  using Complex = std::complex<double>;
  const auto grows = [erp](double large) {
    const double damping = (1 - erp) * large;
    const Complex root = std::sqrt(Complex(damping * damping - 4 * erp * large));
    for (const Complex z : {(-damping + root) / 2.0, (-damping - root) / 2.0}) {
      constexpr double rounding = 1e-12;
      if (std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))) > 1 + rounding) return true;
    }
    return false;
  };
  constexpr double grain = 0.01;
  constexpr int most = 800;
  int grains = 1;
  while (grains < most && !grows((grains + 1) * grain)) ++grains;
  return grains * grain;
}

}  // namespace

/// Runge's method follows u' = -W (h k + d) u, W the change of the springs' speeds by an impulse at each, joints kept,
/// where no eigenvalue of h W (h k + d) is too large for the least ERP among them: h k + d is 1 / CFM.
void Motion::check_springs(const State& state) {
  if (sprung_.empty() || steps_unchecked_++ % steps_between_checks != 0) return;
  struct Place {
    const Joint& joint;
    const Spring& spring;
    MotorLine line;
    double weight;  // the root of h / CFM
  };
  release();
  look(state);
  factor();
  std::vector<Place> places;
  double most = std::numeric_limits<double>::infinity();
  for (const std::size_t j : sprung_) {
    Joint& joint = mechanism_.joints[j];
    if (mechanism_.bodies[joint.a].asleep) continue;
    for (Spring& spring : joint.springs) {
      if (spring.bearable == 0) spring.bearable = bearable * stiffest(spring.erp);
      most = std::min(most, spring.bearable);
      places.push_back({joint, spring, line_of(joint, spring, state, turns_), std::sqrt(step_ / spring.cfm)});
    }
  }
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd answers(count, count);
  State moved = state;
  std::vector<Twist> change(state.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Place& from = places[static_cast<std::size_t>(k)];
    for (Twist& twist : change) twist = {Vector3d::Zero(), Vector3d::Zero()};
    push_along(from.joint, from.line, true, 1, change);
    for (Vector6& lambda : lambda_) lambda.setZero();
    solve_onto(change);
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i].twist = change[i];
    for (Eigen::Index i = 0; i < count; ++i) {
      const Place& to = places[static_cast<std::size_t>(i)];
      answers(i, k) = from.weight * to.weight * motor_speed(to.joint, to.line, true, moved);
    }
  }
  if (count == 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(answers);
  const double largest = modes.eigenvalues()[count - 1];
  if (largest <= most * (1 + six_digits)) return;
  Eigen::Index worst = 0;
  modes.eigenvectors().col(count - 1).cwiseAbs().maxCoeff(&worst);
  const auto& [joint, spring, line, weight] = places[static_cast<std::size_t>(worst)];
  refuse(name(joint) + " has a suspension that is stiffer than a step of " + shown(step_) +
             " s follows; raise its dParamSuspensionCFM to " + shown(spring.cfm * largest / most) +
             " or more, or set it to 0: rigid",
         mechanism_.bodies[joint.a].id, joint.id);
}

}  // namespace odeval::engine_rk4
