// Motors that push through contacts: a motor within its limits is a row of the contacts' problem. Loads are constant
// here, and so closed forms hold at any step.
#include <cstdio>
#include <functional>
#include <string>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepOptions;
using odeval::Bounce;

constexpr double g = 9.81;
const std::vector<double> steps{1e-3, 5e-3, 1e-2};

AccurateStepOptions rubbing(double friction) {
  AccurateStepOptions options;
  options.contact = [friction](dGeomID, dGeomID) { return std::optional(Bounce{0, friction}); };
  return options;
}

dJointID driven_slider(World& world, dBodyID body, dBodyID other, const Vector3d& axis, double speed, double most) {
  const dJointID joint = world.slider(body, other, axis);
  dJointSetSliderParam(joint, dParamVel, speed);
  dJointSetSliderParam(joint, dParamFMax, most);
  return joint;
}

/// A finger of 0.2 kg pushes a box of 5 kg with 20 N against 15 N up to its speed, and then keeps it.
void check_push(double h) {
  constexpr double most = 20, load = 15, acceleration = (most - load) / 5.2, speed = acceleration * 0.1;
  World world(Vector3d::Zero());
  const dBodyID finger = world.sphere(0.2, 0.05, {0, 0, 0}), box = world.box(5, {0.1, 0.1, 0.1}, {0.1, 0, 0});
  const dJointID motor = driven_slider(world, finger, nullptr, {1, 0, 0}, speed, most);
  world.slider(box, nullptr, {1, 0, 0});
  dJointFeedback feedback{};
  dJointSetFeedback(motor, &feedback);
  AccurateStep step(world.id, world.space, rubbing(0));
  double worst_place = 0, worst_speed = 0, worst_force = 0, lost = 0;
  const int reached = static_cast<int>(std::lround(0.1 / h));
  for (int k = 1; k <= 5 * reached; ++k) {
    dBodyAddForce(box, -load, 0, 0);
    step(h);
    const double t = k * h, v = k <= reached ? acceleration * t : speed;
    const double x = k <= reached ? v * t / 2 : speed * (t - 0.05);
    for (const dBodyID body : {finger, box}) {
      worst_speed = std::max(worst_speed, std::fabs(dBodyGetLinearVel(body)[0] - v));
      worst_place = std::max(worst_place, std::fabs(dBodyGetPosition(body)[0] - (body == box ? 0.1 : 0) - x));
    }
    // The first step begins with an impact; in the one that ends at the speed the motor may be on either side.
    const double force = k <= reached ? most : load;
    if (k > 1 && k != reached) worst_force = std::max(worst_force, std::fabs(feedback.f1[0] - force));
    lost = std::max(lost, std::fabs(world.energy() - (force == most ? (most - load) * x : 2.6 * speed * speed)));
  }
  std::printf("20 N push 15 N, h = %g: off by %.2g m, %.2g m/s, %.2g N, %.2g J\n", h, worst_place, worst_speed,
              worst_force, lost);
  CHECK_BETWEEN(worst_place, 0, 1e-9);   // what rests is left that deep
  CHECK_BETWEEN(worst_speed, 0, 1e-11);  // rounding, and the impact of what was apart by rounding
  CHECK_BETWEEN(worst_force, 0, 1e-8);   // of the speed, times the mass, in a step
  CHECK_BETWEEN(lost, 0, 1e-9);
  CHECK_EQUAL(step.crowded_steps(), std::size_t{0});
}

/// Turns or pushes with a limit of 20 towards a box that a fixed joint holds; `arm`: from its turn to where it touches.
struct Press {
  const char* name;
  double arm;
  std::function<void(World&, dBodyID finger, dBodyID base)> build;
};

void drive(dJointID joint, void (*set)(dJointID, int, dReal), int group, double speed, double most = 20) {
  set(joint, dParamVel + group, speed);
  set(joint, dParamFMax + group, most);
}

template <class Create>
dJointID attached(World& world, Create create, dBodyID a, dBodyID b) {
  const dJointID joint = create(world.id, nullptr);
  dJointAttach(joint, a, b);
  return joint;
}

