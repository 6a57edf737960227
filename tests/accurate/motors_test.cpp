// Motors that hold their velocity, reach their limit of force and leave it within a step; stops that bounce. Signs are
// ODE's, by the side of dWorldStep; motions are closed forms.
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepError;
using odeval::AccurateStepOptions;

constexpr double g = 9.81;

/// Two equal boxes beside each other, one of them on a joint to the world or both on one.
struct Pair {
  World world{Vector3d::Zero()};
  dBodyID one = world.box(1, {0.3, 0.2, 0.1}, {0, 0, 0});
  dBodyID other = world.box(1, {0.3, 0.2, 0.1}, {1, 0, 0});
};

/// Reads what ODE reports of a joint after a second under either step.
void check_signs(const char* what, const std::function<std::function<double()>(Pair&, dBodyID, dBodyID)>& build,
                 const std::vector<int>& ways = {0, 1, 2, 3}) {
  for (const int way : ways) {
    const auto after = [&](bool accurate) {
      Pair pair;
      const dBodyID a = way == 1 ? nullptr : pair.one;
      const dBodyID b = way == 0 ? nullptr : way == 1 ? pair.one : pair.other;
      const auto read = way == 3 ? build(pair, b, a) : build(pair, a, b);
      if (accurate) {
        AccurateStep step(pair.world.id, pair.world.space);
        for (int k = 0; k < 1000; ++k) step(1e-3);
      } else {
        for (int k = 0; k < 1000; ++k) dWorldStep(pair.world.id, 1e-3);
      }
      return read();
    };
    const double plain = after(false), ours = after(true);
    std::printf("%-22s attached in way %d: dWorldStep %.4f, accurate %.4f\n", what, way, plain, ours);
    CHECK(std::fabs(plain) > 0.1);
    CHECK_NEAR(ours, plain, 0.02);  // dWorldStep's own first order, and its soft stops
  }
}

void check_all_signs() {
  const Vector3d at(0.2, 0.1, 0), axis(0, 0.6, 0.8);
  check_signs("hinge motor", [&](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = p.world.hinge(a, b, at, axis);
    dJointSetHingeParam(joint, dParamVel, 0.7);
    dJointSetHingeParam(joint, dParamFMax, 0.05);
    return [joint] { return dJointGetHingeAngle(joint); };
  });
  check_signs("slider motor", [&](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = p.world.slider(a, b, axis);
    dJointSetSliderParam(joint, dParamVel, 0.7);
    dJointSetSliderParam(joint, dParamFMax, 0.5);
    return [joint] { return dJointGetSliderPosition(joint); };
  });
  for (const int group : {0, 0x100}) {
    // ODE's universal joint with the world as its first body turns by nothing.
    check_signs(group == 0 ? "universal's first axis" : "universal's second axis",
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = p.world.universal(a, b, at, {0, 1, 0}, {0, 0, 1});
                  for (const int of : {0, 0x100}) {
                    dJointSetUniversalParam(joint, dParamVel + of, of == group ? 0.4 : 0);
                    dJointSetUniversalParam(joint, dParamFMax + of, 1);
                  }
                  return [&p, group] {
                    const int along = group == 0 ? 1 : 2;
                    return dBodyGetAngularVel(p.one)[along] - dBodyGetAngularVel(p.other)[along];
                  };
                },
                {0, 2, 3});
  }
  check_signs("angular motor", [&](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = dJointCreateAMotor(p.world.id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetAMotorNumAxes(joint, 2);
    dJointSetAMotorAxis(joint, 0, 0, 1, 0, 0);
    dJointSetAMotorAxis(joint, 1, 1, 0, 1, 0);
    dJointSetAMotorParam(joint, dParamVel, 0.5);
    dJointSetAMotorParam(joint, dParamFMax, 0.01);
    dJointSetAMotorParam(joint, dParamVel2, 0.2);
    dJointSetAMotorParam(joint, dParamFMax2, 1);
    return [&p] { return dBodyGetAngularVel(p.one)[0] - dBodyGetAngularVel(p.other)[0]; };
  });
  check_signs("hinge stop", [&](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = p.world.hinge(a, b, at, axis);
    dJointSetHingeParam(joint, dParamVel, 2);
    dJointSetHingeParam(joint, dParamFMax, 5);
    dJointSetHingeParam(joint, dParamLoStop, -0.3);
    dJointSetHingeParam(joint, dParamHiStop, 0.5);
    return [joint] { return dJointGetHingeAngle(joint); };
  });
  check_signs("slider stop", [&](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = p.world.slider(a, b, axis);
    dJointSetSliderParam(joint, dParamVel, -2);
    dJointSetSliderParam(joint, dParamFMax, 5);
    dJointSetSliderParam(joint, dParamLoStop, -0.3);
    dJointSetSliderParam(joint, dParamHiStop, 0.5);
    return [joint] { return dJointGetSliderPosition(joint); };
  });
}

