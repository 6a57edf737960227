// Kinds of joints beyond those of motion_test, damping, and bodies that do not move freely: orders and energies,
// dWorldStep at small steps, and closed forms.
#include <cstdio>
#include <functional>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepOptions;
using odeval::Bounce;

constexpr double g = 9.81;

/// A bar on an oblique hinge to the world, and a second one on the joint in question.
struct Arm {
  World world;
  dBodyID one = world.box(2, {0.1, 0.2, 1}, {0, 0, -0.5});
  dBodyID two = world.box(1, {0.3, 0.1, 0.6}, {0, 0.2, -1.3});
  dJointID joint = nullptr;

  explicit Arm(const std::function<dJointID(World&, dBodyID, dBodyID)>& make) {
    world.hinge(one, nullptr, {0, 0, 0}, {1, 0.2, 0});
    joint = make(world, one, two);
  }
};

using Make = std::function<dJointID(World&, dBodyID, dBodyID)>;

template <class Create>
dJointID attached(World& world, Create create, dBodyID a, dBodyID b) {
  const dJointID joint = create(world.id, nullptr);
  dJointAttach(joint, a, b);
  return joint;
}

const Make piston = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = attached(w, dJointCreatePiston, a, b);
  dJointSetPistonAnchor(joint, 0, 0.1, -1);
  dJointSetPistonAxis(joint, 0, 0.8, 0.6);
  return joint;
};
const Make pr = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = attached(w, dJointCreatePR, a, b);
  dJointSetPRAnchor(joint, 0, 0.1, -1.1);
  dJointSetPRAxis1(joint, 0, 0.8, 0.6);
  dJointSetPRAxis2(joint, 1, 0, 0);
  return joint;
};
const Make pu = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = attached(w, dJointCreatePU, a, b);
  dJointSetPUAnchor(joint, 0, 0.1, -1.1);
  dJointSetPUAxis1(joint, 1, 0, 0);
  dJointSetPUAxis2(joint, 0, 0.6, -0.8);
  dJointSetPUAxisP(joint, 0, 0.8, 0.6);
  return joint;
};
/// dWorldStep turns a PU joint about where its anchor was, however far it has slid since: it is held to stay there.
const Make pu_held = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = pu(w, a, b);
  dJointSetPUParam(joint, dParamFMax3, 1e4);
  return joint;
};
const Make dball = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = attached(w, dJointCreateDBall, a, b);
  dJointSetDBallAnchor1(joint, 0, 0, -1);
  dJointSetDBallAnchor2(joint, 0, 0.2, -1.2);
  return joint;
};
const Make dhinge = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = attached(w, dJointCreateDHinge, a, b);
  dJointSetDHingeAxis(joint, 1, 0, 0);
  dJointSetDHingeAnchor1(joint, 0, 0, -1);
  dJointSetDHingeAnchor2(joint, 0, 0.2, -1.2);
  return joint;
};
/// Rigid, and with its axes not square.
const Make hinge2 = [](World& w, dBodyID a, dBodyID b) {
  const dJointID joint = attached(w, dJointCreateHinge2, a, b);
  dJointSetHinge2Anchor(joint, 0, 0.1, -1);
  const dReal steering[] = {0, 0.2, 1, 0}, wheel[] = {1, 0.3, 0.2, 0};
  dJointSetHinge2Axes(joint, steering, wheel);
  dJointSetHinge2Param(joint, dParamSuspensionCFM, 0);
  return joint;
};

Vector3d moved(const Make& make, double h, double until, bool accurate, double* energy = nullptr) {
  Arm arm(make);
  dWorldSetERP(arm.world.id, 0.2);
  dWorldSetCFM(arm.world.id, 0);
  World::move(arm.two, {0, 0, 0}, {0, 0, 0});
  const auto steps = std::lround(until / h);
  const double start = arm.world.energy();
  if (accurate) {
    AccurateStep step(arm.world.id, arm.world.space);
    for (long k = 0; k < steps; ++k) step(h);
  } else {
    for (long k = 0; k < steps; ++k) dWorldStep(arm.world.id, h);
  }
  if (energy != nullptr) *energy = std::fabs(arm.world.energy() - start);
  return vec(dBodyGetPosition(arm.two));
}