/// The finger is a ball at the origin, the box is on its right; axes of turns are half a metre below it, along y.
std::vector<Press> presses() {
  constexpr double held = 1000;
  std::vector<Press> all;
  all.push_back({"slider", 0, [](World& w, dBodyID finger, dBodyID base) {
                   drive(w.slider(finger, base, {1, 0, 0}), dJointSetSliderParam, 0, 0.3);
                 }});
  all.push_back({"hinge", 0.5, [](World& w, dBodyID finger, dBodyID base) {
                   drive(w.hinge(finger, base, {0, 0, -0.5}, {0, 1, 0}), dJointSetHingeParam, 0, 0.3);
                 }});
  all.push_back({"universal joint", 0.5, [](World& w, dBodyID finger, dBodyID base) {
                   const dJointID joint = w.universal(finger, base, {0, 0, -0.5}, {0, 1, 0}, {1, 0, 0});
                   drive(joint, dJointSetUniversalParam, 0, 0.3);
                   drive(joint, dJointSetUniversalParam, 0x100, 0, held);
                 }});
  all.push_back({"piston's way", 0, [](World& w, dBodyID finger, dBodyID base) {
                   const dJointID joint = attached(w, dJointCreatePiston, finger, base);
                   dJointSetPistonAxis(joint, 1, 0, 0);
                   drive(joint, dJointSetPistonParam, 0, 0.3);
                   drive(joint, dJointSetPistonParam, 0x100, 0, held);
                 }});
  all.push_back({"PR's turn", 0.5, [](World& w, dBodyID finger, dBodyID base) {
                   const dJointID joint = attached(w, dJointCreatePR, finger, base);
                   dJointSetPRAnchor(joint, 0, 0, -0.5);
                   dJointSetPRAxis1(joint, 0, 0, 1);
                   dJointSetPRAxis2(joint, 0, 1, 0);
                   drive(joint, dJointSetPRParam, 0, 0, held);
                   drive(joint, dJointSetPRParam, 0x100, 0.3);
                 }});
  all.push_back({"PU's way", 0, [](World& w, dBodyID finger, dBodyID base) {
                   const dJointID joint = attached(w, dJointCreatePU, finger, base);
                   dJointSetPUAnchor(joint, 0, 0, 0);
                   dJointSetPUAxis1(joint, 0, 1, 0);
                   dJointSetPUAxis2(joint, 0, 0, 1);
                   dJointSetPUAxisP(joint, 1, 0, 0);
                   for (const int of : {0, 0x100}) drive(joint, dJointSetPUParam, of, 0, held);
                   drive(joint, dJointSetPUParam, 0x200, 0.3);
                 }});
  all.push_back({"hinge2's steering", 0.5, [](World& w, dBodyID finger, dBodyID base) {
                   const dJointID joint = attached(w, dJointCreateHinge2, finger, base);
                   dJointSetHinge2Anchor(joint, 0, 0, -0.5);
                   const dReal steering[] = {0, 1, 0, 0}, wheel[] = {1, 0, 0, 0};
                   dJointSetHinge2Axes(joint, steering, wheel);
                   drive(joint, dJointSetHinge2Param, 0, 0.3);
                   drive(joint, dJointSetHinge2Param, 0x100, 0, held);
                 }});
  all.push_back({"angular motor", 0.5, [](World& w, dBodyID finger, dBodyID base) {
                   w.ball(finger, base, {0, 0, -0.5});
                   const dJointID joint = attached(w, dJointCreateAMotor, finger, base);
                   dJointSetAMotorNumAxes(joint, 3);
                   for (int k = 0; k < 3; ++k) {
                     dJointSetAMotorAxis(joint, k, 1, k == 0 ? 1 : 0, k == 1 ? 1 : 0, k == 2 ? 1 : 0);
                     drive(joint, dJointSetAMotorParam, 0x100 * k, k == 1 ? 0.3 : 0, k == 1 ? 20 : held);
                   }
                 }});
  all.push_back({"linear motor", 0, [](World& w, dBodyID finger, dBodyID base) {
                   const dJointID joint = attached(w, dJointCreateLMotor, finger, base);
                   dJointSetLMotorNumAxes(joint, 3);
                   for (int k = 0; k < 3; ++k) {
                     dJointSetLMotorAxis(joint, k, 0, k == 0 ? 1 : 0, k == 1 ? 1 : 0, k == 2 ? 1 : 0);
                     drive(joint, dJointSetLMotorParam, 0x100 * k, k == 0 ? 0.3 : 0, k == 0 ? 20 : held);
                   }
                 }});
  return all;
}

