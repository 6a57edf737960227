// Forces that change within a step: asked for at each stage they keep the order, sampled once a step they do not.
#include <cstdio>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepError;
using odeval::AccurateStepOptions;

/// A ball on a damped spring, driven: x'' = -k x - c x' + f cos(w t).
struct Oscillator : World {
  static constexpr double k = 40, c = 0.6, f = 3, w = 2;
  Oscillator() : World(Vector3d::Zero()), ball(sphere(1, 0.1, {1, 0, 0})) {}

  void push(double t) const {
    dBodyAddForce(ball, -k * dBodyGetPosition(ball)[0] - c * dBodyGetLinearVel(ball)[0] + f * std::cos(w * t), 0, 0);
  }
  /// Closed form: the steady motion and what dies away.
  static double at(double t) {
    const double stiff = k - w * w, lossy = c * w, size = stiff * stiff + lossy * lossy;
    const double a = f * stiff / size, b = f * lossy / size;
    const double decay = c / 2, rate = std::sqrt(k - decay * decay);
    const double x0 = 1 - a, v0 = -b * w;
    return a * std::cos(w * t) + b * std::sin(w * t) +
           std::exp(-decay * t) * (x0 * std::cos(rate * t) + (v0 + decay * x0) / rate * std::sin(rate * t));
  }
  dBodyID ball;
};

double spring_error(double h, bool at_stages, int of_order = 4) {
  Oscillator world;
  double start = 0;
  AccurateStepOptions options;
  options.order = of_order;
  if (at_stages) options.forces = [&](double t) { world.push(start + t); };
  AccurateStep step(world.id, world.space, options);
  for (; start < 2 - h / 2; start += h) {
    if (!at_stages) world.push(start);
    step(h);
  }
  return std::fabs(dBodyGetPosition(world.ball)[0] - Oscillator::at(start));
}

void check_order() {
  const double coarse = spring_error(8e-3, true), fine = spring_error(4e-3, true);
  const double sampled_coarse = spring_error(8e-3, false), sampled_fine = spring_error(4e-3, false);
  std::printf("driven spring: at stages %.3g %.3g m, order %.2f; sampled %.3g %.3g m, order %.2f\n", coarse, fine,
              order(coarse, fine, 2), sampled_coarse, sampled_fine, order(sampled_coarse, sampled_fine, 2));
  CHECK_BETWEEN(order(coarse, fine, 2), 3.8, 4.2);
  CHECK_BETWEEN(fine, 0, 1e-6);
  CHECK_BETWEEN(order(sampled_coarse, sampled_fine, 2), 0.8, 1.2);
  // Twelve stages, each asked at its own time.
  const double coarse_8 = spring_error(0.1, true, 8), fine_8 = spring_error(0.05, true, 8);
  std::printf("of order 8: %.3g %.3g m, order %.2f\n", coarse_8, fine_8, order(coarse_8, fine_8, 2));
  CHECK_BETWEEN(order(coarse_8, fine_8, 2), 7, 8.5);  // 7.45: at the coarse step the next term is a third of it
  CHECK_BETWEEN(fine_8, 0, 1e-10);                    // 1.4e-11
}

/// A controller turns a link on a hinge: its torque is between two bodies, its error against a run of much finer steps.
double controlled(double h, bool at_stages) {
  World world;
  const dBodyID one = world.box(1, {0.1, 0.1, 1}, {0, 0, -0.5});
  const dBodyID two = world.box(1, {0.1, 0.2, 1}, {0, 0, -1.5});
  world.hinge(one, nullptr, {0, 0, 0}, {1, 0, 0});
  const dJointID elbow = world.hinge(one, two, {0, 0, -1}, {0.6, 0.8, 0});
  const auto control = [&](double) {
    const double torque = -20 * (dJointGetHingeAngle(elbow) - 0.7) - 2 * dJointGetHingeAngleRate(elbow);
    dJointAddHingeTorque(elbow, torque);
  };
  AccurateStepOptions options;
  if (at_stages) options.forces = control;
  AccurateStep step(world.id, world.space, options);
  for (long k = 0; k < std::lround(0.5 / h); ++k) {
    if (!at_stages) control(0);
    step(h);
  }
  return dJointGetHingeAngle(elbow);
}