/// Same motion as ODE's at small steps, with energy kept to the fourth order: a freedom too many or too few shows.
void check_motion(const char* what, const Make& make) {
  double coarse = 0, fine = 0;
  moved(make, 4e-3, 0.8, true, &coarse);
  const Vector3d ours = moved(make, 2e-3, 0.8, true, &fine);
  const Vector3d plain = moved(make, 2e-5, 0.8, false), plainer = moved(make, 4e-5, 0.8, false);
  const double off = (ours - plain).norm(), own = (plain - plainer).norm();
  std::printf("%-8s energy changes by %.2g, %.2g J: order %.2f; %.2g m from dWorldStep, which is off by about %.2g\n",
              what, coarse, fine, order(coarse, fine, 2), off, own);
  CHECK_BETWEEN(fine, 0, 1e-7);
  CHECK(order(coarse, fine, 2) > 3.5 || fine < 1e-12);
  CHECK_BETWEEN(off, 0, 3 * own + 1e-9);  // dWorldStep's own first order: what halving its step changes
  CHECK((plain - Vector3d(0, 0.2, -1.3)).norm() > 0.05);
}

/// Sliding, a PU joint keeps its anchor on its line and its axes square, and energy to the fourth order.
void check_pu() {
  double coarse = 0, fine = 0;
  moved(pu, 4e-3, 0.8, true, &coarse);
  moved(pu, 2e-3, 0.8, true, &fine);
  CHECK_BETWEEN(order(coarse, fine, 2), 3.5, 5);
  Arm arm(pu);
  AccurateStep step(arm.world.id, arm.world.space);
  for (int k = 0; k < 400; ++k) {
    step(2e-3);
    dVector3 at, one, other, way;
    dJointGetPUAnchor(arm.joint, at);
    dJointGetPUAxis1(arm.joint, one);
    dJointGetPUAxis2(arm.joint, other);
    dJointGetPUAxisP(arm.joint, way);
    const Vector3d began =
        vec(dBodyGetPosition(arm.one)) + World::turn(arm.one).toRotationMatrix() * Vector3d(0, 0.1, -0.6);
    CHECK_NEAR((vec(at) - began).cross(vec(way)).norm(), 0, 1e-13);
    CHECK_NEAR(vec(one).dot(vec(other)), 0, 1e-13);
  }
  CHECK(std::fabs(dJointGetPUPosition(arm.joint)) > 0.5);
}

/// A wheel that hangs on its suspension from a body that does not move: the damped oscillator about where it rests.
double suspension_error(double h, double* force) {
  constexpr double mass = 3, stiffness = 400, damping = 12;
  World world;
  const dBodyID frame = world.box(1, {0.1, 0.1, 0.1}, {0, 0, 0});
  const dBodyID wheel = world.box(mass, {0.1, 0.1, 0.1}, {0, 0.3, 0});
  dBodySetKinematic(frame);
  const dJointID joint = attached(world, dJointCreateHinge2, frame, wheel);
  dJointSetHinge2Anchor(joint, 0, 0.3, 0);
  const dReal steering[] = {0, 0, 1, 0}, axle[] = {0, 1, 0, 0};
  dJointSetHinge2Axes(joint, steering, axle);
  // ODE's own words for a spring and a damper, which hold for one step size.
  dJointSetHinge2Param(joint, dParamSuspensionERP, h * stiffness / (h * stiffness + damping));
  dJointSetHinge2Param(joint, dParamSuspensionCFM, 1 / (h * stiffness + damping));
  dJointFeedback feedback{};
  dJointSetFeedback(joint, &feedback);
  AccurateStep step(world.id, world.space);
  const double decay = damping / (2 * mass), swing = std::sqrt(stiffness / mass - decay * decay);
  const double rests = -mass * g / stiffness;
  double error = 0;
  for (int k = 1; k * h <= 1 + h / 2; ++k) {
    step(h);
    const double t = k * h;
    const double wanted =
        rests * (1 - std::exp(-decay * t) * (std::cos(swing * t) + decay / swing * std::sin(swing * t)));
    error = std::max(error, std::fabs(dBodyGetPosition(wheel)[2] - wanted));
  }
  for (int k = 0; k * h < 20; ++k) step(h);
  *force = feedback.f2[2] - mass * g;
  return error;
}

