// Impacts of the accurate step: located, shared by all bodies, several at once, many in one step, rest.
#include <cstdio>

#include "engine_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepOptions;
using odeval::Bounce;
using odeval::Touch;

constexpr double g = 9.81;

AccurateStepOptions bouncing(double restitution) {
  AccurateStepOptions options;
  options.contact = [restitution](dxGeom*, dxGeom*) { return std::optional(Bounce{restitution}); };
  return options;
}

struct TimedTouch {
  double t;
  Touch touch;
};

std::vector<TimedTouch> run(AccurateStep& step, double until, double h) {
  std::vector<TimedTouch> all;
  for (long k = 0; k < std::lround(until / h); ++k) {
    step(h);
    for (const Touch& touch : step.touches()) all.push_back({static_cast<double>(k) * h + touch.t, touch});
  }
  return all;
}

/// A ball dropped on a plane: parabolas, so every step is exact and so is each impact's time.
void check_ball(double h) {
  constexpr double height = 1.3, radius = 0.2, e = 0.8;
  World world;
  const dBodyID ball = world.sphere(2, radius, {0.1, 0.2, height + radius});
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, bouncing(e));
  const auto touches = run(step, 3, h);
  double t = std::sqrt(2 * height / g);
  double speed = g * t;
  std::size_t k = 0;
  for (; t < 3 && k < touches.size(); ++k) {
    // Located to an overlap of 1e-12 m, so early or late by that over the speed; such errors add up.
    CHECK_NEAR(touches[k].t, t, 1e-11);
    CHECK_NEAR(touches[k].touch.approach, speed, 1e-10);
    CHECK_NEAR(touches[k].touch.departure, e * speed, 1e-10);
    speed *= e;
    t += 2 * speed / g;
  }
  CHECK_EQUAL(k, touches.size());
  CHECK(t > 3);  // none was missed
  CHECK(k > 4);
  CHECK_NEAR(dBodyGetPosition(ball)[0], 0.1, 1e-15);
}

/// All bounces: the time they come to rest, and rest without jitter.
void check_rest() {
  constexpr double height = 0.5, radius = 0.1, e = 0.5, h = 1e-3;
  World world;
  const dBodyID ball = world.sphere(1, radius, {0, 0, height + radius});
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, bouncing(e));
  const auto touches = run(step, 2, h);
  // First fall, then twice the rise of each bounce: t0 (1 + 2 e / (1 - e)).
  const double ends = std::sqrt(2 * height / g) * (1 + 2 * e / (1 - e));
  CHECK(!touches.empty());
  if (touches.empty()) return;
  // The bounces below the speed of rest (1 mm/s) that are left out last 2 v / g / (1 - e) together.
  CHECK_BETWEEN(touches.back().t, ends - 4 * 1e-3 / g / (1 - e) - h, ends + h);
  for (int k = 0; k < 500; ++k) {
    step(h);
    CHECK_NEAR(dBodyGetPosition(ball)[2], radius, 1e-11);
    CHECK_EQUAL(dBodyGetLinearVel(ball)[2], 0.0);
  }
  // Pulled away, it goes; thrown down, it bounces.
  dBodySetLinearVel(ball, 0, 0, 2);
  step(h);
  CHECK_NEAR(dBodyGetPosition(ball)[2], radius + 2 * h - g * h * h / 2, 1e-11);
  const auto again = run(step, 0.6, h);
  CHECK(!again.empty());
  if (!again.empty()) CHECK_NEAR(again.front().touch.approach, 2, 1e-9);
}

/// A box that falls flat: four corners at once share one impulse, and it stays level.
void check_flat_box() {
  World world;
  const dBodyID box = world.box(3, {1, 0.6, 0.2}, {0, 0, 1.1});
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, bouncing(0.7));
  const auto touches = run(step, 1, 1e-3);
  CHECK(!touches.empty());
  if (touches.empty()) return;
  const double t = std::sqrt(2 * 1.0 / g);
  CHECK_NEAR(touches[0].t, t, 1e-11);
  CHECK_EQUAL(touches[0].touch.contacts, std::size_t{4});
  CHECK_NEAR(touches[0].touch.departure, 0.7 * g * t, 1e-10);
  CHECK_NEAR(vec(dBodyGetAngularVel(box)).norm(), 0, 1e-12);
}