void check_controller() {
  const double wanted = controlled(2.5e-4, true);
  const double coarse = std::fabs(controlled(4e-3, true) - wanted), fine = std::fabs(controlled(2e-3, true) - wanted);
  const double sampled = std::fabs(controlled(2e-3, false) - wanted);
  std::printf("controller: at stages %.3g %.3g rad, order %.2f; sampled %.3g rad\n", coarse, fine,
              order(coarse, fine, 2), sampled);
  CHECK_BETWEEN(order(coarse, fine, 2), 3.7, 4.5);
  CHECK(sampled > 1000 * fine);
}

/// Forces added before the step act besides, and are gone after it, as are those of the stages.
void check_sum() {
  World world(Vector3d::Zero());
  const dBodyID ball = world.sphere(2, 0.1, {0, 0, 0});
  int calls = 0;
  AccurateStepOptions options;
  options.forces = [&](double t) {
    CHECK_NEAR(t, calls % 4 == 0 ? 0 : (calls % 4 == 3 ? 0.1 : 0.05), 1e-15);
    ++calls;
    dBodyAddForce(ball, 1, 0, 0);
  };
  AccurateStep step(world.id, world.space, options);
  dBodyAddForce(ball, 0, 4, 0);
  step(0.1);
  CHECK_EQUAL(calls, 4);
  CHECK_NEAR(dBodyGetLinearVel(ball)[0], 0.05, 1e-15);
  CHECK_NEAR(dBodyGetLinearVel(ball)[1], 0.2, 1e-15);
  CHECK_EQUAL(dBodyGetForce(ball)[0], 0.0);
  step(0.1);
  CHECK_NEAR(dBodyGetLinearVel(ball)[0], 0.1, 1e-15);
  CHECK_NEAR(dBodyGetLinearVel(ball)[1], 0.2, 1e-15);
}

/// An error within: poses, velocities and the user's own forces are as they were.
void check_failure() {
  World world;
  const dBodyID ball = world.sphere(2, 0.1, {0, 0, 0});
  bool bad = true;
  AccurateStepOptions options;
  options.forces = [&](double t) { dBodyAddForce(ball, bad && t > 0 ? std::nan("") : 1, 0, 0); };
  AccurateStep step(world.id, world.space, options);
  dBodyAddForce(ball, 0, 4, 0);
  const auto before = world.state();
  CHECK_THROWS(step(0.1), AccurateStepError, "the force on body 0 is not finite");
  CHECK(world.state() == before);
  CHECK_EQUAL(dBodyGetForce(ball)[0], 0.0);
  CHECK_EQUAL(dBodyGetForce(ball)[1], 4.0);
  bad = false;
  step(0.1);
  CHECK_NEAR(dBodyGetLinearVel(ball)[1], 0.2, 1e-15);
}

/// Springs and impacts together: a ball on a spring that bounces on a wall where the spring is slack, energy kept.
void check_bounce() {
  const auto drift = [](double h) {
    World world(Vector3d::Zero());
    const dBodyID ball = world.sphere(1, 0.1, {1.1, 0, 0});
    dCreatePlane(world.space, 1, 0, 0, 0.3);
    AccurateStepOptions options;
    options.contact = [](dxGeom*, dxGeom*) { return std::optional(odeval::Bounce{1}); };
    double last = 0;
    options.forces = [&](double t) {
      last = t;
      dBodyAddForce(ball, -30 * dBodyGetPosition(ball)[0], 0, 0);
    };
    AccurateStep step(world.id, world.space, options);
    const auto energy = [&] {
      const double x = dBodyGetPosition(ball)[0], v = dBodyGetLinearVel(ball)[0];
      return v * v / 2 + 15 * x * x;
    };
    const double start = energy();
    std::size_t impacts = 0;
    for (long k = 0; k < std::lround(3 / h); ++k) {
      step(h);
      impacts += step.touches().size();
      CHECK_NEAR(last, h, 1e-15);  // counted from the step's start, not from the impact
    }
    CHECK(impacts > 3);
    return std::fabs(energy() - start);
  };
  const double coarse = drift(8e-3), fine = drift(4e-3);
  std::printf("bouncing on a spring: energy %.3g %.3g J, order %.2f\n", coarse, fine, order(coarse, fine, 2));
  CHECK_BETWEEN(order(coarse, fine, 2), 3.5, 6);
}

}  // namespace

int main() {
  check_order();
  check_controller();
  check_sum();
  check_failure();
  check_bounce();
  return odeval::test::verdict();
}