void check_suspension() {
  double force = 0;
  const double coarse = suspension_error(1e-2, &force), fine = suspension_error(5e-3, &force);
  const double usual = suspension_error(1e-3, &force);
  std::printf("suspension: off by %.2g, %.2g, %.2g m at h = 0.01, 0.005, 0.001, order %.2f; force off by %.2g N\n",
              coarse, fine, usual, order(coarse, fine, 2), force);
  CHECK_BETWEEN(order(coarse, fine, 2), 3.5, 4.5);
  CHECK_BETWEEN(usual, 0, 1e-9);
  CHECK_NEAR(force, 0, 1e-9);
}

/// Two bodies on a suspension, with its anchor so far from the centre of the first.
struct Sprung {
  World world;
  dBodyID frame = world.box(1, {0.1, 0.1, 0.1}, {0, 0, 0}), wheel;
  dJointID joint;

  Sprung(double mass, double away) : wheel(world.box(mass, {0.1, 0.1, 0.1}, {0, away, 0})) {
    joint = attached(world, dJointCreateHinge2, frame, wheel);
    dJointSetHinge2Anchor(joint, 0, away, 0);
    const dReal steering[] = {0, 0, 1, 0}, axle[] = {0, 1, 0, 0};
    dJointSetHinge2Axes(joint, steering, axle);
    dJointSetHinge2Param(joint, dParamSuspensionERP, 0.5);
    set_cfm(1e-4);
  }
  void set_cfm(double cfm) { dJointSetHinge2Param(joint, dParamSuspensionCFM, cfm); }
  /// Of 2000 steps from a kick on.
  double largest_rise() {
    World::move(wheel, {0, 0, 1}, {0, 0, 0});
    AccurateStep step(world.id, world.space);
    const double energy = world.energy();
    double largest = 0;
    for (int k = 0; k < 2000; ++k) {
      step(1e-3);
      largest = std::max(largest, world.energy() - energy);
    }
    return largest;
  }
};

/// Stiffer than a step can follow: refused, with the number that would do. What counts is the mass that the spring
/// feels: less than a body's far from its centre, more where a joint fixes it to another. At an ERP of a half Runge's
/// method bears h W / CFM = 8, of which 0.72 are allowed; of a damper alone 2.78.
void check_stiff() {
  Sprung plain(1, 0);
  AccurateStep step(plain.world.id, plain.world.space);
  CHECK_THROWS(step(1e-3), odeval::AccurateStepError, "raise its dParamSuspensionCFM to 0.000347222 or more");
  plain.set_cfm(0.000348);
  CHECK_BETWEEN(plain.largest_rise(), -1, 1e-9);
  // A damper alone: 2 h / (0.72 * 2.78).
  dJointSetHinge2Param(plain.joint, dParamSuspensionERP, 0);
  CHECK_THROWS(plain.largest_rise(), odeval::AccurateStepError, "raise its dParamSuspensionCFM to 0.00099");
  plain.set_cfm(0.001);
  CHECK_BETWEEN(plain.largest_rise(), -1, 1e-9);

  // The frame turns about its centre: 2 + 0.3^2 / I. By the masses alone 0.00035 would do, and it explodes.
  Sprung far(1, 0.3);
  far.set_cfm(0.00035);
  CHECK_THROWS(far.largest_rise(), odeval::AccurateStepError, "raise its dParamSuspensionCFM to 0.0");
  try {
    far.largest_rise();
  } catch (const odeval::AccurateStepError& error) {
    const std::string what = error.what(), before = "CFM to ";
    far.set_cfm(std::stod(what.substr(what.find(before) + before.size())));
  }
  CHECK_BETWEEN(far.largest_rise(), -1, 1e-9);

  // A wheel of 10 g that is fixed to 10 kg.
  Sprung light(0.01, 0);
  const dBodyID heavy = light.world.box(10, {0.1, 0.1, 0.1}, {0, 0, 0});
  light.world.fixed(light.wheel, heavy);
  light.set_cfm(0.001);
  CHECK_BETWEEN(light.largest_rise(), -1, 1e-9);
}

