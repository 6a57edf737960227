// Impacts of the accurate step: located, shared by all bodies, several at once, many in one step, rest.
#include <cstdio>
#include <stdexcept>

#include "engines/ode_rk4/accurate_step.hpp"
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
  constexpr double rest_depth = 1e-9;  // what rests lies that deep
  for (int k = 0; k < 500; ++k) {
    step(h);
    CHECK_NEAR(dBodyGetPosition(ball)[2], radius - rest_depth, 1e-11);
    CHECK_NEAR(dBodyGetLinearVel(ball)[2], 0, 1e-15);  // a hundred roundings of g h
  }
  // Pulled away, it goes; thrown down, it bounces.
  dBodySetLinearVel(ball, 0, 0, 2);
  step(h);
  CHECK_NEAR(dBodyGetPosition(ball)[2], radius - rest_depth + 2 * h - g * h * h / 2, 1e-11);
  const auto again = run(step, 0.6, h);
  CHECK(!again.empty());
  // The start's depth of 1e-9 m is g 1e-9 / v slower.
  if (!again.empty()) CHECK_NEAR(again.front().touch.approach, 2, 1e-8);
}

/// Links on hinges along x, the first one on the world when `anchored`.
void lay_chain(World& world, int links, double height, bool anchored) {
  dBodyID before = nullptr;
  for (int i = 0; i < links; ++i) {
    const dBodyID link = world.box(1, {0.4, 0.1, 0.1}, {0.2 + 0.4 * i, 0, height});
    if (i > 0 || anchored) world.hinge(link, before, {0.4 * i, 0, height}, {0, 1, 0});
    before = link;
  }
}

/// Mechanisms and stacks come to rest and then lie still: no touch is told, nothing moves, nothing sinks.
void check_rest_of_many() {
  const auto lies = [](const char* what, const auto& build) {
    World world;
    build(world);
    dCreatePlane(world.space, 0, 0, 1, 0);
    AccurateStep step(world.id, world.space, bouncing(0.5));
    const auto settling = run(step, 1.5, 1e-3);
    std::vector<Vector3d> places;
    for (const dBodyID body : world.bodies) places.push_back(vec(dBodyGetPosition(body)));
    const auto touches = run(step, 0.5, 1e-3);
    CHECK(touches.empty());
    double moved = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      moved = std::max(moved, (vec(dBodyGetPosition(world.bodies[i])) - places[i]).norm());
    }
    const double deep = overlap(world);
    std::printf("%-20s %zu touches, then none; moved %.2g m in 0.5 s, overlap %.2g m\n", what, settling.size(), moved,
                deep);
    CHECK_BETWEEN(moved, 0, 1e-8);   // of the rest depth, 1e-9 m: neighbours lean on each other
    CHECK_BETWEEN(deep, 0, 2.1e-9);  // twice the rest depth is not pushed
  };
  lies("arm of 2", [](World& world) { lay_chain(world, 2, 0.055, true); });
  lies("arm of 3", [](World& world) { lay_chain(world, 3, 0.055, true); });
  lies("arm of 4", [](World& world) { lay_chain(world, 4, 0.055, true); });
  lies("fallen chain of 3", [](World& world) { lay_chain(world, 3, 0.3, false); });
  lies("stack of 4", [](World& world) {
    for (int i = 0; i < 4; ++i) world.box(1, {0.2, 0.2, 0.2}, {0, 0, 0.11 + 0.21 * i});
  });
}

/// A box that stands on an edge and tips over: the edge rests all the while, and the other one strikes.
void check_tipping() {
  constexpr double half = 0.2, high = 0.05, tilt = 0.3, e = 0.5;
  World world;
  const Quaterniond turn(Eigen::AngleAxisd(-tilt, Vector3d::UnitY()));  // the end at +x is up
  const Vector3d edge(-half, 0, -high);
  const dBodyID box = world.box(2, {2 * half, 0.3, 2 * high}, -(turn * edge), turn);
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, bouncing(e));
  const double energy = world.energy();
  bool struck = false;
  for (int k = 0; k < 1000 && !struck; ++k) {
    step(1e-3);
    for (const Touch& touch : step.touches()) {
      if (touch.approach < 0.1) continue;  // the edge, laid down without speed
      struck = true;
      CHECK_EQUAL(touch.contacts, std::size_t{2});
      CHECK_NEAR(touch.departure, e * touch.approach, 1e-12);
      // Frictionless: the centre falls straight down, so energy gives the speed of the far edge, v = w 2 half.
      const double fallen = half * std::sin(tilt) - high * (1 - std::cos(tilt));
      const double w = touch.approach / (2 * half);
      const double inertia = World::inertia(box)(1, 1) + World::mass(box) * half * half;
      const double kinetic = inertia * w * w / 2;
      const double potential = World::mass(box) * g * fallen;
      std::printf("tipped over: energy %.4f of what was there\n", kinetic / potential);
      CHECK_BETWEEN(kinetic / potential, 0.998, 1.002);  // rest is first order: 1.0001 measured
    }
  }
  CHECK(struck);
  CHECK(world.energy() < energy);
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

