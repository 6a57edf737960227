// Coulomb's friction: sliding, sticking and rolling by closed forms, the same in every direction.
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <cstdio>
#include <functional>

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

AccurateStepOptions rubbing(double friction, double restitution = 0) {
  AccurateStepOptions options;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(Bounce{restitution, friction}); };
  return options;
}

/// Gravity as on a plane z = 0 that slopes down along x.
Vector3d sloped(double angle) { return {g * std::sin(angle), 0, -g * std::cos(angle)}; }

/// Largest error of a motion along x over all steps, and of its speed.
struct Errors {
  double place = 0, speed = 0;
};

/// A sphere thrown without spin slides until 2 v / (7 mu g), then rolls at 5/7 of its speed.
void check_thrown_sphere(double h) {
  constexpr double radius = 0.1, v = 3, mu = 0.3;
  World world;
  const dBodyID ball = world.sphere(2, radius, {0, 0, radius});
  dCreatePlane(world.space, 0, 0, 1, 0);
  World::move(ball, {v, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space, rubbing(mu));
  const double rolls = 2 * v / (7 * mu * g);
  Errors errors;
  double late = 0;
  for (int k = 1; k * h < 1; ++k) {
    step(h);
    const double t = k * h, x = dBodyGetPosition(ball)[0], speed = dBodyGetLinearVel(ball)[0];
    const double slid = std::min(t, rolls);
    errors.place =
        std::max(errors.place, std::fabs(x - (v * slid - mu * g * slid * slid / 2 + 5 * v / 7 * (t - slid))));
    errors.speed = std::max(errors.speed, std::fabs(speed - (v - mu * g * slid)));
    if (t > rolls) late = std::max(late, std::fabs(dBodyGetAngularVel(ball)[1] - 5 * v / (7 * radius)));
  }
  std::printf("thrown sphere, h = %g: error %.2g m, %.2g m/s, spin %.2g rad/s\n", h, errors.place, errors.speed, late);
  CHECK_BETWEEN(errors.place, 0, 1e-9);
  CHECK_BETWEEN(errors.speed, 0, 1e-9);
  CHECK_BETWEEN(late, 0, 1e-8);
}

/// A box that slides to a stop, at an angle to its axes.
void check_sliding_box(double degrees) {
  constexpr double v = 2, mu = 0.4, h = 1e-3;
  const double angle = degrees * M_PI / 180;
  const Vector3d along(std::cos(angle), std::sin(angle), 0);
  World world;
  const dBodyID box = world.box(1.5, {0.4, 0.3, 0.2}, {0, 0, 0.1});
  dCreatePlane(world.space, 0, 0, 1, 0);
  World::move(box, v * along, {0, 0, 0});
  AccurateStep step(world.id, world.space, rubbing(mu));
  for (int k = 0; k < 1000; ++k) step(h);
  const Vector3d wanted = v * v / (2 * mu * g) * along;
  const Vector3d error = vec(dBodyGetPosition(box)) - wanted - Vector3d(0, 0, 0.1);
  std::printf("box thrown at %g degrees: off by %.2g m, turned by %.2g\n", degrees, error.norm(),
              World::turn(box).vec().norm());
  // Forces are constant, so that only rounding is left: 1e-12 measured, times a thousand.
  CHECK_BETWEEN(error.norm(), 0, 1e-9);
  CHECK_BETWEEN(World::turn(box).vec().norm(), 0, 1e-9);
  CHECK_BETWEEN(vec(dBodyGetLinearVel(box)).norm(), 0, 1e-12);
}

/// Just below the angle of friction a box stays; just above it slides as the closed form says.
void check_slope() {
  constexpr double mu = 0.5, h = 1e-3;
  for (const double factor : {0.999, 1.001, 1.2}) {
    const double angle = std::atan(mu * factor);
    World world(sloped(angle));
    const dBodyID box = world.box(1, {0.4, 0.3, 0.2}, {0, 0, 0.1});
    dCreatePlane(world.space, 0, 0, 1, 0);
    AccurateStep step(world.id, world.space, rubbing(mu));
    const int steps = factor < 1 ? 10000 : 1000;
    for (int k = 0; k < steps; ++k) step(h);
    const double t = steps * h;
    const double wanted = factor < 1 ? 0 : (std::sin(angle) - mu * std::cos(angle)) * g * t * t / 2;
    const double x = dBodyGetPosition(box)[0];
    std::printf("box on a slope of %g times its angle of friction: %.9f m after %g s, off by %.2g m\n", factor, x, t,
                x - wanted);
    CHECK_NEAR(x, wanted, factor < 1 ? 1e-10 : 1e-8);
  }
}

/// Down a slope without sliding: 5/7 of what sliding would be.
void check_rolling() {
  constexpr double radius = 0.1, angle = 0.2, h = 1e-3;
  World world(sloped(angle));
  const dBodyID ball = world.sphere(1, radius, {0, 0, radius});
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, rubbing(0.5));
  for (int k = 0; k < 1000; ++k) step(h);
  const double a = 5.0 / 7 * g * std::sin(angle);
  CHECK_NEAR(dBodyGetPosition(ball)[0], a / 2, 1e-8);
  CHECK_NEAR(dBodyGetLinearVel(ball)[0], a, 1e-9);
  CHECK_NEAR(dBodyGetAngularVel(ball)[1], a / radius, 1e-8);
  std::printf("rolling sphere: off by %.2g m, %.2g m/s\n", dBodyGetPosition(ball)[0] - a / 2,
              dBodyGetLinearVel(ball)[0] - a);
}

