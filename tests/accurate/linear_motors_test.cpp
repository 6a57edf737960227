// Linear motors: closed forms with the axis fixed to the world and to a body, a limit of force that is reached and
// left, signs and the point they push at by the side of dWorldStep, and the order.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <vector>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepError;
using odeval::AccurateStepOptions;

AccurateStepOptions fixed_to(int rel) {
  AccurateStepOptions options;
  options.lmotor_axis_rel = [rel](dJointID, int) { return rel; };
  return options;
}

dJointID motor(const World& world, dBodyID a, dBodyID b, int rel, const Vector3d& axis, double velocity, double most) {
  const dJointID joint = dJointCreateLMotor(world.id, nullptr);
  dJointAttach(joint, a, b);
  dJointSetLMotorNumAxes(joint, 1);
  dJointSetLMotorAxis(joint, 0, rel, axis[0], axis[1], axis[2]);
  dJointSetLMotorParam(joint, dParamVel, velocity);
  dJointSetLMotorParam(joint, dParamFMax, most);
  return joint;
}

/// Along a slanted axis of the world, against a load that outgrows it and falls again: it pushes with its limit until
/// it has its velocity, holds it, gives way while the load is above its limit, catches up, and holds again.
void check_limit() {
  constexpr double mass = 2, most = 3, velocity = 0.5, slope = 4, h = 1e-3;
  const Vector3d axis = Vector3d(1, 2, 2) / 3;
  World world(Vector3d::Zero());
  const dBodyID body = world.box(mass, {0.3, 0.2, 0.1}, {0, 0, 0});
  motor(world, body, nullptr, 0, axis, velocity, most);
  AccurateStepOptions options = fixed_to(0);
  double start = 0;
  const auto load = [](double t) { return slope * std::min(std::max(t - 1, 0.0), std::max(3 - t, 0.0)); };
  options.forces = [&](double t) {
    const Vector3d force = -load(start + t) * axis;
    dBodyAddForce(body, force[0], force[1], force[2]);
  };
  AccurateStep step(world.id, world.space, options);
  // The load passes 3 N at 1.75 s on its way up, at 2.25 s on its way down.
  constexpr double there = mass * velocity / most, gives = 1 + most / slope, peak = 2, again = 3 - most / slope;
  // Of the speed, while it gives way: -slope/(2 m) (t - gives)^2, and the same mirrored about the peak.
  const auto lost = [](double t) {
    const double up = slope / (2 * mass);
    const double at_peak = up * (peak - gives) * (peak - gives);
    return t < peak ? up * (t - gives) * (t - gives) : 2 * at_peak - up * (again - t) * (again - t);
  };
  const double most_lost = lost(again);
  const double back = again + std::sqrt(2 * mass / slope * most_lost);  // the surplus grows as the load falls
  double error = 0, held = 0;
  for (int k = 1; k <= 3500; ++k) {
    start = (k - 1) * h;
    step(h);
    const double t = k * h, speed = vec(dBodyGetLinearVel(body)).dot(axis);
    double wanted = velocity;
    if (t < there) wanted = most / mass * t;
    if (t > gives && t <= again) wanted = velocity - lost(t);
    if (t > again && t < back) wanted = velocity - most_lost + slope / (2 * mass) * (t - again) * (t - again);
    error = std::max(error, std::fabs(speed - wanted));
    if ((t > there + h && t < gives - h) || t > back + h) held = std::max(held, std::fabs(speed - velocity));
  }
  std::printf("linear motor: off by %.2g m/s at its limit, %.2g where it holds\n", error, held);
  CHECK(back < 3);
  CHECK_BETWEEN(error, 0, 1e-9);
  CHECK_BETWEEN(held, 0, 1e-12);
}

/// Along an axis of a body that turns: what the body has across the axis grows evenly.
void check_turning_axis() {
  constexpr double velocity = 0.7, spin = 2, h = 1e-3;
  for (const int rel : {1, 2}) {  // ODE takes 2 for 1 where there is no second body
    World world(Vector3d::Zero());
    const dBodyID body = world.sphere(1.5, 0.2, {0, 0, 0});
    World::move(body, {velocity, 0.3, 0.1}, {0, 0, spin});
    motor(world, body, nullptr, rel, {1, 0, 0}, velocity, 100);
    AccurateStep step(world.id, world.space, fixed_to(rel));
    double error = 0;
    for (int k = 1; k <= 1000; ++k) {
      step(h);
      const double t = k * h;
      const Vector3d along(std::cos(spin * t), std::sin(spin * t), 0), across(-along[1], along[0], 0);
      const Vector3d wanted = velocity * along + (0.3 - velocity * spin * t) * across + Vector3d(0, 0, 0.1);
      error = std::max(error, (vec(dBodyGetLinearVel(body)) - wanted).norm());
    }
    std::printf("linear motor along a turning axis (rel %d): off by %.2g m/s\n", rel, error);
    CHECK_BETWEEN(error, 0, 1e-10);  // h^4 spin^5: 1e-13 a step at most, 5e-14 in all measured
  }
}

/// Two that spin, far apart, so that where the motor pushes matters.
struct Pair {
  World world{Vector3d::Zero()};
  dBodyID one = world.box(1, {0.3, 0.2, 0.1}, {0, 0, 0});
  dBodyID other = world.box(2, {0.1, 0.4, 0.2}, {1, 0.5, -0.3});
  Pair() {
    World::move(one, {0.2, 0, 0.1}, {1, -0.5, 2});
    World::move(other, {0, 0.3, 0}, {-1, 2, 0.4});
  }
};

