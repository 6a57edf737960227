// Rolling and spinning friction by closed forms: how far and how long what rolls or spins goes on, the same in every
// direction; what they hold; and one impact by hand.
#include <cstdio>
#include <string>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepError;
using odeval::AccurateStepOptions;
using odeval::Bounce;

constexpr double g = 9.81;

AccurateStepOptions touching(const Bounce& bounce) {
  AccurateStepOptions options;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(bounce); };
  return options;
}

struct Lying {
  explicit Lying(double slope = 0) : world({g * std::sin(slope), 0, -g * std::cos(slope)}) {
    dCreatePlane(world.space, 0, 0, 1, 0);
  }
  dBodyID cylinder(double mass, double radius, double length, const Vector3d& at, const Quaterniond& turn) {
    const dBodyID body = dBodyCreate(world.id);
    dMass m;
    dMassSetCylinderTotal(&m, mass, 3, radius, length);
    dBodySetMass(body, &m);
    World::place(body, at, turn);
    const dGeomID geom = dCreateCylinder(world.space, radius, length);
    dGeomSetBody(geom, body);
    world.bodies.push_back(body);
    return body;
  }
  World world;
};

constexpr double radius = 0.1, rho = 0.004, rolls_at = 1.5;

/// A wheel that rolls on the level at `rolls_at` along a direction: it slows down by rho g / (radius (1 + its share)),
/// where its inertia is a share of m radius^2.
void check_rolls_to_rest(const char* name, double share, double direction, double h, bool is_ball) {
  Lying level;
  const Vector3d along(std::cos(direction), std::sin(direction), 0), axle(-along[1], along[0], 0);
  const dBodyID wheel =
      is_ball ? level.world.sphere(2, radius, {0, 0, radius})
              : level.cylinder(2, radius, 0.3, {0, 0, radius}, Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axle));
  World::move(wheel, rolls_at * along, rolls_at / radius * axle);
  AccurateStep step(level.world.id, level.world.space, touching({.friction = 0.5, .rho = rho}));
  const double slows = rho * g / (radius * (1 + share)), stops = rolls_at / slows;
  double place = 0, speed = 0, energy = level.world.energy(), rises = 0;
  for (int k = 1; k * h < stops + 0.1; ++k) {
    step(h);
    const double t = std::min(k * h, stops);
    place = std::max(
        place,
        (vec(dBodyGetPosition(wheel)) - (rolls_at * t - slows * t * t / 2) * along - Vector3d(0, 0, radius)).norm());
    speed = std::max(speed, (vec(dBodyGetLinearVel(wheel)) - (rolls_at - slows * t) * along).norm());
    rises = std::max(rises, level.world.energy() - energy);
    energy = level.world.energy();
  }
  std::printf("%s at %.0f degrees, h = %g: rests after %.6f s and %.6f m; off by %.2g m, %.2g m/s\n", name,
              direction * 180 / M_PI, h, stops, rolls_at * stops / 2, place, speed);
  // Forces are constant, so that only rounding is left: 1e-12 measured, times a thousand.
  CHECK_BETWEEN(place, 0, 1e-9);
  CHECK_BETWEEN(speed, 0, 1e-9);
  CHECK_NEAR(vec(dBodyGetAngularVel(wheel)).norm(), 0, 1e-12);
  CHECK_BETWEEN(rises, 0, 1e-11);
}

/// What spins on its contact slows down by rhoN g m / I, whether it also rubs there or touches at a point.
void check_spins_to_rest(const char* name, double h, const auto& make) {
  constexpr double rhoN = 0.003, spins_at = 4, mass = 2;
  Lying level;
  const dBodyID top = make(level, mass);
  const double inertia = World::inertia(top)(2, 2), slows = rhoN * mass * g / inertia, stops = spins_at / slows;
  World::move(top, {0, 0, 0}, {0, 0, spins_at});
  const Vector3d start = vec(dBodyGetPosition(top));
  AccurateStep step(level.world.id, level.world.space, touching({.rhoN = rhoN}));
  double spin = 0, moved = 0, angle = 0, turned = 0;
  for (int k = 1; k * h < stops + 0.1; ++k) {
    step(h);
    const double t = std::min(k * h, stops);
    spin = std::max(spin, std::fabs(dBodyGetAngularVel(top)[2] - (spins_at - slows * t)));
    const Quaterniond off(Quaterniond(Eigen::AngleAxisd(-(spins_at * t - slows * t * t / 2), Vector3d::UnitZ())) *
                          World::turn(top));
    angle = std::max(angle, 2 * off.vec().norm());
    moved = std::max(moved, (vec(dBodyGetPosition(top)) - start).norm());
    turned = t;
  }
  std::printf("%s, h = %g: spins for %.6f s; off by %.2g rad/s, %.2g rad, moved %.2g m\n", name, h, stops, spin, angle,
              moved);
  CHECK_NEAR(turned, stops, 0);
  CHECK_BETWEEN(spin, 0, 1e-9);
  CHECK_BETWEEN(angle, 0, 1e-9);
  CHECK_BETWEEN(moved, 0, 1e-9);
  CHECK_NEAR(vec(dBodyGetAngularVel(top)).norm(), 0, 1e-12);
}