using Set = void (*)(dJointID, int, dReal);

/// A motor in one group of parameters, and a stop that it meets.
void drive(dJointID joint, Set set, int group, double velocity, double most) {
  set(joint, dParamVel + group, velocity);
  set(joint, dParamFMax + group, most);
}
void stop(dJointID joint, Set set, int group, double low, double high) {
  set(joint, dParamLoStop + group, low);
  set(joint, dParamHiStop + group, high);
}

/// Those with several axes; the others are held.
void check_signs_of_several() {
  const Vector3d at(0.2, 0.1, 0), axis(0, 0.6, 0.8);
  const auto attached = [](Pair& p, auto create, dBodyID a, dBodyID b) {
    const dJointID joint = create(p.world.id, nullptr);
    dJointAttach(joint, a, b);
    return joint;
  };
  const auto piston = [=](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = attached(p, dJointCreatePiston, a, b);
    dJointSetPistonAnchor(joint, at[0], at[1], at[2]);
    dJointSetPistonAxis(joint, axis[0], axis[1], axis[2]);
    return joint;
  };
  const auto pr = [=](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = attached(p, dJointCreatePR, a, b);
    dJointSetPRAnchor(joint, at[0], at[1], at[2]);
    dJointSetPRAxis1(joint, axis[0], axis[1], axis[2]);
    dJointSetPRAxis2(joint, 1, 0, 0);
    return joint;
  };
  const auto pu = [=](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = attached(p, dJointCreatePU, a, b);
    dJointSetPUAnchor(joint, at[0], at[1], at[2]);
    dJointSetPUAxis1(joint, 1, 0, 0);
    dJointSetPUAxis2(joint, 0, 0, 1);
    dJointSetPUAxisP(joint, axis[0], axis[1], axis[2]);
    return joint;
  };
  const auto hinge2 = [=](Pair& p, dBodyID a, dBodyID b) {
    const dJointID joint = attached(p, dJointCreateHinge2, a, b);
    dJointSetHinge2Anchor(joint, at[0], at[1], at[2]);
    const dReal steering[] = {0, 0, 1, 0}, wheel[] = {0, 1, 0, 0};
    dJointSetHinge2Axes(joint, steering, wheel);
    return joint;
  };
  constexpr double held = 100;
  for (const bool stops : {false, true}) {
    const std::string end = stops ? " stop" : " motor";
    check_signs(("piston's way" + end).c_str(),
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = piston(p, a, b);
                  drive(joint, dJointSetPistonParam, 0, 0.7, 2);
                  drive(joint, dJointSetPistonParam, 0x100, 0, held);
                  if (stops) stop(joint, dJointSetPistonParam, 0, -0.3, 0.4);
                  return [joint] { return dJointGetPistonPosition(joint); };
                },
                {0, 2, 3});
    check_signs(("piston's turn" + end).c_str(),
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = piston(p, a, b);
                  drive(joint, dJointSetPistonParam, 0, 0, held);
                  drive(joint, dJointSetPistonParam, 0x100, 0.7, 2);
                  if (stops) stop(joint, dJointSetPistonParam, 0x100, -0.3, 0.4);
                  return [joint] { return dJointGetPistonAngle(joint); };
                },
                {0, 2, 3});
    check_signs(("PR's way" + end).c_str(),
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = pr(p, a, b);
                  drive(joint, dJointSetPRParam, 0, 0.7, 2);
                  drive(joint, dJointSetPRParam, 0x100, 0, held);
                  if (stops) stop(joint, dJointSetPRParam, 0, -0.3, 0.4);
                  return [joint] { return dJointGetPRPosition(joint); };
                },
                {0, 2, 3});
    check_signs(("PR's turn" + end).c_str(),
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = pr(p, a, b);
                  drive(joint, dJointSetPRParam, 0, 0, held);
                  drive(joint, dJointSetPRParam, 0x100, 0.7, 2);
                  if (stops) stop(joint, dJointSetPRParam, 0x100, -0.3, 0.4);
                  return [joint] { return dJointGetPRAngle(joint); };
                },
                {0, 2, 3});
    check_signs(("PU's way" + end).c_str(),
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = pu(p, a, b);
                  for (const int group : {0, 0x100}) drive(joint, dJointSetPUParam, group, 0, held);
                  drive(joint, dJointSetPUParam, 0x200, 0.7, 2);
                  if (stops) stop(joint, dJointSetPUParam, 0x200, -0.3, 0.4);
                  return [joint] { return dJointGetPUPosition(joint); };
                },
                {0, 2, 3});
    check_signs(("hinge2's steering" + end).c_str(),
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = hinge2(p, a, b);
                  drive(joint, dJointSetHinge2Param, 0, 0.7, 2);
                  drive(joint, dJointSetHinge2Param, 0x100, 0, held);
                  if (stops) stop(joint, dJointSetHinge2Param, 0, -0.3, 0.4);
                  return [joint] { return dJointGetHinge2Angle1(joint); };
                },
                {2, 3});
  }
  for (const int group : {0, 0x100}) {
    check_signs(group == 0 ? "PU's first turn" : "PU's second turn",
                [&](Pair& p, dBodyID a, dBodyID b) {
                  const dJointID joint = pu(p, a, b);
                  for (const int of : {0, 0x100, 0x200}) drive(joint, dJointSetPUParam, of, of == group ? 0.4 : 0, 2);
                  return [&p, group] {
                    const int along = group == 0 ? 0 : 2;
                    return dBodyGetAngularVel(p.one)[along] - dBodyGetAngularVel(p.other)[along];
                  };
                },
                {0, 2, 3});
  }
  check_signs("hinge2's wheel",
              [&](Pair& p, dBodyID a, dBodyID b) {
                const dJointID joint = hinge2(p, a, b);
                drive(joint, dJointSetHinge2Param, 0, 0, held);
                drive(joint, dJointSetHinge2Param, 0x100, 0.7, 2);
                return [joint] { return dJointGetHinge2Angle2Rate(joint); };
              },
              {2, 3});
  check_signs("hinge2 locked",
              [&](Pair& p, dBodyID a, dBodyID b) {
                const dJointID joint = hinge2(p, a, b);
                drive(joint, dJointSetHinge2Param, 0x100, 0.7, 2);
                stop(joint, dJointSetHinge2Param, 0, 0, 0);
                return [joint] { return dJointGetHinge2Angle2Rate(joint) + dJointGetHinge2Angle1(joint); };
              },
              {2, 3});
}