/// Every kind of motor flies against the box, rests there, and the box is pushed with just the motor's limit.
void check_press(const Press& press, double h) {
  World world(Vector3d::Zero());
  const dBodyID finger = world.sphere(0.2, 0.05, {0, 0, 0}), box = world.box(5, {0.1, 0.1, 0.1}, {0.11, 0, 0});
  const dBodyID base = world.box(1, {0.01, 0.01, 0.01}, {-1, 0, 0});
  press.build(world, finger, base);
  dJointFeedback of_box{}, of_base{};
  dJointSetFeedback(world.fixed(box, nullptr), &of_box);
  dJointSetFeedback(world.fixed(base, nullptr), &of_base);
  AccurateStepOptions options = rubbing(0);
  options.lmotor_axis_rel = [](dJointID, int) { return 0; };
  AccurateStep step(world.id, world.space, options);
  std::size_t touches = 0;
  for (int k = 0; k * h < 0.2; ++k) {
    step(h);
    if (k * h > 0.1) touches += step.touches().size();
  }
  const double lever = press.arm + dBodyGetPosition(finger)[2], speed = vec(dBodyGetLinearVel(finger)).norm();
  const double wanted = press.arm > 0 ? 20 / lever : 20;
  std::printf("%-18s presses, h = %g: box bears %.10f N, finger %.2g m/s, %zu touches\n", press.name, h, -of_box.f1[0],
              speed, touches);
  CHECK_NEAR(-of_box.f1[0], wanted, 1e-8);
  CHECK_NEAR(of_base.f1[0] + of_box.f1[0], 0, 1e-8);  // between them all is at rest
  CHECK_BETWEEN(speed, 0, 1e-10);
  CHECK_EQUAL(touches, std::size_t{0});
  CHECK_EQUAL(step.crowded_steps(), std::size_t{0});
}

/// Two fingers hold a box in the air as long as 2 mu F bears it; then it slides down as Coulomb says.
void check_grip(double h, double share) {
  constexpr double friction = 0.6, mass = 0.5;
  const double most = share * mass * g / (2 * friction);
  World world;
  const dBodyID box = world.box(mass, {0.1, 0.1, 0.1}, {0, 0, 0});
  const dBodyID carriage = world.box(2, {0.4, 0.1, 0.05}, {0, 0, 0.5});
  const dJointID lift = driven_slider(world, carriage, nullptr, {0, 0, 1}, 0, 200);
  for (const double side : {-1, 1}) {
    const dBodyID finger = world.box(0.2, {0.02, 0.06, 0.06}, {side * 0.06, 0, 0});
    driven_slider(world, finger, carriage, {side, 0, 0}, -0.1, most);
  }
  dJointFeedback feedback{};
  dJointSetFeedback(lift, &feedback);
  AccurateStep step(world.id, world.space, rubbing(friction));
  const double falls = share < 1 ? (1 - share) * g : 0;
  double worst = 0, place = 0, speed = 0, first = 0;
  for (int k = 1; k * h < 0.25; ++k) {
    step(h);
    const double z = dBodyGetPosition(box)[2], v = dBodyGetLinearVel(box)[2], t = k * h - first;
    CHECK_NEAR(dBodyGetLinearVel(carriage)[2], 0, 1e-12);
    CHECK_NEAR(dBodyGetPosition(carriage)[2], 0.5, 1e-8);  // pushed out of the first overlaps
    if (k > 1) CHECK_NEAR(feedback.f1[2], 2.4 * g + mass * (g - falls), 1e-7);
    if (k == 2) {  // from where all touch, and have been pushed out
      place = z, speed = v, first = k * h;
      CHECK_NEAR(v, -falls * k * h, 1e-5);  // the box falls freely until it touches, 1e-6 s
    } else if (k > 2) {
      worst = std::max(worst, std::fabs(z - (place + speed * t - falls * t * t / 2)));
    }
  }
  std::printf("grip of %.2f of the weight, h = %g: box off by %.2g m\n", share, h, worst);
  CHECK_BETWEEN(worst, 0, 1e-9);
  CHECK_EQUAL(step.crowded_steps(), std::size_t{0});
}