/// Rolling friction holds a ball as long as tan(slope) <= rho / radius; beyond, it rolls with what is left.
void check_slope() {
  constexpr double h = 1e-3;
  for (const double factor : {0.99, 1.01, 3.0}) {
    const double slope = std::atan(factor * rho / radius);
    Lying sloping(slope);
    const dBodyID ball = sloping.world.sphere(1, radius, {0, 0, radius});
    AccurateStep step(sloping.world.id, sloping.world.space, touching({.friction = 0.5, .rho = rho}));
    for (int k = 0; k < 2000; ++k) step(h);
    const double a = factor < 1 ? 0 : 5.0 / 7 * g * (std::sin(slope) - rho / radius * std::cos(slope));
    std::printf("ball on %g times the slope that holds it: %.9f m after 2 s, off by %.2g m\n", factor,
                dBodyGetPosition(ball)[0], dBodyGetPosition(ball)[0] - 2 * a);
    CHECK_NEAR(dBodyGetPosition(ball)[0], 2 * a, factor < 1 ? 1e-10 : 1e-8);
    CHECK_NEAR(dBodyGetLinearVel(ball)[0], 2 * a, 1e-9);
  }
}

/// A ball that comes down turning: its impact takes what the normal impulse lets it.
void check_impact() {
  constexpr double e = 0.6, mass = 1, inertia = 0.4 * mass * radius * radius;
  for (const double coefficient : {1e-4, 10.0}) {
    Lying level;
    const dBodyID ball = level.world.sphere(mass, radius, {0, 0, radius + 0.01});
    World::move(ball, {0, 0, -3}, {3, 4, 2});
    dWorldSetGravity(level.world.id, 0, 0, 0);
    AccurateStep step(level.world.id, level.world.space,
                      touching({.restitution = e, .rho = coefficient, .rhoN = coefficient}));
    step(0.01);
    const double most = coefficient * (1 + e) * 3 * mass / inertia;
    const Vector3d rolls(3, 4, 0);
    const Vector3d wanted = rolls * (1 - std::min(1.0, most / 5)) + Vector3d(0, 0, 2 - std::min(2.0, most));
    CHECK_NEAR((vec(dBodyGetAngularVel(ball)) - wanted).norm(), 0, 1e-10);
    CHECK_NEAR((vec(dBodyGetLinearVel(ball)) - Vector3d(0, 0, 3 * e)).norm(), 0, 1e-12);
  }
}

void check_refused() {
  const auto refused = [](const Bounce& bounce, const char* message) {
    Lying level;
    level.world.sphere(1, radius, {0, 0, radius});
    AccurateStep step(level.world.id, level.world.space, touching(bounce));
    CHECK_THROWS(step(1e-3), AccurateStepError, message);
  };
  for (const double bad : {-0.1, std::nan(""), HUGE_VAL}) {
    refused({.rho = bad}, "a coefficient of rolling friction must be 0 m or more and finite, not ");
    refused({.rhoN = bad}, "a coefficient of spinning friction must be 0 m or more and finite, not ");
  }
}

}  // namespace

int main() {
  for (const double degrees : {0.0, 17.0, 45.0}) {
    check_rolls_to_rest("ball", 0.4, degrees * M_PI / 180, 1e-3, true);
    check_rolls_to_rest("cylinder", 0.5, degrees * M_PI / 180, 1e-3, false);
  }
  check_rolls_to_rest("ball", 0.4, 0, 7e-3, true);
  for (const double h : {1e-3, 7e-3}) {
    check_spins_to_rest("ball", h, [](Lying& on, double mass) { return on.world.sphere(mass, 0.1, {0, 0, 0.1}); });
    check_spins_to_rest("box", h, [](Lying& on, double mass) {
      return on.world.box(mass, {0.4, 0.3, 0.2}, {0, 0, 0.1});
    });
    check_spins_to_rest("cylinder", h, [](Lying& on, double mass) {
      return on.cylinder(mass, 0.2, 0.3, {0, 0, 0.15}, Quaterniond::Identity());
    });
  }
  check_slope();
  check_impact();
  check_refused();
  return odeval::test::verdict();
}