/// A motor that lifts a tonne: up to speed at its limit of force, then at just that speed.
void check_lift() {
  constexpr double mass = 1000, speed = 0.5, limit = 12000, h = 1e-3;
  World world;
  const dBodyID load = world.box(mass, {1, 1, 1}, {0, 0, 0});
  const dJointID lift = world.slider(load, nullptr, {0, 0, 1});
  dJointSetSliderParam(lift, dParamVel, speed);
  dJointSetSliderParam(lift, dParamFMax, limit);
  dJointFeedback feedback{};
  dJointSetFeedback(lift, &feedback);
  AccurateStep step(world.id, world.space);
  const double a = limit / mass - g, reached = speed / a;
  for (int k = 1; k <= 1000; ++k) {
    step(h);
    const double t = k * h, z = dBodyGetPosition(load)[2], v = dBodyGetLinearVel(load)[2];
    if (t < reached) {
      CHECK_NEAR(v, a * t, 1e-12);
      CHECK_NEAR(feedback.f1[2], limit, 1e-8);
    } else {
      CHECK_NEAR(v, speed, 1e-12);
      CHECK_NEAR(z, speed * reached / 2 + speed * (t - reached), 1e-9);
      if (t > reached + h) CHECK_NEAR(feedback.f1[2], mass * g, 1e-8);
    }
  }
  // The limit below the weight: it sinks.
  const double height = dBodyGetPosition(load)[2];
  dJointSetSliderParam(lift, dParamFMax, 9000);
  for (int k = 0; k < 500; ++k) step(h);
  const double b = 9000 / mass - g;
  CHECK_NEAR(dBodyGetPosition(load)[2], height + speed * 0.5 + b * 0.125, 1e-9);
}