/// Damped as dWorldStep does it, and to the fourth order between: v = v0 (1 - s)^(t/h) down to the threshold.
void check_damping() {
  constexpr double h = 1e-3, share = 0.01, spin_share = 0.02;
  World world(Vector3d::Zero());
  const dBodyID box = world.box(1, {1, 1, 1}, {0, 0, 0});
  dBodySetLinearDamping(box, share);
  dBodySetAngularDamping(box, spin_share);
  dBodySetLinearDampingThreshold(box, 0.5);
  dBodySetAngularDampingThreshold(box, 0);
  World::move(box, {2, 0, 0}, {0, 3, 0});
  AccurateStep step(world.id, world.space);
  const double rate = -std::log1p(-share) / h, stops = std::log(2 / 0.5) / rate;
  for (int k = 1; k <= 500; ++k) {
    step(h);
    const double t = std::min(k * h, stops);
    // A step of the fourth order leaves (rate h)^5 / 120 of a speed: 1e-10 of it and 2e-9 in all.
    CHECK_NEAR(dBodyGetLinearVel(box)[0], 2 * std::exp(-rate * t), k * h < stops ? 1e-10 : 0.5 * share);
    CHECK_NEAR(dBodyGetAngularVel(box)[1], 3 * std::pow(1 - spin_share, k), 2e-9);
    if (k * h < stops) CHECK_NEAR(dBodyGetPosition(box)[0], 2 / rate * (1 - std::exp(-rate * t)), 1e-11);
  }
}

/// A ball on a platform that rises evenly bounces as on one at rest; a pendulum on a cart that moves evenly swings as
/// on one that does not.
void check_kinematic() {
  constexpr double e = 0.7, rises = 0.5, h = 1e-3;
  World world;
  const dBodyID platform = world.box(1, {1, 1, 0.2}, {0, 0, -0.1});
  dBodySetKinematic(platform);
  World::move(platform, {0, 0, rises}, {0, 0, 0});
  world.sphere(1, 0.1, {0, 0, 0.5});
  AccurateStepOptions options;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{e, 0.3}); };
  AccurateStep step(world.id, world.space, options);
  const double meets = (-rises + std::sqrt(rises * rises + 2 * g * 0.4)) / g;
  double touched = 0;
  for (int k = 0; k < 500; ++k) {
    step(h);
    for (const odeval::Touch& touch : step.touches()) {
      if (touched == 0) touched = k * h + touch.t;
      CHECK_NEAR(touch.departure, e * touch.approach, 1e-9);
    }
  }
  CHECK_NEAR(touched, meets, 1e-10);
  CHECK_NEAR(dBodyGetPosition(platform)[2], -0.1 + rises * 0.5, 1e-12);

  const auto swung = [](double speed) {
    World other;
    const dBodyID cart = other.box(1, {0.1, 0.1, 0.1}, {0, 0, 0}), bob = other.box(1, {0.1, 0.1, 1}, {0, 0.3, -0.4});
    dBodySetKinematic(cart);
    World::move(cart, {0, speed, 0}, {0, 0, 0});
    World::move(bob, {0, speed, 0}, {0, 0, 0});
    other.hinge(cart, bob, {0, 0, 0}, {1, 0, 0});
    AccurateStep move(other.id, other.space);
    for (int k = 0; k < 1000; ++k) move(1e-3);
    return Vector3d(vec(dBodyGetPosition(bob)) - Vector3d(0, speed, 0));
  };
  CHECK_NEAR((swung(0) - swung(2)).norm(), 0, 1e-12);
  // Nothing of it touches what does not move either.
  World still;
  const dBodyID wall = still.box(1, {1, 1, 1}, {0, 0, 0});
  dBodySetKinematic(wall);
  World::move(wall, {0, 0, -1}, {0, 0, 0});
  dCreatePlane(still.space, 0, 0, 1, -0.6);
  AccurateStep through(still.id, still.space, options);
  for (int k = 0; k < 300; ++k) {
    through(1e-3);
    CHECK(through.touches().empty());
  }
  CHECK_NEAR(dBodyGetPosition(wall)[2], -0.3, 1e-12);
}