/// Two balls in a space of the space, and one in another: they meet as if there were no inner spaces.
void check_inner_spaces() {
  World world(Vector3d::Zero());
  const dSpaceID inner = dSimpleSpaceCreate(world.space), other = dHashSpaceCreate(world.space);
  const auto ball = [&](dSpaceID space, double x) {
    const dBodyID body = world.sphere(1, 0.1, {x, 0, 0});
    const dGeomID geom = dBodyGetFirstGeom(body);
    dSpaceRemove(world.space, geom);
    dSpaceAdd(space, geom);
    return body;
  };
  const dBodyID one = ball(inner, 0), two = ball(inner, 0.5), three = ball(other, 1);
  World::move(one, {1, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space, bouncing(1));
  CHECK_EQUAL(step.bodies(), std::size_t{3});
  const auto touches = run(step, 1, 0.01);
  CHECK_EQUAL(touches.size(), std::size_t{2});
  CHECK_NEAR(dBodyGetLinearVel(one)[0], 0, 1e-14);
  CHECK_NEAR(dBodyGetLinearVel(two)[0], 0, 1e-14);
  CHECK_NEAR(dBodyGetLinearVel(three)[0], 1, 1e-14);
}

/// With a millimetre of play between two walls: several impacts in one step, all of them made.
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

/// The last impact of a step that is located: further ones, of other bodies too, are stopped at the step's end.
void check_most_impacts() {
  World world(Vector3d::Zero());
  const dBodyID one = world.sphere(1, 0.1, {0, 0, 0});
  const dBodyID two = world.sphere(1, 0.1, {0, 1, 0});
  dCreatePlane(world.space, 1, 0, 0, -0.1005);
  dCreatePlane(world.space, -1, 0, 0, -0.1005);
  World::move(one, {1, 0, 0}, {0, 0, 0});
  World::move(two, {0.1, 0, 0}, {0, 0, 0});
  AccurateStepOptions options = bouncing(1);
  options.most_impacts = 2;
  AccurateStep step(world.id, world.space, options);
  step(0.0055);  // would strike at 0.5, 1.5, 2.5, 3.5, 4.5 and (the slow ball) at 5 ms
  CHECK_EQUAL(step.touches().size(), std::size_t{2});
  CHECK_NEAR(dBodyGetLinearVel(one)[0], 0, 1e-12);
  CHECK_NEAR(dBodyGetLinearVel(two)[0], 0, 1e-12);
  CHECK_NEAR(dBodyGetPosition(two)[0], 0.0005, 2.1e-9);  // twice the rest depth is not pushed
}

/// What comes slower than the speed of rest does not bounce.
void check_rest_speed() {
  const auto departs = [](double rest_speed) {
    World world(Vector3d::Zero());
    const dBodyID ball = world.sphere(1, 0.1, {0, 0, 0.1 + 1e-6});
    dCreatePlane(world.space, 0, 0, 1, 0);
    World::move(ball, {0, 0, -0.5e-3}, {0, 0, 0});
    AccurateStepOptions options = bouncing(0.8);
    options.rest_speed = rest_speed;
    AccurateStep step(world.id, world.space, options);
    step(0.01);
    return dBodyGetLinearVel(ball)[2];
  };
  CHECK_NEAR(departs(1e-3), 0, 1e-15);
  CHECK_NEAR(departs(0), 0.4e-3, 1e-12);
}

/// A step that fails after something came to rest forgets it: taken again, it is that of a world where none failed.
void check_failed_step() {
  const auto second_try = [](bool first_fails) {
    World world;
    world.sphere(1, 0.1, {0, 0, 0.1 + 1e-4});  // falls from rest; comes to rest after 4.5 ms
    world.sphere(1, 0.1, {1, 0, 0.1 + 3e-4});  // after 7.8 ms
    dCreatePlane(world.space, 0, 0, 1, 0);
    AccurateStepOptions options = bouncing(0);
    int left = 2;
    options.after_impact = [&](const Touch&) {
      if (--left == 0) throw std::runtime_error("second impact");
    };
    AccurateStep step(world.id, world.space, options);
    if (first_fails) CHECK_THROWS(step(0.01), std::runtime_error, "second impact");
    left = -1;
    step(0.01);
    CHECK_EQUAL(step.touches().size(), std::size_t{2});
    return world.state();
  };
  CHECK(second_try(true) == second_try(false));
}

}  // namespace

int main() {
  check_ball(1e-3);
  check_ball(0.05);
  check_rest();
  check_rest_of_many();
  check_tipping();
  check_flat_box();
  check_two_balls();
  check_inner_spaces();
  check_chain_hits();
  check_order();
  check_many_in_a_step();
  check_most_impacts();
  check_rest_speed();
  check_failed_step();
  return odeval::test::verdict();
}
