// What touches nothing has no part in what contacts do: neither in their energy nor in the motion that they make.
#include <cstdio>
#include <optional>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepOptions;
using odeval::Bounce;

const Vector3d gravity(1.5, 0, -9.7);

/// Pendulums of one link and of three, on balls.
void add_pendulums(World& world) {
  for (const int links : {1, 3}) {
    dBodyID last = nullptr;
    for (int i = 0; i < links; ++i) {
      const Vector3d joint(-50 - 0.4 * i, 5.0 * links, 1.3);
      const dBodyID link = world.box(1, {0.36, 0.08, 0.08}, joint - Vector3d(0.2, 0, 0));
      world.ball(link, last, joint);
      last = link;
    }
  }
}

/// One that a motor turns with all its force, so that no step is split where it is reached, and a body with damping.
void add_driven(World& world) {
  const dBodyID link = world.box(1, {0.36, 0.08, 0.08}, {-50.2, -5, 1.3});
  const dJointID hinge = world.hinge(link, nullptr, {-50, -5, 1.3}, {0, 1, 0});
  dJointSetHingeParam(hinge, dParamFMax, 0.5);
  dJointSetHingeParam(hinge, dParamVel, 100);
  dBodySetLinearDamping(world.box(1, {0.1, 0.1, 0.1}, {-60, 0, 20}), 1e-3);
}

void add_nothing(World&) {}

struct Pile {
  int boxes;
  double turn;  // rad, of each box
  double h, restitution, duration;
};

/// Boxes in a loose pile, and what `add` adds far away: the state of the boxes, step by step.
std::vector<std::vector<double>> run(const Pile& pile, void (*add)(World&)) {
  World world(gravity);
  for (int i = 0; i < pile.boxes; ++i) {
    const double side = 0.2 - 0.02 * i;
    const Quaterniond turn(Eigen::AngleAxisd(pile.turn, Vector3d(1, 0.4 * i, -0.3).normalized()));
    world.box(0.6, {side, side, side}, {0.25 + 0.01 * i, 0.015 * i, 0.1 + (0.19 + pile.turn) * i + pile.turn}, turn);
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
  const std::vector<dBodyID> boxes = world.bodies;
  add(world);
  AccurateStepOptions options;
  options.contact = [&](dGeomID, dGeomID) { return std::optional(Bounce{pile.restitution, 0}); };
  AccurateStep step(world.id, world.space, options);
  world.bodies = boxes;
  const double start = world.energy();
  double last = start, rise = 0, lost = 0;
  std::vector<std::vector<double>> states;
  for (double t = 0; t < pile.duration; t += pile.h) {
    step(pile.h);
    const double now = world.energy();
    rise = std::max(rise, now - last);
    lost = std::max(lost, start - now);
    last = now;
    states.push_back(world.state());
  }
  std::printf(
      "turned by %g, h %g, restitution %g, %zu bodies: %zu steps crowded; of %.4g J %.2g gained in a step, %.2g lost\n",
      pile.turn, pile.h, pile.restitution, step.bodies(), step.crowded_steps(), start, rise, lost);
  CHECK_BETWEEN(rise, 0, 1e-12 * start);  // 4e-15 J measured
  if (pile.restitution == 1) CHECK_BETWEEN(lost, 0, 1e-12 * start);
  return states;
}

double farthest_apart(const std::vector<std::vector<double>>& one, const std::vector<std::vector<double>>& other) {
  double most = 0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    for (std::size_t i = 0; i < one[k].size(); ++i) most = std::max(most, std::fabs(one[k][i] - other[k][i]));
  }
  return most;
}

/// One on the other, or four, that touch when the run begins: what stops one of them throws up none.
void check_touching(double h, int boxes, double friction) {
  World world({0, 0, -9.7});
  for (int i = 0; i < boxes; ++i) {
    const double side = 0.2 - 0.02 * i;
    world.box(0.6, {side, side, side}, {0.01 * i, 0.015 * i, 0.1 + 0.19 * i});
  }
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStepOptions options;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(Bounce{1, friction}); };
  AccurateStep step(world.id, world.space, options);
  const double start = world.energy();
  const double rise = most_risen(world, step, h, 1);
  std::printf("%d boxes that touch, h %g, friction %g: energy risen by %.2g J of %.4g, moved by %.2g m\n", boxes, h,
              friction, rise, start, dBodyGetPosition(world.bodies[1])[2] - 0.29);
  CHECK_BETWEEN(rise, 0, 1e-12 * start);
  if (boxes == 2) CHECK_NEAR(dBodyGetPosition(world.bodies[1])[2], 0.29, 4.1e-9);  // two contacts, up to 2e-9 m each
  if (boxes == 2) CHECK_NEAR(world.energy(), start, 1e-8 * start);                 // what sinking that deep gives
}

}  // namespace

int main() {
  for (const double h : {0.005, 0.004, 0.003}) {
    check_touching(h, 2, 0);
    check_touching(h, 4, 0.5);
  }
  for (const double h : {0.01, 0.005, 0.004, 0.003, 0.002}) {
    // Boxes that touch at first and fall flat on each other: rounding decides which corners strike first.
    for (const auto add : {add_nothing, add_pendulums, add_driven})
      for (const int boxes : {3, 4}) run({boxes, 0, h, 1, 1}, add);
    for (const double restitution : {1.0, 0.6}) {
      const Pile pile{3, 0.02, h, restitution, 0.3};
      const auto alone = run(pile, add_nothing);
      for (const auto add : {add_pendulums, add_driven}) {
        const double apart = farthest_apart(alone, run(pile, add));
        std::printf("  apart by at most %.2g\n", apart);
        CHECK_BETWEEN(apart, 0, 1e-10);  // rounding, grown at each bounce: 2e-12 measured
      }
    }
  }
  return verdict();
}
