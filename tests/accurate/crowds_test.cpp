// Where contacts crowd: nothing aborts, work is bounded, joints keep, energy does not rise, and what rests does not
// sink.
#include "tests/accurate/crowds.hpp"

#include <algorithm>
#include <array>
#include <functional>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepOptions;
using odeval::Bounce;

/// Largest distance between the anchors of a ball joint.
double gap(const World& world) {
  double largest = 0;
  for (const dBodyID body : world.bodies) {
    for (int j = 0; j < dBodyGetNumJoints(body); ++j) {
      dVector3 one, two;
      dJointGetBallAnchor(dBodyGetJoint(body, j), one);
      dJointGetBallAnchor2(dBodyGetJoint(body, j), two);
      largest = std::max(largest, (vec(one) - vec(two)).norm());
    }
  }
  return largest;
}

struct Scene {
  const char* name;
  void (*build)(World&);
  double overlap;  // at the end, at most, m
};

/// Work is counted in evaluations of the accelerations (`forces` is called at each); a step without contacts takes
/// four.
void check_scene(const Scene& scene, double restitution, const std::function<void(AccurateStepOptions&)>& change,
                 double friction = 0) {
  constexpr double h = 5e-3;
  constexpr int steps = 1000;
  World world;
  scene.build(world);
  AccurateStepOptions options;
  long evaluations = 0;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(Bounce{restitution, friction}); };
  options.forces = [&](double) { ++evaluations; };
  change(options);
  AccurateStep step(world.id, world.space, options);
  const double start = world.energy();
  long all = 0, most = 0;
  double highest = start, apart = 0;
  std::size_t touches = 0;
  for (int k = 0; k < steps; ++k) {
    evaluations = 0;
    step(h);
    all += evaluations;
    most = std::max(most, evaluations);
    highest = std::max(highest, world.energy());
    apart = std::max(apart, gap(world));
    touches += step.touches().size();
  }
  const double deep = overlap(world);
  std::printf(
      "%-12s restitution %g, friction %g: %zu touches, %zu crowded steps; %.2f evaluations a step, at most %ld; "
      "overlap %.2g m\n",
      scene.name, restitution, friction, touches, step.crowded_steps(), static_cast<double>(all) / steps, most, deep);
  CHECK_BETWEEN(static_cast<double>(all) / steps, 4, 3 * 4);
  CHECK(most <= 60 * 4);
  CHECK_BETWEEN(highest, start, start + 1e-9 * std::fabs(start));
  CHECK_BETWEEN(apart, 0, 1e-9);
  CHECK_BETWEEN(deep, 0, restitution > 0 ? 2e-3 : scene.overlap);  // with some the limbs still slide and hop
  CHECK(step.crowded_steps() > 0 || options.most_impacts == 1);
}

/// Friction that is hard to solve, in parts of a step that are looked for one after the other, ends in a crowd: pairs
/// of geoms that touch are counted, at every state looked at.
void check_friction_is_bounded() {
  World world;
  ragdoll(world);
  int asked = 0, most = 0;
  AccurateStepOptions options;
  options.contact = [&](dGeomID, dGeomID) {
    ++asked;
    return std::optional(Bounce{0, 0.5});
  };
  AccurateStep step(world.id, world.space, options);
  for (int k = 0; k < 200; ++k) {
    asked = 0;
    step(5e-3);
    most = std::max(most, asked);
  }
  std::printf("ragdoll, friction 0.5: at most %d pairs in contact looked at in a step\n", most);
  CHECK_BETWEEN(most, 20, 200);  // 107 measured; 347 without the bound
}

/// Boxes on each other, a little shifted.
void stack_of_3(World& world) {
  for (int i = 0; i < 3; ++i) world.box(1 + i, {0.3, 0.25, 0.2}, {0.03 * (i % 2), 0.02 * i, 0.1 + 0.21 * i});
}