/// A brake (velocity 0) under a load 2 sin t: slips where the load passes its limit, grips where it has come to rest.
double brake_error(double h) {
  constexpr double limit = 1;
  const double slips = std::asin(limit / 2);
  const auto speed = [&](double t) { return 2 * (std::cos(slips) - std::cos(t)) - limit * (t - slips); };
  double low = 2, high = 5;  // it grips between: the load has turned by then
  while (high - low > 1e-15 * high) {
    const double middle = (low + high) / 2;
    if (middle <= low || middle >= high) break;
    (speed(middle) > 0 ? low : high) = middle;
  }
  const double grips = low;
  const auto way = [&](double t) {
    return 2 * (std::cos(slips) * (t - slips) - std::sin(t) + std::sin(slips)) - limit * (t - slips) * (t - slips) / 2;
  };
  World world(Vector3d::Zero());
  const dBodyID body = world.box(1, {1, 1, 1}, {0, 0, 0});
  const dJointID brake = world.slider(body, nullptr, {1, 0, 0});
  dJointSetSliderParam(brake, dParamFMax, limit);
  double start = 0;
  AccurateStepOptions options;
  options.forces = [&](double t) { dBodyAddForce(body, 2 * std::sin(start + t), 0, 0); };
  AccurateStep step(world.id, world.space, options);
  double error = 0;
  for (int k = 0; start < grips - h; ++k, start = k * h) {
    step(h);
    const double t = start + h;
    const double wanted = t < slips ? 0 : way(t);
    error = std::max(error, std::fabs(dBodyGetPosition(body)[0] - wanted));
    if (t < slips) CHECK_EQUAL(dBodyGetLinearVel(body)[0], 0.0);
  }
  std::printf("brake, h = %g: slips at %.4f s, grips at %.4f s; error %.2g m\n", h, slips, grips, error);
  return error;
}

void check_brake() {
  const double coarse = brake_error(0.04), fine = brake_error(0.02);
  std::printf("brake: order %.2f\n", order(coarse, fine, 2));
  CHECK_BETWEEN(order(coarse, fine, 2), 3.5, 6);
  CHECK_BETWEEN(brake_error(1e-3), 0, 1e-9);
}

/// A hinge that meets its stop comes back at its bounce; a slider that falls on one bounces as a ball does.
void check_stops() {
  constexpr double w = 1.3, high = 0.8, e = 0.5;
  World world(Vector3d::Zero());
  const dBodyID link = world.box(1, {1, 0.1, 0.1}, {0.5, 0, 0});
  const dJointID hinge = world.hinge(link, nullptr, {0, 0, 0}, {0, 0, 1});
  dJointSetHingeParam(hinge, dParamHiStop, high);
  dJointSetHingeParam(hinge, dParamBounce, e);
  World::move(link, {0, 0.5 * w, 0}, {0, 0, w});
  AccurateStep step(world.id, world.space);
  for (int k = 0; k < 1000; ++k) step(1e-3);
  CHECK_NEAR(dJointGetHingeAngle(hinge), high - e * w * (1 - high / w), 1e-9);
  CHECK_NEAR(dJointGetHingeAngleRate(hinge), -e * w, 1e-12);

  World falling;
  const dBodyID body = falling.box(2, {0.1, 0.1, 0.1}, {0, 0, 0});
  const dJointID slider = falling.slider(body, nullptr, {0, 0, 1});
  dJointSetSliderParam(slider, dParamLoStop, -0.4);
  dJointSetSliderParam(slider, dParamBounce, e);
  AccurateStep fall(falling.id, falling.space);
  double t = std::sqrt(0.8 / g), speed = g * t;
  std::size_t touches = 0;
  for (int k = 0; k < 2000; ++k) {
    fall(1e-3);
    for (const odeval::Touch& touch : fall.touches()) {
      if (speed < 0.01) continue;
      CHECK_NEAR(k * 1e-3 + touch.t, t, 1e-10);
      CHECK_NEAR(touch.approach, speed, 1e-9);
      speed *= e;
      t += 2 * speed / g;
      ++touches;
    }
  }
  CHECK_EQUAL(touches, std::size_t{9});                 // 2.8 m/s halved until below 0.01
  CHECK_NEAR(dBodyGetPosition(body)[2], -0.4, 2.1e-9);  // rests on it, as deep as geoms rest
  CHECK_NEAR(dBodyGetLinearVel(body)[2], 0, 1e-15);
}