/// Every way to attach it and every frame, with either step.
void check_by_world_step() {
  for (const int way : {0, 1, 2, 3}) {
    for (const int rel : {0, 1, 2}) {
      const auto after = [&](double h, bool accurate) {
        Pair pair;
        const dBodyID a = way == 1 ? nullptr : way == 3 ? pair.other : pair.one;
        const dBodyID b = way == 0 ? nullptr : way == 2 ? pair.other : pair.one;
        motor(pair.world, a, b, rel, Vector3d(1, 2, 2) / 3, 0.8, 1.5);
        if (accurate) {
          AccurateStep step(pair.world.id, pair.world.space, fixed_to(rel));
          for (int k = 0; k * h < 1 - h / 2; ++k) step(h);
        } else {
          for (int k = 0; k * h < 1 - h / 2; ++k) dWorldStep(pair.world.id, h);
        }
        return pair.world.state();
      };
      const auto ours = after(1e-3, true);
      const auto off = [&](double h) {
        const auto plain = after(h, false);
        double most = 0;
        for (std::size_t i = 0; i < ours.size(); ++i) most = std::max(most, std::fabs(ours[i] - plain[i]));
        return most;
      };
      const double coarse = off(1e-3), fine = off(2.5e-4);
      std::printf("linear motor, way %d, rel %d: dWorldStep is off by %.2g and %.2g\n", way, rel, coarse, fine);
      CHECK_BETWEEN(fine, 0, 2e-2);
      CHECK_BETWEEN(coarse / fine, 3, 5);  // at a quarter of the step: its limit is this motion
    }
  }
}

/// Speed at the point in the middle, along the axis.
double speed_between(const Pair& pair, const Vector3d& axis) {
  const Vector3d half = (vec(dBodyGetPosition(pair.other)) - vec(dBodyGetPosition(pair.one))) / 2;
  const Vector3d one = vec(dBodyGetLinearVel(pair.one)) + vec(dBodyGetAngularVel(pair.one)).cross(half);
  const Vector3d other = vec(dBodyGetLinearVel(pair.other)) - vec(dBodyGetAngularVel(pair.other)).cross(half);
  return axis.dot(one - other);
}

/// Holding between bodies that tumble: the velocity is kept, momenta too, and the motion is of the fourth order.
void check_order() {
  const Vector3d axis = Vector3d(1, 2, 2) / 3;
  for (const int rel : {0, 1, 2}) {
    const auto after = [&](double h) {
      Pair pair;
      motor(pair.world, pair.one, pair.other, rel, axis, 0.8, 1000);
      AccurateStep step(pair.world.id, pair.world.space, fixed_to(rel));
      const Vector3d momentum = pair.world.momentum(), angular = pair.world.angular_momentum();
      step(2e-3);  // gets it to its velocity
      for (int k = 0; k * h < 0.5 - h / 2; ++k) step(h);
      const Vector3d now = rel == 0   ? axis
                           : rel == 1 ? Vector3d(World::turn(pair.one) * axis)
                                      : Vector3d(World::turn(pair.other) * axis);
      CHECK_NEAR(speed_between(pair, now), 0.8, 1e-12);
      CHECK_NEAR((pair.world.momentum() - momentum).norm(), 0, 1e-12);
      CHECK_NEAR((pair.world.angular_momentum() - angular).norm(), 0, 1e-8);
      return pair.world.state();
    };
    const auto best = after(1e-3);
    const auto error = [&](double h) {
      const auto now = after(h);
      double most = 0;
      for (std::size_t i = 0; i < best.size(); ++i) most = std::max(most, std::fabs(now[i] - best[i]));
      return most;
    };
    const double coarse = error(1e-2), fine = error(5e-3);
    std::printf("linear motor that holds, rel %d: order %.2f, off by %.2g at h = 0.005\n", rel, order(coarse, fine, 2),
                fine);
    CHECK_BETWEEN(order(coarse, fine, 2), 3.5, 5);
  }
}

void check_refused() {
  World world(Vector3d::Zero());
  const dBodyID body = world.sphere(1, 0.1, {0, 0, 0});
  const dJointID joint = motor(world, body, nullptr, 0, {1, 0, 0}, 1, 0);
  AccurateStep idle(world.id, world.space);  // without a force it does nothing
  idle(1e-3);
  dJointSetLMotorParam(joint, dParamFMax, 1);
  CHECK_THROWS(idle(1e-3), AccurateStepError, "AccurateStepOptions::lmotor_axis_rel");
  for (const int rel : {-1, 3}) {
    CHECK_THROWS(AccurateStep(world.id, world.space, fixed_to(rel)), AccurateStepError, "is not 0, 1 or 2");
  }
  dJointSetLMotorParam(joint, dParamLoStop, 0);
  CHECK_THROWS(AccurateStep(world.id, world.space, fixed_to(0)), AccurateStepError, "has stops");
}

/// An axis set anew is noticed.
void check_change() {
  World world(Vector3d::Zero());
  const dBodyID body = world.sphere(1, 0.1, {0, 0, 0});
  const dJointID joint = motor(world, body, nullptr, 0, {1, 0, 0}, 1, 1e6);
  AccurateStep step(world.id, world.space, fixed_to(0));
  step(1e-3);
  CHECK_NEAR((vec(dBodyGetLinearVel(body)) - Vector3d(1, 0, 0)).norm(), 0, 1e-12);
  dJointSetLMotorAxis(joint, 0, 0, 0, 1, 0);
  step(1e-3);
  CHECK_NEAR((vec(dBodyGetLinearVel(body)) - Vector3d(1, 1, 0)).norm(), 0, 1e-12);
}

}  // namespace

int main() {
  check_limit();
  check_turning_axis();
  check_by_world_step();
  check_order();
  check_refused();
  check_change();
  return odeval::test::verdict();
}