void balls(World& world) {
  for (int i = 0; i < 21; ++i) {
    world.sphere(1, 0.1, {0.19 * (i % 3) - 0.2, 0.19 * (i / 3 % 3) - 0.2, 0.12 + 0.2 * (i / 9)});
  }
}

/// A heavy ball is shot into a wall of bricks.
void wall(World& world) {
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 2; ++k) world.box(1, {0.29, 0.15, 0.15}, {0.3 * k + 0.15 * (i % 2), 0, 0.075 + 0.15 * i});
  }
  World::move(world.sphere(3, 0.12, {-1, 0, 0.3}), {6, 0, 1}, {0, 0, 0});
}

/// Within four walls and a little apart: ways out of overlaps, and what bounces with what forces did in a step, give
/// nothing that contacts did not take before. Rounding: 1e-14 of the kinetic energy is let pass in each part of a step.
void check_energy(void (*build)(World&), double restitution, double friction, double h) {
  World world;
  build(world);
  dCreatePlane(world.space, 0, 0, 1, 0);
  for (const double side : {-1.0, 1.0}) {
    dCreatePlane(world.space, side, 0, 0, -1.2);
    dCreatePlane(world.space, 0, side, 0, -1.2);
  }
  AccurateStepOptions options;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(Bounce{restitution, friction}); };
  AccurateStep step(world.id, world.space, options);
  const double start = world.energy();
  double highest = start;
  for (double t = 0; t < 3; t += h) {
    step(h);
    highest = std::max(highest, world.energy());
  }
  std::printf("restitution %g, friction %g: %zu crowded steps; energy %.4g J, risen by %.2g of it\n", restitution,
              friction, step.crowded_steps(), start, highest / start - 1);
  CHECK_BETWEEN(highest, start, start * (1 + 1e-12));
  CHECK(step.crowded_steps() > 0);
}

void boxes_on_stairs(World& world) {
  for (int i = 0; i < 12; ++i) dGeomSetPosition(dCreateBox(world.space, 0.5, 4, 0.25), 0.4 * i, 0, -0.25 * i - 0.125);
  dCreatePlane(world.space, 0, 0, 1, -3.2);
  for (int i = 0; i < 8; ++i) {
    const Vector3d place(0.1 * (i % 2), 0.3 * (i % 4) - 0.5, 0.4 + 0.3 * (i / 4));
    World::move(world.box(1, {0.3, 0.25, 0.2}, place), {1.5, 0, 0}, {0, 1, 0.3 * i});
  }
}

/// What turns by an angle x in a step of the fourth order changes its energy of motion by less than a share of x^5.
double flight_error(const World& world, double h) {
  double sum = 0;
  for (const dBodyID body : world.bodies) {
    const Vector3d v = vec(dBodyGetLinearVel(body)), w = vec(dBodyGetAngularVel(body));
    const double energy = World::mass(body) * v.squaredNorm() / 2 + w.dot(World::inertia(body) * w) / 2;
    sum += energy * std::pow(h * w.norm(), 5);
  }
  return sum;
}

/// No step adds energy, in crowds or out of them, where nothing drives: not even what contacts took in steps before.
/// Still it comes to rest, and lies no deeper than what rests.
void check_never_rises(const Scene& scene, double restitution, double friction, int steps) {
  constexpr double h = 5e-3;
  World world;
  scene.build(world);
  AccurateStepOptions options;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(Bounce{restitution, friction}); };
  AccurateStep step(world.id, world.space, options);
  const double start = std::fabs(world.energy());
  double last = world.energy(), rise = 0;
  for (int k = 0; k < steps; ++k) {
    const double in_flight = flight_error(world, h);
    step(h);
    rise = std::max(rise, (world.energy() - last) - in_flight - flight_error(world, h));
    last = world.energy();
  }
  std::printf(
      "%-12s restitution %g, friction %g: %zu crowded steps; no step adds more than %.2g of the energy; "
      "overlap %.2g m\n",
      scene.name, restitution, friction, step.crowded_steps(), rise / start, overlap(world));
  CHECK_BETWEEN(rise, -HUGE_VAL, 1e-12 * start);
  CHECK(step.crowded_steps() > 10);
  CHECK_BETWEEN(overlap(world), 0, scene.overlap);
}