/// A platform goes up with a box that sticks and a ball that lies on it.
void check_platform(double h) {
  constexpr double speed = 0.2;
  World world;
  const dBodyID platform = world.box(10, {1, 1, 0.1}, {0, 0, 0});
  world.box(3, {0.2, 0.2, 0.2}, {0.2, 0, 0.15});
  world.sphere(2, 0.1, {-0.2, 0.1, 0.15});
  const dJointID lift = driven_slider(world, platform, nullptr, {0, 0, 1}, speed, 1000);
  dJointFeedback feedback{};
  dJointSetFeedback(lift, &feedback);
  for (const dBodyID body : world.bodies) World::move(body, {0, 0, speed}, {0, 0, 0});
  AccurateStep step(world.id, world.space, rubbing(0.5));
  double worst_speed = 0, worst_place = 0, worst_force = 0;
  for (int k = 1; k * h < 1; ++k) {
    step(h);
    worst_speed = std::max(worst_speed, std::fabs(dBodyGetLinearVel(platform)[2] - speed));
    worst_place = std::max(worst_place, std::fabs(dBodyGetPosition(platform)[2] - speed * k * h));
    if (k > 1) worst_force = std::max(worst_force, std::fabs(feedback.f1[2] - 15 * g));
  }
  std::printf("platform, h = %g: off by %.2g m/s, %.2g m, %.2g N\n", h, worst_speed, worst_place, worst_force);
  CHECK_BETWEEN(worst_speed, 0, 1e-12);
  CHECK_BETWEEN(worst_place, 0, 1e-8);  // what lies on it is left 1e-9 m deep, from its first step on
  CHECK_BETWEEN(worst_force, 0, 1e-7);
}

/// A platform on which a box lies without friction goes up faster and faster, its motor's velocity set anew for each
/// step: the way is that of a velocity that grows evenly in each. What the motor gave in the step before is what it
/// begins with, and what it gives besides is paid by it.
void check_servo(double h) {
  World world;
  const dBodyID platform = world.box(10, {1, 1, 0.1}, {0, 0, 0});
  world.box(3, {0.2, 0.2, 0.2}, {0.2, 0, 0.15});
  const dJointID lift = driven_slider(world, platform, nullptr, {0, 0, 1}, 0, 1000);
  AccurateStep step(world.id, world.space, rubbing(0));
  double speed = 0, place = 0, worst = 0;
  for (int k = 1; k * h < 0.5; ++k) {
    const double next = 2 * k * h * k * h;
    dJointSetSliderParam(lift, dParamVel, next);
    step(h);
    place += h * (speed + next) / 2;
    speed = next;
    worst = std::max(worst, std::fabs(dBodyGetPosition(platform)[2] - place));
    CHECK_NEAR(dBodyGetLinearVel(platform)[2], speed, 1e-12);
  }
  std::printf("platform faster and faster, h = %g: off by %.2g m\n", h, worst);
  CHECK_BETWEEN(worst, 0, 1e-9 + 1.5 * h * h * h);  // of the third order: half of that measured
}