/// Balls thrown on a body's box, that come to roll one after the other within steps: each at 5/7 of its speed, or at
/// 2/7 of that of a box that moves under it; and as deep as what rests at the end of every step.
void check_balls_on_a_box(double box_speed, double drop) {
  constexpr double radius = 0.1, mu = 0.3, h = 1e-2;
  World world;
  const dBodyID box = world.box(1, {60, 60, 0.5}, {0, 0, -0.25});
  dBodySetKinematic(box);
  World::move(box, {box_speed, 0, 0}, {0, 0, 0});
  std::vector<dBodyID> balls;
  for (int k = 0; k < 4; ++k) {
    balls.push_back(world.sphere(1, radius, {0, 0.5 * k, radius + drop * (1 + k)}));
    if (box_speed == 0) World::move(balls.back(), {1 - 0.17 * k, 0, 0}, {0, 0, 0});
  }
  AccurateStep step(world.id, world.space, rubbing(mu));
  double deepest = 0, worst = 0;
  for (int k = 0; k < 80; ++k) {
    step(h);
    for (const dBodyID ball : balls) deepest = std::max(deepest, radius - dBodyGetPosition(ball)[2]);
  }
  for (int k = 0; k < 4; ++k) {
    const dBodyID ball = balls[static_cast<std::size_t>(k)];
    const double speed = box_speed == 0 ? 5 * (1 - 0.17 * k) / 7 : 2 * box_speed / 7;
    worst = std::max(worst, std::fabs(dBodyGetLinearVel(ball)[0] - speed));
    worst = std::max(worst, std::fabs(radius * dBodyGetAngularVel(ball)[1] - (speed - box_speed)));
  }
  std::printf("balls on a box, %g m/s, from %g m: speeds off by %.2g m/s, %.2g m deep\n", box_speed, drop, worst,
              deepest);
  // In the two steps in which a ball comes to rest it has fallen by up to g h^2 / 2 where its friction is found, whose
  // arm is so much shorter: 10/7 mu g h of its fall by its radius, 2e-4 m/s. Belt and impact together: 6e-4 measured.
  CHECK_BETWEEN(worst, 0, 5 * 10.0 / 7 * mu * g * h * (g * h * h / 2 / radius));
  CHECK_BETWEEN(deepest, 0, 1e-8);
}

/// A cylinder or a capsule that lies across a slope: 2/3 of what sliding would be, or what its inertia says.
void check_rolling_on_a_line(bool capsule) {
  constexpr double radius = 0.1, length = 0.4, angle = 0.2, h = 1e-3;
  World world(sloped(angle));
  const dBodyID roll = dBodyCreate(world.id);
  dMass mass;
  if (capsule) {
    dMassSetCapsuleTotal(&mass, 2, 3, radius, length);
  } else {
    dMassSetCylinderTotal(&mass, 2, 3, radius, length);
  }
  dBodySetMass(roll, &mass);
  World::place(roll, {0, 0, radius}, Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX())));
  const dGeomID geom =
      capsule ? dCreateCapsule(world.space, radius, length) : dCreateCylinder(world.space, radius, length);
  dGeomSetBody(geom, roll);
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, rubbing(0.5));
  for (int k = 0; k < 1000; ++k) step(h);
  const double a = g * std::sin(angle) / (1 + mass.I[10] / (2 * radius * radius));
  std::printf("rolling %s: off by %.2g m, %.2g m/s\n", capsule ? "capsule" : "cylinder",
              dBodyGetPosition(roll)[0] - a / 2, dBodyGetLinearVel(roll)[0] - a);
  CHECK_NEAR(dBodyGetPosition(roll)[0], a / 2, 1e-8);
  CHECK_NEAR(dBodyGetLinearVel(roll)[0], a, 1e-9);
  CHECK_NEAR(dBodyGetAngularVel(roll)[1], a / radius, 1e-8);
}