/// Two balls that meet in the air: momentum kept, Newton's law between them.
void check_two_balls() {
  World world(Vector3d::Zero());
  const dBodyID one = world.sphere(1, 0.1, {-1, 0, 0});
  const dBodyID two = world.sphere(3, 0.1, {1, 0.05, 0});
  World::move(one, {2, 0, 0}, {0, 0, 0});
  World::move(two, {-1, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space, bouncing(1));
  const double energy = world.energy();
  const Vector3d momentum = world.momentum();
  const auto touches = run(step, 1, 0.01);
  CHECK_EQUAL(touches.size(), std::size_t{1});
  if (touches.empty()) return;
  // Centres 0.2 m apart: 3 t = 2 - sqrt(0.2^2 - 0.05^2).
  CHECK_NEAR(touches[0].t, (2 - std::sqrt(0.04 - 0.0025)) / 3, 1e-11);
  CHECK_NEAR((world.momentum() - momentum).norm(), 0, 1e-14);
  CHECK_NEAR(world.energy(), energy, 1e-11);
}

/// A chain hits the ground with its last link: every body feels it, joints keep, energy of an elastic impact stays.
void check_chain_hits() {
  World world;
  dBodyID before = nullptr;
  for (int i = 0; i < 3; ++i) {
    const dBodyID link = world.box(1, {0.6, 0.1, 0.1}, {0.3 + 0.6 * i, 0, 1});
    world.hinge(link, before, {0.6 * i, 0, 1}, {0, 1, 0});
    before = link;
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, bouncing(1));
  const double energy = world.energy();
  const auto touches = run(step, 0.6, 5e-4);
  CHECK(!touches.empty());
  CHECK_NEAR(world.energy(), energy, 1e-7);  // measured 2e-9 J at this step
  std::printf("chain: %zu impacts, energy %.3g J\n", touches.size(), world.energy() - energy);
}

/// Order through impacts: a link against a wall; the error just before the sixth impact.
void check_order() {
  const auto error = [](double h) {
    World world({0, 0, -9.8});
    const dBodyID link = world.box(1, {1, 0.1, 0.1}, {1.5, 0, 3});
    world.hinge(link, nullptr, {1, 0, 3}, {0, 1, 0});
    const dGeomID wall = dCreateBox(world.space, 1.8, 2, 10);
    dGeomSetPosition(wall, 0, 0, 0);
    AccurateStep step(world.id, world.space, bouncing(1));
    const auto touches = run(step, 4.48, h);
    CHECK_EQUAL(touches.size(), std::size_t{5});
    return touches.size() == 5 ? touches.back().t : 0;
  };
  // 4.440911699610629 s: the closed form (method analytic, scenario wall_pendulum).
  constexpr double wanted = 4.440911699610629;
  const double coarse = std::fabs(error(8e-3) - wanted);
  const double fine = std::fabs(error(4e-3) - wanted);
  const double finest = std::fabs(error(2e-3) - wanted);
  std::printf("fifth impact: late by %.3g %.3g %.3g s, order %.2f, %.2f\n", coarse, fine, finest,
              order(coarse, fine, 2), order(fine, finest, 2));
  CHECK_BETWEEN(order(coarse, fine, 2), 3.5, 6);
  CHECK_BETWEEN(order(fine, finest, 2), 3.5, 6);
  CHECK_BETWEEN(finest, 0, 1e-9);
}

/// Between two walls a hundredth of a millimetre apart: several impacts in one step, all of them made.
void check_many_in_a_step() {
  World world(Vector3d::Zero());
  const dBodyID ball = world.sphere(1, 0.1, {0, 0, 0});
  dCreatePlane(world.space, 1, 0, 0, -0.1005);
  dCreatePlane(world.space, -1, 0, 0, -0.1005);
  World::move(ball, {1, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space, bouncing(1));
  step(0.01);  // 0.5 mm to either side at 1 m/s: at 0.5, 1.5, ... 9.5 ms
  CHECK_EQUAL(step.touches().size(), std::size_t{10});
  for (std::size_t k = 0; k < step.touches().size(); ++k) {
    CHECK_NEAR(step.touches()[k].t, (0.5 + static_cast<double>(k)) * 1e-3, 1e-10);
  }
  CHECK_NEAR(dBodyGetPosition(ball)[0], 0, 1e-10);
  CHECK_NEAR(dBodyGetLinearVel(ball)[0], 1, 1e-12);
}

}  // namespace

int main() {
  check_ball(1e-3);
  check_ball(0.05);
  check_rest();
  check_flat_box();
  check_two_balls();
  check_chain_hits();
  check_order();
  check_many_in_a_step();
  return odeval::test::verdict();
}