/// What a joint tells at rest is what carries its body: the weight alone, however hard a motor presses on a stop, and
/// what it presses a body with against a wall, or a body that stands on the ground.
void check_feedback_at_rest() {
  constexpr double mass = 3, most = 40, h = 1e-3;
  const auto near = [](const dReal* told, const Vector3d& wanted, double within = 1e-8) {
    CHECK_NEAR((vec(told) - wanted).norm(), 0, within);
  };
  const auto settled = [&](World& world, dJointID joint, dGeomID ground = nullptr) {
    dJointFeedback feedback{};
    dJointSetFeedback(joint, &feedback);
    AccurateStepOptions options;
    options.contact = [=](dGeomID one, dGeomID other) {
      return ground == one || ground == other ? std::optional(odeval::Bounce{}) : std::nullopt;
    };
    AccurateStep step(world.id, world.space, options);
    for (int k = 0; k < 1000; ++k) step(h);
    dJointSetFeedback(joint, nullptr);
    return feedback;
  };
  {
    World world;
    const dBodyID load = world.box(mass, {0.1, 0.1, 0.1}, {0, 0, 0});
    const dJointID slider = world.slider(load, nullptr, {0, 0, 1});
    drive(slider, dJointSetSliderParam, 0, -1, most);
    stop(slider, dJointSetSliderParam, 0, -0.1, 1);
    const dJointFeedback told = settled(world, slider);
    near(told.f1, {0, 0, mass * g});
    near(told.t1, {0, 0, 0});
  }
  {
    World world;
    const dBodyID link = world.box(mass, {1, 0.1, 0.1}, {0.5, 0, 0});
    const dJointID hinge = world.hinge(link, nullptr, {0, 0, 0}, {0, -1, 0});
    drive(hinge, dJointSetHingeParam, 0, -1, most);
    stop(hinge, dJointSetHingeParam, 0, 0, 1);
    const dJointFeedback told = settled(world, hinge);
    // The step turns it freely until its end, at 54 rad/s^2, which takes m l w^2 = 0.0045 N.
    near(told.f1, {0, 0, mass * g}, 5e-3);
    near(told.t1, {0, 0, 0});  // about the link's centre
  }
  {
    World world(Vector3d::Zero());
    const dBodyID piston = world.box(mass, {0.1, 0.1, 0.1}, {0, 0, 0});
    const dJointID slider = world.slider(piston, nullptr, {1, 0, 0});
    drive(slider, dJointSetSliderParam, 0, 1, most);
    const dGeomID wall = dCreatePlane(world.space, -1, 0, 0, -0.2);
    near(settled(world, slider, wall).f1, {most, 0, 0});
    CHECK_NEAR(dBodyGetPosition(piston)[0], 0.15, 2.1e-9);
  }
  {
    // An arm that its motor holds out from a base on the ground, and one whose motor is too weak and lets it lie.
    World world;
    const dBodyID base = world.box(mass, {2, 1, 0.2}, {0, 0, 0.1});
    const dBodyID arm = world.box(mass, {0.5, 0.1, 0.1}, {0.25, 0, 0.5});
    const dJointID hinge = world.hinge(arm, base, {0, 0, 0.5}, {0, -1, 0});
    drive(hinge, dJointSetHingeParam, 0, 0, most);
    const dGeomID ground = dCreatePlane(world.space, 0, 0, 1, 0);
    const dJointFeedback told = settled(world, hinge, ground);
    near(told.f1, {0, 0, mass * g});
    near(told.t1, {0, 0, 0});
    near(told.f2, {0, 0, -mass * g});
    near(told.t2, {0, mass * g * 0.25, 0});  // the arm's weight, on the right of the base's centre
  }
}

void check_refused() {
  Pair pair;
  const dJointID joint = pair.world.hinge(pair.one, pair.other, {0.5, 0, 0}, {0, 0, 1});
  dJointSetHingeParam(joint, dParamFMax, 1);
  AccurateStep step(pair.world.id, pair.world.space);
  dJointSetHingeParam(joint, dParamVel, std::nan(""));
  const auto before = pair.world.state();
  CHECK_THROWS(step(1e-3), AccurateStepError, "has a motor with a velocity that is not finite");
  CHECK(pair.world.state() == before);
}

}  // namespace

int main() {
  check_all_signs();
  check_signs_of_several();
  check_lift();
  check_brake();
  check_stops();
  check_feedback_at_rest();
  check_refused();
  return odeval::test::verdict();
}
