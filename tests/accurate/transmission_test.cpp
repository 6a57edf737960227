// Transmissions: wheels on fixed axes by closed forms and by dWorldStep's limit, wheels that tumble with their frame by
// what is conserved.
#include <cstdio>
#include <functional>
#include <string>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepError;

constexpr double radius_1 = 0.3, radius_2 = 0.5;  // of the wheels, as they mesh

/// Two wheels, their axes and how the second turns where the first turns once.
struct Gears {
  int mode;
  const char* name;
  Vector3d at_1, at_2, axis_1, axis_2;
  double turns;

  dJointID mesh(const World& world, dBodyID one, dBodyID other) const {
    const dJointID joint = dJointCreateTransmission(world.id, nullptr);
    dJointAttach(joint, one, other);
    dJointSetTransmissionMode(joint, mode);
    if (mode == dTransmissionIntersectingAxes) {
      dJointSetTransmissionAxis1(joint, axis_1[0], axis_1[1], axis_1[2]);
      dJointSetTransmissionAxis2(joint, axis_2[0], axis_2[1], axis_2[2]);
    } else {
      dJointSetTransmissionAxis(joint, axis_1[0], axis_1[1], axis_1[2]);
    }
    dJointSetTransmissionAnchor1(joint, at_1[0], at_1[1], at_1[2]);
    dJointSetTransmissionAnchor2(joint, at_2[0], at_2[1], at_2[2]);
    if (mode == dTransmissionParallelAxes) dJointSetTransmissionRatio(joint, radius_1 / radius_2);
    if (mode == dTransmissionChainDrive) {
      dJointSetTransmissionRadius1(joint, radius_1);
      dJointSetTransmissionRadius2(joint, radius_2);
    }
    return joint;
  }
};

// Outer wheels turn against each other, wheels on a chain do not. The rims of the bevel wheels meet at (0, radius_2,
// 0), where both move along z; with their axes the other way round ODE's feedback drives them apart.
const Gears parallel{dTransmissionParallelAxes, "parallel axes", {0, 0, 0}, {0.8, 0, 0}, {0, 1, 0}, {0, 1, 0},
                     -radius_1 / radius_2};
const Gears chain{dTransmissionChainDrive, "chain drive", {0, 0, 0}, {1.2, 0, 0}, {0, 1, 0}, {0, 1, 0},
                  radius_1 / radius_2};
const Gears bevel{
    dTransmissionIntersectingAxes, "intersecting axes", {-radius_1, radius_2, 0}, {0, 0, 0}, {0, -1, 0}, {-1, 0, 0},
    -radius_1 / radius_2};

/// On hinges to the world, a torque on the first.
struct Driven {
  explicit Driven(const Gears& gears) : gears_(gears) {
    first = world.sphere(3, 0.2, gears.at_1);
    second = world.sphere(5, 0.2, gears.at_2);
    hinges[0] = world.hinge(first, nullptr, gears.at_1, gears.axis_1);
    hinges[1] = world.hinge(second, nullptr, gears.at_2, gears.axis_2);
    gears.mesh(world, first, second);
  }
  void push() const {
    const Vector3d torque = 0.2 * gears_.axis_1;
    dBodyAddTorque(first, torque[0], torque[1], torque[2]);
  }
  /// That the torque gives the first wheel.
  double acceleration() const {
    constexpr double inertia_1 = 0.4 * 3 * 0.04, inertia_2 = 0.4 * 5 * 0.04;
    return 0.2 / (inertia_1 + gears_.turns * gears_.turns * inertia_2);
  }
  double spin_1() const { return vec(dBodyGetAngularVel(first)).dot(gears_.axis_1); }
  double spin_2() const { return vec(dBodyGetAngularVel(second)).dot(gears_.axis_2); }

  World world{Vector3d::Zero()};
  dBodyID first, second;
  dJointID hinges[2];

 private:
  Gears gears_;
};

/// Turned by the first wheel after a second, less what the closed form says, with what was added up of the spin.
double turned_by_world_step(const Gears& gears, double h, double wanted) {
  Driven driven(gears);
  double turned = 0;
  for (int k = 0; k * h < 1 - h / 2; ++k) {
    driven.push();
    dWorldStep(driven.world.id, h);
    turned += h * driven.spin_1();
  }
  CHECK_NEAR(driven.spin_2(), gears.turns * driven.spin_1(), 1e-3 * std::fabs(driven.spin_1()));
  return turned - wanted;
}