/// A disabled body stays as it is until something hits it, or a joint leads to one that is awake.
void check_disabled() {
  World world(Vector3d::Zero());
  const dBodyID asleep = world.sphere(1, 0.5, {0, 0, 0}), comes = world.sphere(1, 0.5, {-2, 0, 0});
  World::move(comes, {1, 0, 0}, {0, 0, 0});
  dBodyDisable(asleep);
  dBodyAddForce(asleep, 5, 0, 0);
  AccurateStepOptions options;
  options.contact = [](dGeomID, dGeomID) { return std::optional(Bounce{1}); };
  AccurateStep step(world.id, world.space, options);
  for (int k = 0; k < 90; ++k) step(1e-2);
  CHECK_EQUAL(dBodyIsEnabled(asleep), 0);
  CHECK_EQUAL(dBodyGetPosition(asleep)[0], 0.0);
  for (int k = 0; k < 60; ++k) step(1e-2);
  CHECK_EQUAL(dBodyIsEnabled(asleep), 1);
  CHECK_NEAR(dBodyGetLinearVel(asleep)[0], 1, 1e-12);
  CHECK_NEAR(dBodyGetPosition(asleep)[0], 0.5, 1e-10);

  Arm arm(dball);
  dBodyDisable(arm.one);
  dBodyDisable(arm.two);
  AccurateStep wait(arm.world.id, arm.world.space);
  const auto before = arm.world.state();
  for (int k = 0; k < 10; ++k) wait(1e-2);
  CHECK(arm.world.state() == before);
  dBodyEnable(arm.two);
  wait(1e-2);
  CHECK_EQUAL(dBodyIsEnabled(arm.one), 1);
  CHECK(!(arm.world.state() == before));
}

/// A load that a joint and its motors at rest carry: what feedback tells is its weight.
void check_feedback() {
  const auto carried = [](const char* what, const Make& make, const std::function<void(dJointID)>& brake) {
    World world;
    const dBodyID one = world.box(2, {0.1, 0.2, 1}, {0, 0, -0.5}), two = world.box(1, {0.3, 0.1, 0.6}, {0, 0.2, -1.3});
    world.fixed(one, nullptr);
    const dJointID joint = make(world, one, two);
    brake(joint);
    dJointFeedback feedback{};
    dJointSetFeedback(joint, &feedback);
    AccurateStep step(world.id, world.space);
    for (int k = 0; k < 10; ++k) step(1e-3);
    CHECK_NEAR((vec(feedback.f2) - Vector3d(0, 0, g)).norm(), 0, 1e-9);
    CHECK_NEAR((vec(feedback.f1) + Vector3d(0, 0, g)).norm(), 0, 1e-9);
    if (vec(feedback.f2).norm() < 1) std::printf("%s carries nothing\n", what);
  };
  constexpr double strong = 1e4;
  carried("piston", piston, [](dJointID joint) {
    for (const int of : {dParamFMax, dParamFMax2}) dJointSetPistonParam(joint, of, strong);
  });
  carried("PR", pr, [](dJointID joint) {
    for (const int of : {dParamFMax, dParamFMax2}) dJointSetPRParam(joint, of, strong);
  });
  carried("PU", pu, [](dJointID joint) {
    for (const int of : {dParamFMax, dParamFMax2, dParamFMax3}) dJointSetPUParam(joint, of, strong);
  });
  carried("hinge2", hinge2, [](dJointID joint) {
    for (const int of : {dParamFMax, dParamFMax2}) dJointSetHinge2Param(joint, of, strong);
  });
}

/// A plate that only moves in the plane z = 0, pushed askew.
void check_plane() {
  World world;
  const dBodyID plate = world.box(2, {0.4, 0.2, 0.1}, {1, 2, 0});
  attached(world, dJointCreatePlane2D, plate, nullptr);
  World::move(plate, {1, 0, 0}, {0, 0, 3});
  AccurateStep step(world.id, world.space);
  for (int k = 0; k < 100; ++k) {
    dBodyAddForceAtRelPos(plate, 0, 3, 5, 0.1, 0, 0);
    step(1e-2);
    CHECK_NEAR(dBodyGetPosition(plate)[2], 0, 1e-15);
    CHECK_NEAR(World::turn(plate).vec().head<2>().norm(), 0, 1e-14);
  }
  CHECK_NEAR(dBodyGetPosition(plate)[0], 2, 1e-12);
  CHECK_NEAR(dBodyGetPosition(plate)[1], 2 + 0.75, 1e-12);  // F t^2 / 2 m, torques held by the plane but for z
}