/// A cube let go on its edge, a little beyond balance, topples about the edge until its face lands: an inverted
/// pendulum, whose angle from below is 2 asin(k sn(K - w t)).
struct Toppling {
  static constexpr double side = 0.5, from = 0.05;  // m, rad from balance
  const double l = side / std::sqrt(2);             // from the edge to the centre
  const double w = std::sqrt(1.5 * g / (2 * l));    // the inertia about the edge is 4/3 m l^2 of a square
  const double k = std::cos(from / 2), whole = std::comp_ellint_1(k);

  double angle(double t) const { return M_PI - 2 * std::asin(k * boost::math::jacobi_sn(k, whole - w * t)); }
  double spin(double t) const { return 2 * w * k * boost::math::jacobi_cn(k, whole - w * t); }
  double lands() const { return (whole - std::ellint_1(k, std::asin(std::sin(3 * M_PI / 8) / k))) / w; }

  /// From the last face that it lay on.
  static double tilt(dBodyID cube) {
    const Vector3d up = World::turn(cube).inverse() * Vector3d::UnitZ();
    return std::remainder(std::atan2(-up[0], up[2]), M_PI / 2);
  }

  /// Largest errors of its spin, and of the moment at which it lands.
  Errors errors(double h, bool on_a_box) const {
    World world;
    const Quaterniond turn(Eigen::AngleAxisd(M_PI / 4 + from, Vector3d::UnitY()));
    const dBodyID cube = world.box(2, {side, side, side}, {l * std::sin(from), 0, l * std::cos(from)}, turn);
    if (on_a_box) {
      dGeomSetPosition(dCreateBox(world.space, 4, 4, 1), 0, 0, -0.5);
    } else {
      dCreatePlane(world.space, 0, 0, 1, 0);
    }
    AccurateStep step(world.id, world.space, rubbing(1));
    Errors errors;
    for (int n = 0;; ++n) {
      step(h);
      if (n > 0 && !step.touches().empty()) {
        errors.place = std::fabs(n * h + step.touches().front().t - lands());
        break;
      }
      const double t = (n + 1) * h;
      errors.speed = std::max(errors.speed, std::fabs(dBodyGetAngularVel(cube)[1] - spin(t)));
      if (t > 2) break;  // it never does
    }
    // It rocks on over its other edge, with a quarter of its spin, which is what is left of its angular momentum about
    // that (Housner, Bull. Seismol. Soc. Am. 53, 1963), and in the end lies.
    const double squared = std::pow(spin(lands()) / 4, 2);
    for (int n = 0; n < 3; ++n) {
      const double now = M_PI / 4 - tilt(cube);
      const double wanted = squared + 3 * g / (2 * l) * (std::cos(M_PI / 4) - std::cos(now));
      CHECK_NEAR(std::pow(dBodyGetAngularVel(cube)[1], 2), wanted, h > 1e-3 ? 1e-5 : 1e-9);
      step(h);
    }
    for (double t = 0; t < 2; t += h) step(h);
    CHECK_NEAR(dBodyGetPosition(cube)[2], side / 2, 1e-8);
    CHECK_BETWEEN(vec(dBodyGetAngularVel(cube)).norm(), 0, 1e-9);
    return errors;
  }
};

void check_toppling() {
  for (const bool on_a_box : {false, true}) {
    const Toppling toppling;
    const Errors coarse = toppling.errors(2e-2, on_a_box), middle = toppling.errors(1e-2, on_a_box);
    const Errors fine = toppling.errors(1e-3, on_a_box);
    std::printf(
        "toppling cube: spin off by %.2g rad/s, landing by %.2g s at h = 0.001; at 0.02 %.2g, %.2g; order %.2f\n",
        fine.speed, fine.place, coarse.speed, coarse.place, order(coarse.speed, middle.speed, 2));
    CHECK_BETWEEN(fine.speed, 0, 1e-9);
    CHECK_BETWEEN(fine.place, 0, 1e-9);
    CHECK_BETWEEN(order(coarse.speed, middle.speed, 2), 3.5, 5);
  }
}