void check_closed_form(const Gears& gears) {
  Driven driven(gears);
  AccurateStep step(driven.world.id, driven.world.space);
  constexpr double h = 1e-3;
  double turned_1 = 0, turned_2 = 0, before_1 = 0, before_2 = 0;
  for (int k = 0; k < 1000; ++k) {
    driven.push();
    step(h);
    turned_1 += h / 2 * (before_1 + driven.spin_1());  // exact: the spin grows evenly
    turned_2 += h / 2 * (before_2 + driven.spin_2());
    before_1 = driven.spin_1();
    before_2 = driven.spin_2();
  }
  const double wanted = driven.acceleration();
  std::printf("%s: spin off by %.2g of %.3f rad/s, its fellow's by %.2g, phase by %.2g rad\n", gears.name,
              driven.spin_1() - wanted, wanted, driven.spin_2() - gears.turns * wanted,
              turned_2 - gears.turns * turned_1);
  // Forces are constant: rounding over a thousand steps, 1e-14 of it measured, times a hundred.
  CHECK_NEAR(driven.spin_1(), wanted, 1e-12 * wanted);
  CHECK_NEAR(driven.spin_2(), gears.turns * wanted, 1e-12 * wanted);
  CHECK_NEAR(turned_1, wanted / 2, 1e-12 * wanted);
  CHECK_NEAR(turned_2, gears.turns * wanted / 2, 1e-12 * wanted);
  const double angle = dJointGetHingeAngle(driven.hinges[0]);
  CHECK_NEAR(std::fabs(std::remainder(angle, 2 * M_PI)), std::fabs(std::remainder(wanted / 2, 2 * M_PI)), 1e-9);

  // dWorldStep's limit is the same motion: it is off by half a step's worth of spin.
  const double coarse = turned_by_world_step(gears, 2e-3, wanted / 2);
  const double fine = turned_by_world_step(gears, 1e-3, wanted / 2);
  std::printf("%s: dWorldStep turns it by %.2g rad too much at h = 0.001, order %.2f\n", gears.name, fine,
              order(coarse, fine, 2));
  CHECK_NEAR(fine, h / 2 * wanted, 0.1 * h / 2 * wanted);
  CHECK_BETWEEN(order(coarse, fine, 2), 0.9, 1.1);
}

/// Wheels whose bodies have their centres beside the axes go round evenly without forces, as any would.
void check_off_centre(const Gears& gears) {
  constexpr double spin = 3, h = 1e-3;
  World world{Vector3d::Zero()};
  std::vector<dBodyID> wheels;
  const auto wheel = [&](const Vector3d& at, const Vector3d& axis, double turns) {
    const Vector3d off = 0.25 * axis.unitOrthogonal() + 0.1 * axis, turning = turns * spin * axis;
    const dBodyID body = world.box(2, {0.1, 0.3, 0.2}, at + off);
    world.hinge(body, nullptr, at, axis);
    World::move(body, turning.cross(off), turning);
    wheels.push_back(body);
  };
  wheel(gears.at_1, gears.axis_1, 1);
  wheel(gears.at_2, gears.axis_2, gears.turns);
  dJointFeedback feedback{};
  dJointSetFeedback(gears.mesh(world, wheels[0], wheels[1]), &feedback);
  AccurateStep step(world.id, world.space);
  double worst = 0, force = 0;
  for (int k = 0; k < 1000; ++k) {
    step(h);
    worst = std::max(worst, std::fabs(vec(dBodyGetAngularVel(wheels[0])).dot(gears.axis_1) - spin));
    worst = std::max(worst, std::fabs(vec(dBodyGetAngularVel(wheels[1])).dot(gears.axis_2) - gears.turns * spin));
    force = std::max(force, vec(feedback.f1).norm());
  }
  std::printf("%s, wheels off their bodies' centres: spin off by %.2g of %.0f rad/s, %.2g N\n", gears.name, worst, spin,
              force);
  // Rounding over a thousand steps, 1e-14 of both measured, times a hundred. They have nothing to hand on.
  CHECK_BETWEEN(worst, 0, 1e-12);
  CHECK_BETWEEN(force, 0, 1e-12);
}

/// On a frame that tumbles with them in free space.
struct Tumbling {
  explicit Tumbling(const Gears& gears) : gears_(gears) {
    frame = world.box(2, {1.0, 0.3, 0.5}, (gears.at_1 + gears.at_2) / 2 + Vector3d(0.1, 0.2, -0.1));
    first = world.box(1, {0.1, 0.3, 0.2}, gears.at_1);
    second = world.sphere(1.5, 0.2, gears.at_2);
    world.hinge(first, frame, gears.at_1, gears.axis_1);
    world.hinge(second, frame, gears.at_2, gears.axis_2);
    gears.mesh(world, first, second);
    World::move(frame, {0.1, 0.2, 0.3}, {1, 2, -1.5});
    World::move(first, {-0.2, 0.1, 0}, {3, 5, 1});
    World::move(second, {0, 0, 0.3}, {-1, 1, 2});
  }
  /// Of both wheels in the frame, less what the gears let them.
  double slip() const {
    const Vector3d spin = vec(dBodyGetAngularVel(frame));
    const auto turns = [&](dBodyID wheel, const Vector3d& axis) {
      return (vec(dBodyGetAngularVel(wheel)) - spin).dot(World::turn(frame) * axis);
    };
    return turns(second, gears_.axis_2) - gears_.turns * turns(first, gears_.axis_1);
  }