/// The load on a platform that holds still, with a box on it, grows beyond what its motor bears, within a step.
void check_overload(double h) {
  constexpr double limit = 13 * g + 50.5, rate = 1000;
  World world;
  const dBodyID platform = world.box(10, {1, 1, 0.1}, {0, 0, 0});
  world.box(3, {0.2, 0.2, 0.2}, {0.2, 0, 0.15 - 1e-9});  // as deep as what rests
  dJointFeedback feedback{};
  dJointSetFeedback(driven_slider(world, platform, nullptr, {0, 0, 1}, 0, limit), &feedback);
  AccurateStepOptions options = rubbing(0);
  double begin = 0, most = 0, worst = 0;
  options.forces = [&](double t) { dBodyAddForce(platform, 0, 0, -rate * (begin + t)); };
  AccurateStep step(world.id, world.space, options);
  for (int k = 1; k * h < 0.1; ++k) {
    step(h);
    begin = k * h;
    most = std::max(most, feedback.f1[2]);
    const double late = std::max(0.0, begin - 50.5 / rate);
    worst = std::max(worst, std::fabs(dBodyGetPosition(platform)[2] + rate * late * late * late / (6 * 13)));
  }
  std::printf("platform overloaded, h = %g: off by %.2g m, force above its limit by %.2g N\n", h, worst, most - limit);
  CHECK_NEAR(most, limit, 1e-9);
  CHECK_BETWEEN(worst, 0, 1e-12);  // a cubic, which the formula meets; beyond its limit within one step: 1e-5
}

/// A platform that a motor holds, with a box that just touches it and comes off it within the step, as a load grows:
/// the motor bears the box where it is met again on a way out.
void check_met_again(double h) {
  World world;
  const dBodyID platform = world.box(10, {1, 1, 0.1}, {0, 0, 0});
  world.box(3, {0.2, 0.2, 0.2}, {0.2, 0, 0.15});
  driven_slider(world, platform, nullptr, {0, 0, 1}, 0, 1000);
  AccurateStepOptions options = rubbing(0);
  double begin = 0;
  options.forces = [&](double t) { dBodyAddForce(platform, 0, 0, -(begin + t)); };
  AccurateStep step(world.id, world.space, options);
  for (int k = 1; k * h < 0.1; ++k) {
    step(h);
    begin = k * h;
    CHECK_NEAR(dBodyGetLinearVel(platform)[2], 0, 1e-12);
  }
}

/// A box that stands and sticks is gripped and lifted off: it is held where it stands no more once fingers touch it.
void check_lift_off(double h) {
  World world;
  dGeomSetPosition(dCreateBox(world.space, 0.06, 0.06, 0.4), 0, 0, 0.2);
  const dBodyID box = world.box(0.5, {0.1, 0.1, 0.1}, {0, 0, 0.45});
  const dBodyID carriage = world.box(2, {0.4, 0.1, 0.05}, {0, 0, 0.8});
  // Up to its speed at (60 N - 2.9 kg g) / 2.9 kg: less than the 38 m/s^2 that the grip bears.
  const dJointID lift = driven_slider(world, carriage, nullptr, {0, 0, 1}, 0, 60);
  for (const double side : {-1, 1}) {
    const dBodyID finger = world.box(0.2, {0.02, 0.06, 0.06}, {side * 0.07, 0, 0.47});
    driven_slider(world, finger, carriage, {side, 0, 0}, -0.1, 20);
  }
  AccurateStep step(world.id, world.space, rubbing(0.6));
  const auto above = [&] { return dBodyGetPosition(carriage)[2] - dBodyGetPosition(box)[2]; };
  for (int k = 0; k * h < 0.2; ++k) step(h);
  const double gripped = above();
  dJointSetSliderParam(lift, dParamVel, 0.2);
  for (int k = 0; k * h < 0.5; ++k) step(h);
  std::printf("lifted off, h = %g: slips by %.2g m\n", h, above() - gripped);
  CHECK_NEAR(above(), gripped, 1e-8);  // pushed out of the overlap with the post
  CHECK(dBodyGetPosition(box)[2] > 0.53);
}