/// Elastic balls that fall on each other between walls: no step changes their energy. Rounding: 1e-14 of the kinetic
/// energy is let pass in each part of a step.
void check_elastic(int count) {
  constexpr double h = 5e-3;
  World world;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-0.01, 0.01);
  for (int i = 0; i < count; ++i) {
    const Vector3d place(0.22 * (i % 4), 0.22 * (i / 4 % 4), 0.15 + 0.25 * (i / 16));
    world.sphere(1, 0.1, place + Vector3d(shift(random), shift(random), 0));
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
  dCreatePlane(world.space, 1, 0, 0, -0.2);
  dCreatePlane(world.space, -1, 0, 0, -0.9);
  dCreatePlane(world.space, 0, 1, 0, -0.2);
  dCreatePlane(world.space, 0, -1, 0, -0.9);
  AccurateStepOptions options;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{1, 0}); };
  AccurateStep step(world.id, world.space, options);
  const double start = world.energy();
  const double rise = most_risen(world, step, h, 1);
  std::printf("%d elastic balls: %zu crowded steps; energy %.4g J, risen by at most %.2g of it in a step\n", count,
              step.crowded_steps(), start, rise / start);
  CHECK_BETWEEN(rise, 0, 1e-12 * start);  // 4e-16 measured
  CHECK(step.crowded_steps() > 50);
}

/// A crowd ends when nothing has bounced for ten steps, and also when nothing touches any more.
void check_crowd_ends() {
  constexpr double h = 5e-3;
  World world;
  for (int i = 0; i < 30; ++i) world.sphere(1, 0.1, {0.21 * (i % 6), 0.21 * (i / 6), 0.11 + 0.003 * i});
  const dGeomID ground = dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStepOptions options;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{0.5, 0}); };
  AccurateStep step(world.id, world.space, options);
  while (step.crowded_steps() == 0) step(h);
  // Without ground nothing touches: only the neighbours may still, for a moment.
  dGeomDisable(ground);
  for (int k = 0; k < 40; ++k) step(h);
  const std::size_t before = step.crowded_steps();
  for (int k = 0; k < 20; ++k) step(h);
  CHECK_EQUAL(step.crowded_steps(), before);
}

/// While others crowd, what rests stays where it is: poses follow half of the change of velocity.
void check_rest_in_crowd() {
  constexpr double h = 5e-3;
  World world;
  wall(world);
  const dBodyID ball = world.sphere(1, 0.1, {5, 0, 0.1});
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStepOptions options;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{0.3, 0.5}); };
  AccurateStep step(world.id, world.space, options);
  for (int k = 0; k < 200; ++k) {
    step(h);
    CHECK_NEAR(dBodyGetPosition(ball)[2], 0.1, 2e-9);  // as deep as what rests; the whole change would lift it by 6e-5
    CHECK_NEAR(dBodyGetLinearVel(ball)[2], 0, 1e-12);
  }
  CHECK(step.crowded_steps() > 50);
}

/// While others crowd, a joint tells what it bears: the weight of what stands on it.
void check_feedback_in_crowd() {
  constexpr double h = 5e-3;
  World world;
  wall(world);
  const dBodyID foot = world.box(1, {0.2, 0.2, 0.2}, {7, 0, 0.1}), load = world.sphere(2, 0.1, {7, 0, 0.5});
  const dJointID post = dJointCreateFixed(world.id, nullptr);
  dJointAttach(post, load, foot);
  dJointSetFixed(post);
  dJointFeedback feedback{};
  dJointSetFeedback(post, &feedback);
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStepOptions options;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{0.3, 0.5}); };
  AccurateStep step(world.id, world.space, options);
  const Vector3d weight(0, 0, 2 * 9.81);
  std::size_t crowded = 0;
  for (int k = 0; k < 200; ++k) {
    step(h);
    if (step.crowded_steps() == crowded) continue;
    crowded = step.crowded_steps();
    CHECK_NEAR((vec(feedback.f1) - weight).norm(), 0, 1e-9);
    CHECK_NEAR((vec(feedback.f2) + weight).norm(), 0, 1e-9);
  }
  CHECK(crowded > 50);
}