/// A ball that comes down aslant with spin: one impact, by hand.
void check_impact() {
  constexpr double radius = 0.1, e = 0.6;
  for (const double mu : {0.05, 2.0}) {  // slides, and sticks
    World world(Vector3d::Zero());
    const dBodyID ball = world.sphere(1, radius, {0, 0, radius + 0.01});
    dCreatePlane(world.space, 0, 0, 1, 0);
    World::move(ball, {2, 1, -3}, {0, 5, 0});
    AccurateStep step(world.id, world.space, rubbing(mu, e));
    step(0.01);
    const Vector3d slip(2 - 5 * radius, 1, 0);  // at the lowest point
    const double most = mu * (1 + e) * 3, needs = 2.0 / 7 * slip.norm();
    const Vector3d push = -std::min(most, needs) * slip.normalized();
    const Vector3d wanted = Vector3d(2, 1, e * 3) + push;
    const Vector3d spin = Vector3d(0, 5, 0) + Vector3d(0, 0, -radius).cross(push) / (0.4 * radius * radius);
    CHECK_NEAR((vec(dBodyGetLinearVel(ball)) - wanted).norm(), 0, 1e-12);
    CHECK_NEAR((vec(dBodyGetAngularVel(ball)) - spin).norm(), 0, 1e-10);
  }
}

/// The edge of a toppling cube stays until it would need more friction than its cone has, and slips then.
void check_edge_slips() {
  constexpr double mu = 0.35, h = 1e-3;
  const Toppling toppling;
  const double l = toppling.l;
  double slips = 0;
  for (bool sticks = true; sticks; slips += 1e-5) {
    const double at = toppling.angle(slips), spin = toppling.spin(slips), turn = toppling.w * toppling.w * std::sin(at);
    const double across = l * (turn * std::cos(at) - spin * spin * std::sin(at));
    sticks = std::fabs(across) <= mu * (g - l * (turn * std::sin(at) + spin * spin * std::cos(at)));
  }
  World world;
  const Quaterniond turn(Eigen::AngleAxisd(M_PI / 4 + Toppling::from, Vector3d::UnitY()));
  const Vector3d start(l * std::sin(Toppling::from), 0, l * std::cos(Toppling::from));
  const dBodyID cube = world.box(2, Vector3d::Constant(Toppling::side), start, turn);
  const Vector3d edge = turn.inverse() * -start;
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStep step(world.id, world.space, rubbing(mu));
  double moved = 0;
  for (int k = 1; k * h < slips + 0.05; ++k) {
    step(h);
    moved = std::fabs((vec(dBodyGetPosition(cube)) + World::turn(cube) * edge)[0]);
    if (k * h < slips - h) CHECK_BETWEEN(moved, 0, 1e-9);
  }
  std::printf("toppling cube: its edge slips at %.4f s, by %.2g m in 0.05 s\n", slips, moved);
  CHECK_BETWEEN(slips, 0.1, toppling.lands() - 0.06);
  CHECK_BETWEEN(moved, 1e-5, 1e-2);
}

/// A ball whose bounces end rests on the ground, neither above it nor in it, whatever the step.
void check_rest_after_bounces() {
  for (const double h : {0.02, 1e-3}) {
    World world;
    const dBodyID ball = world.sphere(1, 0.1, {0, 0, 0.5});
    dCreatePlane(world.space, 0, 0, 1, 0);
    AccurateStep step(world.id, world.space, rubbing(0.5, 0.5));
    for (double t = 0; t < 3; t += h) step(h);
    CHECK_NEAR(dBodyGetPosition(ball)[2], 0.1, 2.1e-9);  // as deep as what rests
    CHECK_NEAR(dBodyGetLinearVel(ball)[2], 0, 1e-15);
  }
}

void check_refused() {
  for (const double friction : {-0.1, std::nan(""), HUGE_VAL}) {
    World world;
    world.sphere(1, 0.1, {0, 0, 0.1});
    dCreatePlane(world.space, 0, 0, 1, 0);
    AccurateStep step(world.id, world.space, rubbing(friction));
    CHECK_THROWS(step(1e-3), AccurateStepError, "a coefficient of friction must be 0 or more and finite, not ");
  }
}

}  // namespace

int main() {
  check_thrown_sphere(1e-3);
  check_thrown_sphere(7e-3);
  for (const double degrees : {0.0, 17.0, 45.0}) check_sliding_box(degrees);
  check_slope();
  check_rolling();
  check_balls_on_a_box(0, 0);
  check_balls_on_a_box(0, 0.001);
  check_balls_on_a_box(2, 0);
  check_balls_on_a_box(2, 0.013);
  check_rolling_on_a_line(false);
  check_rolling_on_a_line(true);
  check_toppling();
  check_edge_slips();
  check_rest_after_bounces();
  check_impact();
  check_refused();
  return odeval::test::verdict();
}