/// Fingers press on a static post and on the box that stands on it, both at once.
void check_post(double h) {
  World world;
  dGeomSetPosition(dCreateBox(world.space, 0.1, 0.1, 0.4), 0, 0, 0.2);
  const dBodyID box = world.box(0.5, {0.1, 0.1, 0.1}, {0, 0, 0.45});
  std::vector<dBodyID> fingers;
  dJointFeedback feedback[2] = {};
  for (const double side : {-1, 1}) {
    fingers.push_back(world.box(0.2, {0.02, 0.06, 0.2}, {side * 0.07, 0, 0.47}));
    dJointSetFeedback(driven_slider(world, fingers.back(), nullptr, {side, 0, 0}, -0.1, 20),
                      &feedback[fingers.size() - 1]);
  }
  AccurateStep step(world.id, world.space, rubbing(0.6));
  for (int k = 0; k * h < 1; ++k) step(h);
  CHECK_NEAR((vec(dBodyGetPosition(box)) - Vector3d(0, 0, 0.45)).norm(), 0, 1e-8);
  CHECK_EQUAL(step.crowded_steps(), std::size_t{0});
  CHECK(step.touches().empty());
  for (const int i : {0, 1}) {
    const double side = i == 0 ? -1 : 1;
    CHECK_NEAR(dBodyGetPosition(fingers[static_cast<std::size_t>(i)])[0], side * 0.06, 1e-8);
    // The motor and what it presses on, in balance: the slider holds the finger's weight alone.
    CHECK_NEAR(feedback[i].f1[0], -side * 20, 1e-7);
  }
}

/// A finger on an arm, its motor always at its limit, sweeps a ball away round a bend: where contacts are met again on
/// ways out the motor has given what it can, and gives it once. All energy is its work, limit times turn.
void check_sweep(double h) {
  constexpr double most = 2;
  World world(Vector3d::Zero());
  const dBodyID finger = world.sphere(0.2, 0.05, {0.3, 0, 0});
  world.sphere(1, 0.1, {0.3 + 0.15 * std::sin(0.4), 0.15 * std::cos(0.4), 0});
  const dJointID arm = world.hinge(finger, nullptr, {0, 0, 0}, {0, 0, 1});
  drive(arm, dJointSetHingeParam, 0, 100, most);
  AccurateStep step(world.id, world.space, rubbing(0));
  double turned = 0, last = dJointGetHingeAngle(arm), worst = 0;
  for (double t = 0; t < 0.3; t += h) {
    step(h);
    turned += std::remainder(dJointGetHingeAngle(arm) - last, 2 * M_PI);
    last = dJointGetHingeAngle(arm);
    worst = std::max(worst, std::fabs(world.energy() - most * std::fabs(turned)));
  }
  std::printf("sweep, h = %g: %.4g J, off by %.2g J\n", h, world.energy(), worst);
  CHECK(world.energy() > 4);
  CHECK_BETWEEN(worst, 0, 2 * h);  // first order, h measured; 0.5 J where it gives what it can twice
}

/// A motor drives a plough through boxes that rub on the ground: all energy comes from it.
void check_energy(double h, int boxes) {
  constexpr double limit = 30;
  World world;
  dCreatePlane(world.space, 0, 0, 1, 0);
  const dBodyID plough = world.box(1, {0.1, 0.6, 0.2}, {-0.3, 0, 0.15});
  const dJointID motor = driven_slider(world, plough, nullptr, {1, 0, 0}, 0.5, limit);
  const Vector3d places[] = {{0, 0.05, 0.1}, {0.3, -0.05, 0.1}, {0.1, 0, 0.3}};
  for (int i = 0; i < boxes; ++i) world.box(1, {0.2, 0.2, 0.2}, places[i]);
  dJointFeedback feedback{};
  dJointSetFeedback(motor, &feedback);
  AccurateStep step(world.id, world.space, rubbing(0.5));
  const double at_first = world.energy();
  double work = 0, gained = -1, most = 0;
  std::size_t crowded = 0;
  for (int k = 0; k * h < 2; ++k) {
    const double before = dBodyGetPosition(plough)[0];
    step(h);
    // Where an impact parts the step, the motor reaches its speed in it or contacts crowd: at most its limit.
    const bool even = step.touches().empty() && step.crowded_steps() == crowded && k * h > 0.05;
    crowded = step.crowded_steps();
    work += (even ? feedback.f1[0] : limit) * (dBodyGetPosition(plough)[0] - before);
    gained = std::max(gained, world.energy() - at_first - work);
    most = std::max(most, world.energy() - at_first);
  }
  std::printf("plough of %d, h = %g: %.3f J of work, at most %.3f J kept, never %.2g J more than work; %zu crowded\n",
              boxes, h, work, most, gained, crowded);
  CHECK_BETWEEN(gained, -1, 1e-8);  // lifted by what rest leaves of overlaps, 1e-9 m times the weight
  CHECK(most > 0.1);
}