/// Ten seconds: it falls on its wheels, gathers speed at the limit of its motors, and rolls on without slipping.
void check_buggy() {
  constexpr double h = 5e-3;
  constexpr int steps = 2000;
  World world;
  buggy(world);
  AccurateStepOptions options;
  long evaluations = 0;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{0, 1}); };
  options.forces = [&](double) { ++evaluations; };
  AccurateStep step(world.id, world.space, options);
  long all = 0, most = 0;
  for (int k = 0; k < steps; ++k) {
    evaluations = 0;
    step(h);
    all += evaluations;
    most = std::max(most, evaluations);
  }
  const double speed = dBodyGetLinearVel(world.bodies[0])[0];
  std::printf("%-12s %zu crowded steps; %.2f evaluations a step, at most %ld; overlap %.2g m, speed off by %.2g m/s\n",
              "buggy", step.crowded_steps(), static_cast<double>(all) / steps, most, overlap(world),
              std::fabs(speed) - buggy_turns * buggy_wheel);
  CHECK_BETWEEN(static_cast<double>(all) / steps, 4, 1.5 * 4);  // 4.31 measured
  CHECK(most <= 15 * 4);                                        // where all wheels land; 40 measured
  CHECK_BETWEEN(overlap(world), 0, 1e-6);
  CHECK_NEAR(std::fabs(speed), buggy_turns * buggy_wheel, 1e-6);
}

}  // namespace

int main() {
  const std::array scenes{Scene{"ragdoll", ragdoll, 1e-6}, Scene{"stack of 10", stack_of_10, 1e-6},
                          Scene{"pile of 50", pile_of_50, 1e-6}};
  for (const Scene& scene : scenes) {
    check_scene(scene, 0, [](AccurateStepOptions&) {});
    check_scene(scene, 0.4, [](AccurateStepOptions&) {});
    check_scene(
        scene, 0, [](AccurateStepOptions&) {}, 0.5);
  }
  // Settings that once ended in what could not be pushed apart, or in gaps of joints.
  for (const int most : {1, 4}) check_scene(scenes[0], 0, [=](AccurateStepOptions& o) { o.most_impacts = most; });
  check_scene(scenes[0], 0, [](AccurateStepOptions& o) { o.rest_speed = 0.05; });
  check_scene(scenes[0], 0, [](AccurateStepOptions& o) { o.impact_order = odeval::ImpactOrder::in_turn; });
  check_friction_is_bounded();
  check_energy(stack_of_3, 0.986, 0, 5e-3);
  check_energy(balls, 0.977, 1, 5e-3);
  check_energy(wall, 0, 0, 1e-2);
  check_energy(wall, 0.84, 0.58, 5e-3);
  for (const double friction : {0.0, 0.5}) {
    check_never_rises(scenes[0], 0, friction, 600);
    check_never_rises(scenes[1], 0, friction, 200);
    check_never_rises({"on stairs", boxes_on_stairs, 1e-6}, 0, friction, 800);
  }
  check_never_rises({"on stairs", boxes_on_stairs, 1e-6}, 0.5, 0, 800);
  check_never_rises(scenes[2], 0, 0, 1600);
  for (const int count : {30, 60}) check_elastic(count);
  check_crowd_ends();
  check_rest_in_crowd();
  check_feedback_in_crowd();
  check_buggy();
  return odeval::test::verdict();
}