/// What is changed between steps is taken as it is then, and makes a difference: the same bits as a step made
/// afterwards.
void check_noticed() {
  const auto taken = [](const char* what, const Make& make, const std::function<void(dJointID)>& change) {
    Arm changed(make), fresh(make), left(make);
    AccurateStep step(changed.world.id, changed.world.space), other(fresh.world.id, fresh.world.space);
    AccurateStep same(left.world.id, left.world.space);
    for (int k = 0; k < 3; ++k) step(1e-3), other(1e-3), same(1e-3);
    change(changed.joint);
    change(fresh.joint);
    AccurateStep made_after(fresh.world.id, fresh.world.space);
    step(1e-3), made_after(1e-3), same(1e-3);
    const bool good = changed.world.state() == fresh.world.state() && changed.world.state() != left.world.state();
    if (!good) std::printf("not noticed: %s\n", what);
    CHECK(good);
  };
  taken("piston's axis", piston, [](dJointID joint) { dJointSetPistonAxis(joint, 0, 1, 0); });
  taken("piston's motor", piston, [](dJointID joint) { dJointSetPistonParam(joint, dParamFMax2, 1); });
  taken("PR's way", pr, [](dJointID joint) { dJointSetPRAxis1(joint, 0, 1, 0); });
  taken("PR's motor", pr, [](dJointID joint) { dJointSetPRParam(joint, dParamFMax, 1); });
  taken("PU's axis", pu, [](dJointID joint) { dJointSetPUAxis1(joint, 1, 0.1, 0.075); });
  taken("PU's motor", pu, [](dJointID joint) { dJointSetPUParam(joint, dParamFMax3, 1); });
  taken("dball's anchor", dball, [](dJointID joint) { dJointSetDBallAnchor1(joint, 0, 0.1, -1); });
  taken("dhinge's anchor", dhinge, [](dJointID joint) { dJointSetDHingeAnchor1(joint, 0, 0.1, -1); });
  taken("hinge2's suspension", hinge2, [](dJointID joint) {
    dJointSetHinge2Param(joint, dParamSuspensionERP, 0.5);
    dJointSetHinge2Param(joint, dParamSuspensionCFM, 0.1);
  });
  taken("hinge2's anchor", hinge2, [](dJointID joint) { dJointSetHinge2Anchor(joint, 0, 0, -1); });
  taken("hinge2's motor", hinge2, [](dJointID joint) { dJointSetHinge2Param(joint, dParamFMax2, 1); });
}

/// The second axis of a piston has a stop with a restitution of its own; and the second motor of a universal joint goes
/// about an axis that its second body carries.
void check_second_axes() {
  World world({0, 0, 0});
  const dBodyID rod = world.box(1, {0.2, 0.2, 0.6}, {0, 0, 0});
  const dJointID guide = dJointCreatePiston(world.id, nullptr);
  dJointAttach(guide, rod, nullptr);
  dJointSetPistonAxis(guide, 0, 0, 1);
  dJointSetPistonParam(guide, dParamLoStop2, -0.3);
  dJointSetPistonParam(guide, dParamHiStop2, 0.3);
  dJointSetPistonParam(guide, dParamBounce2, 0.5);
  World::move(rod, {0, 0, 0}, {0, 0, 2});
  AccurateStep step(world.id, world.space);
  for (int k = 0; k < 20; ++k) step(1e-2);
  CHECK_NEAR(dBodyGetAngularVel(rod)[2], -1, 1e-12);

  World other({0, 0, 0});
  const dBodyID cross = other.box(1, {0.2, 0.3, 0.4}, {0, 0, 0});
  const Quaterniond turned(Eigen::AngleAxisd(0.5, Vector3d::UnitX()));
  const dJointID centre = other.universal(cross, nullptr, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  dJointSetUniversalParam(centre, dParamFMax, 100);
  dJointSetUniversalParam(centre, dParamFMax2, 100);
  World::place(cross, {0, 0, 0}, turned);
  dJointSetUniversalParam(centre, dParamVel, 1);
  dJointSetUniversalParam(centre, dParamVel2, 0.7);
  AccurateStep both(other.id, other.space);
  for (int k = 0; k < 50; ++k) both(1e-2);
  CHECK_NEAR(dBodyGetAngularVel(cross)[1], 0.7, 1e-12);  // the second axis stands still, on the world
}

}  // namespace

int main() {
  check_second_axes();
  check_motion("piston", piston);
  check_motion("PR", pr);
  check_motion("PU", pu_held);
  check_pu();
  check_motion("dball", dball);
  check_motion("dhinge", dhinge);
  check_motion("hinge2", hinge2);
  check_suspension();
  check_stiff();
  check_damping();
  check_kinematic();
  check_disabled();
  check_feedback();
  check_plane();
  check_noticed();
  return odeval::test::verdict();
}