  World world{Vector3d::Zero()};
  dBodyID frame, first, second;

 private:
  Gears gears_;
};

/// After the first step, which makes velocities agree: largest change of energy and momenta, and largest slip.
struct Lost {
  double energy = 0, momentum = 0, slip = 0;
};
Lost tumble(const Gears& gears, double h) {
  Tumbling tumbling(gears);
  const World& world = tumbling.world;
  AccurateStep step(world.id, world.space);
  step(1e-6);
  const double energy = world.energy();
  const Vector3d momentum = world.momentum(), angular = world.angular_momentum();
  Lost lost;
  for (int k = 0; k * h < 1; ++k) {
    step(h);
    lost.energy = std::max(lost.energy, std::fabs(world.energy() / energy - 1));
    lost.momentum = std::max(lost.momentum, (world.angular_momentum() - angular).norm() / angular.norm() +
                                                (world.momentum() - momentum).norm());
    lost.slip = std::max(lost.slip, std::fabs(tumbling.slip()));
  }
  return lost;
}

void check_tumbling(const Gears& gears) {
  const Lost coarse = tumble(gears, 2e-2), fine = tumble(gears, 1e-2);
  std::printf("%s, tumbling, h = 0.01: energy %.2g of itself, order %.2f, angular momentum %.2g, slip %.2g rad/s\n",
              gears.name, fine.energy, order(coarse.energy, fine.energy, 2), fine.momentum, fine.slip);
  // Velocities agree at each step, to what the last correction of poses moves axes by: 6e-12 measured.
  CHECK_BETWEEN(fine.slip, 0, 5e-11);
  CHECK_BETWEEN(fine.energy, 0, 1e-10);
  CHECK_BETWEEN(order(coarse.energy, fine.energy, 2), 3.5, 5.5);  // 4, or 5 where what is lost does not add up
  CHECK_BETWEEN(fine.momentum, 0, 1e-9);
}

void refused(const char* message, Gears gears, const std::function<void(dJointID)>& spoil = {}) {
  World world(Vector3d::Zero());
  const dBodyID one = world.sphere(1, 0.1, gears.at_1), other = world.sphere(1, 0.1, gears.at_2);
  const dJointID joint = gears.mesh(world, one, other);
  if (spoil) spoil(joint);
  CHECK_THROWS(AccurateStep(world.id, world.space), AccurateStepError, message);
}

void check_refused() {
  refused("has backlash; set it to 0", parallel, [](dJointID joint) { dJointSetTransmissionBacklash(joint, 0.01); });
  Gears gears = parallel;
  gears.axis_1 = {1, 0, 0};
  refused("not in one plane", gears);
  gears = chain;
  gears.at_2 = {0.1, 0, 0};
  refused("reaches around the other", gears);
  refused("has a wheel of no radius", chain, [](dJointID joint) { dJointSetTransmissionRadius2(joint, 0); });
  gears = bevel;
  gears.axis_2 = gears.axis_1;
  refused("has axes that are parallel", gears);
  gears = bevel;
  gears.at_1[2] = 0.1;
  refused("has axes that do not intersect", gears);
}

/// A chain on another wheel in the middle of a run is noticed.
void check_change() {
  World world(Vector3d::Zero());
  const dBodyID first = world.sphere(1, 0.1, chain.at_1), second = world.sphere(1, 0.1, chain.at_2);
  world.hinge(first, nullptr, chain.at_1, chain.axis_1);
  world.hinge(second, nullptr, chain.at_2, chain.axis_2);
  const dJointID joint = chain.mesh(world, first, second);
  AccurateStep step(world.id, world.space);
  for (const double radius : {0.5, 0.25, 0.4}) {
    dJointSetTransmissionRadius2(joint, radius);
    World::move(first, {0, 0, 0}, {0, 1, 0});
    step(1e-3);
    CHECK_NEAR(dBodyGetAngularVel(second)[1], radius_1 / radius * dBodyGetAngularVel(first)[1], 1e-12);
  }
  const Vector3d moved = chain.at_2 + Vector3d(0, 0, 0.3);
  dJointSetTransmissionAnchor2(joint, moved[0], moved[1] + 0.1, moved[2]);
  CHECK_THROWS(step(1e-3), AccurateStepError, "not in one plane");
}

}  // namespace

int main() {
  for (const Gears& gears : {parallel, chain, bevel}) {
    check_closed_form(gears);
    check_off_centre(gears);
    check_tumbling(gears);
  }
  check_refused();
  check_change();
  return odeval::test::verdict();
}