/// Newton's and Euler's laws of both bodies by the forces that are told, of a motor that pushes with its limit: its
/// line passes beside the centre of the second.
void check_balance(const char* name, const std::function<dJointID(World&, dBodyID, dBodyID)>& build) {
  constexpr double h = 1e-5;
  World world(Vector3d::Zero());
  const dBodyID one = world.box(1, {0.3, 0.2, 0.1}, {0, 0, 0});
  const dBodyID other = world.box(2, {0.1, 0.2, 0.3}, {1, 0.2, -0.3});
  const dJointID joint = build(world, one, other);
  dJointFeedback feedback{};
  dJointSetFeedback(joint, &feedback);
  AccurateStepOptions options;
  options.lmotor_axis_rel = [](dJointID, int) { return 0; };
  AccurateStep step(world.id, world.space, options);
  step(h);
  const auto check = [&](dBodyID body, const dReal* force, const dReal* torque) {
    // From rest: what turns with the bodies is of the second order in the step.
    const Vector3d change = World::mass(body) * vec(dBodyGetLinearVel(body)) / h;
    const Vector3d turn = World::inertia(body) * vec(dBodyGetAngularVel(body)) / h;
    CHECK_NEAR((vec(force) - change).norm(), 0, 1e-4);
    CHECK_NEAR((vec(torque) - turn).norm(), 0, 1e-4);
    return turn.norm();
  };
  check(one, feedback.f1, feedback.t1);
  const double turned = check(other, feedback.f2, feedback.t2);
  std::printf("%s at its limit: torque of %.3f N m on the second body\n", name, turned);
  CHECK(turned > 0.1);
}

void check_balances() {
  check_balance("piston", [](World& w, dBodyID a, dBodyID b) {
    const dJointID joint = attached(w, dJointCreatePiston, a, b);
    dJointSetPistonAnchor(joint, 0.3, 0.5, 0.1);
    dJointSetPistonAxis(joint, 1, 0, 0);
    drive(joint, dJointSetPistonParam, 0, 5, 20);
    return joint;
  });
  check_balance("PU", [](World& w, dBodyID a, dBodyID b) {
    const dJointID joint = attached(w, dJointCreatePU, a, b);
    dJointSetPUAnchor(joint, 0.3, 0.5, 0.1);
    dJointSetPUAxis1(joint, 0, 1, 0);
    dJointSetPUAxis2(joint, 0, 0, 1);
    dJointSetPUAxisP(joint, 1, 0, 0);
    drive(joint, dJointSetPUParam, 0x200, 5, 20);
    return joint;
  });
  check_balance("linear motor", [](World& w, dBodyID a, dBodyID b) {
    const dJointID joint = attached(w, dJointCreateLMotor, a, b);
    dJointSetLMotorNumAxes(joint, 1);
    dJointSetLMotorAxis(joint, 0, 0, 0, 1, 0);
    drive(joint, dJointSetLMotorParam, 0, 5, 20);
    return joint;
  });
}

}  // namespace

int main() {
  for (const double h : steps) {
    check_push(h);
    for (const Press& press : presses()) check_press(press, h);
    for (const double share : {1.01, 0.9}) check_grip(h, share);
    check_platform(h);
    check_servo(h);
    check_overload(h);
    check_met_again(h);
    check_sweep(h);
    check_post(h);
    check_lift_off(h);
    for (const int boxes : {1, 3}) check_energy(h, boxes);
  }
  check_balances();
  return odeval::test::verdict();
}
