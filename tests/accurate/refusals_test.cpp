// What the accurate step does not do, and worlds it can not start from: a clear error, and nothing changed.
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>

#include "engines/ode_rk4/accurate_step.hpp"
#include "tests/accurate/worlds.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::test;
using odeval::AccurateStep;
using odeval::AccurateStepError;
using odeval::AccurateStepOptions;
using odeval::Bounce;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Two links on hinges.
struct Pendulum : World {
  Pendulum() {
    one = box(1, {0.1, 0.1, 1}, {0, 0, -0.5});
    two = box(1, {0.1, 0.1, 1}, {0, 0, -1.5});
    first = hinge(one, nullptr, {0, 0, 0}, {1, 0, 0});
    second = hinge(one, two, {0, 0, -1}, {1, 0, 0});
    move(one, {0, 0.5, 0}, {1, 0, 0});
    move(two, {0, 1.5, 0}, {1, 0, 0});
  }
  dBodyID one, two;
  dJointID first, second;
};

std::vector<double> bits(const World& world) {
  std::vector<double> all = world.state();
  for (const dBodyID body : world.bodies) {
    all.insert(all.end(), dBodyGetForce(body), dBodyGetForce(body) + 3);
    all.insert(all.end(), dBodyGetTorque(body), dBodyGetTorque(body) + 3);
  }
  return all;
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// Refused when the step is made.
void refused(const char* message, const std::function<void(Pendulum&)>& spoil) {
  Pendulum world;
  spoil(world);
  const auto before = bits(world);
  CHECK_THROWS(AccurateStep(world.id, world.space), AccurateStepError, message);
  CHECK(same(bits(world), before));
}

/// Refused when a step is taken, after a good one.
void refused_later(const char* message, const std::function<void(Pendulum&)>& spoil, double h = 1e-3) {
  Pendulum world;
  dCreatePlane(world.space, 0, 0, 1, -10);
  AccurateStepOptions options;
  options.contact = [](dxGeom*, dxGeom*) { return std::optional(Bounce{}); };
  AccurateStep step(world.id, world.space, options);
  step(1e-3);
  spoil(world);
  const auto before = bits(world);
  CHECK_THROWS(step(h), AccurateStepError, message);
  CHECK(same(bits(world), before));
}

void check_unsupported() {
  for (const int stop : {dParamLoStop, dParamHiStop, dParamLoStop2, dParamHiStop2}) {
    refused("has stops", [stop](Pendulum& w) {
      dJointSetUniversalParam(w.universal(w.one, w.two, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}), stop, 0.1);
    });
  }
  refused("dAMotorUser is supported", [](Pendulum& w) {
    const dJointID motor = dJointCreateAMotor(w.id, nullptr);
    dJointAttach(motor, w.one, w.two);
    dJointSetAMotorMode(motor, dAMotorEuler);
  });
  for (const auto make : {dJointCreatePiston, dJointCreatePR, dJointCreatePU}) {
    refused("attach it as the second", [make](Pendulum& w) { dJointAttach(make(w.id, nullptr), nullptr, w.two); });
  }
  refused("attach it to the world",
          [](Pendulum& w) { dJointAttach(dJointCreatePlane2D(w.id, nullptr), w.one, w.two); });
  refused("has stops", [](Pendulum& w) {
    const dJointID joint = dJointCreatePU(w.id, nullptr);
    dJointAttach(joint, w.one, w.two);
    dJointSetPUParam(joint, dParamHiStop2, 0.1);
  });
  for (const auto& [low, high] : {std::pair(0.5, -0.5), std::pair(0.0, nan)}) {
    refused("between body 0 and the world has stops the wrong way round: dParamLoStop", [&](Pendulum& w) {
      dJointSetHingeParam(w.first, dParamLoStop, low);
      dJointSetHingeParam(w.first, dParamHiStop, high);
    });
  }
  for (const double bounce : {-0.1, 1.5, nan}) {
    refused("between body 0 and the world has stops with a dParamBounce of", [&](Pendulum& w) {
      dJointSetHingeParam(w.first, dParamHiStop, 1);
      dJointSetHingeParam(w.first, dParamBounce, bounce);
    });
  }
  refused("keeps no distance", [](Pendulum& w) {
    const dJointID joint = dJointCreateDBall(w.id, nullptr);
    dJointAttach(joint, w.one, w.two);
    dJointSetDBallAnchor1(joint, 0, 0, -1);
    dJointSetDBallAnchor2(joint, 0, 0, -1);
  });
  for (const double damping : {-0.1, 1.0, nan}) {
    refused("a damping that is not", [damping](Pendulum& w) { dBodySetLinearDamping(w.two, damping); });
    refused("a damping that is not", [damping](Pendulum& w) { dBodySetAngularDamping(w.one, damping); });
  }
  refused("limited angular speed", [](Pendulum& w) { dBodySetMaxAngularSpeed(w.one, 10); });
  refused("gyroscopic term off", [](Pendulum& w) { dBodySetGyroscopicMode(w.one, 0); });
  World empty;
  CHECK_THROWS(AccurateStep(empty.id, empty.space), AccurateStepError, "found no body");
  refused_later("kind that is not supported", [](Pendulum& w) {
    dContact contact{};
    contact.geom.normal[2] = 1;
    dJointAttach(dJointCreateContact(w.id, nullptr, &contact), w.one, nullptr);
  });
}

void check_bad_numbers() {
  for (const double h : {0.0, -1e-3, nan, std::numeric_limits<double>::infinity()}) {
    refused_later(
        "the step must be a positive number", [](Pendulum&) {}, h);
  }
  refused_later("is not finite", [](Pendulum& w) { dBodySetLinearVel(w.one, nan, 0, 0); });
  refused_later("is not finite", [](Pendulum& w) { dBodySetPosition(w.two, 0, nan, 0); });
  refused_later("force on body", [](Pendulum& w) { dBodyAddForce(w.one, 0, nan, 0); });
  // So fast that squares of speeds overflow within the step.
  refused_later("left the finite numbers", [](Pendulum& w) { dBodySetAngularVel(w.one, 1e200, 0, 0); });
}

/// A joint pulled apart: mended when little, refused when much, by a number of the user's.
void check_start_gaps() {
  refused_later("apart at the start", [](Pendulum& w) { dBodySetPosition(w.two, 0, 0, -1.6); });
  refused_later("apart at the start", [](Pendulum& w) {
    const dQuaternion q = {0.9, 0, 0.1, 0};  // the hinge's axes no longer agree
    dBodySetQuaternion(w.two, q);
  });
  Pendulum world;
  AccurateStep step(world.id, world.space);
  step(1e-3);
  dBodySetPosition(world.two, 0.0005, dBodyGetPosition(world.two)[1], dBodyGetPosition(world.two)[2]);
  step(1e-3);
  const Vector3d x = vec(dBodyGetPosition(world.two));
  CHECK_NEAR(x[0], 0, 1e-14);  // back in the plane of the hinges
  dVector3 anchor, anchor2;
  dJointGetHingeAnchor(world.second, anchor);
  dJointGetHingeAnchor2(world.second, anchor2);
  CHECK_NEAR((vec(anchor) - vec(anchor2)).norm(), 0, 1e-14);
}

odeval::AccurateStepOptions plastic() {
  AccurateStepOptions options;
  options.contact = [](dxGeom*, dxGeom*) { return std::optional(Bounce{}); };
  return options;
}

/// Largest distance between the two anchors of the pendulum's hinges.
double gap(const Pendulum& world) {
  double largest = 0;
  for (const dJointID joint : {world.first, world.second}) {
    dVector3 one, two;
    dJointGetHingeAnchor(joint, one);
    dJointGetHingeAnchor2(joint, two);
    largest = std::max(largest, (vec(one) - vec(two)).norm());
  }
  return largest;
}

/// Either a sound end or an error and the world as it was: never joints apart, not-a-number, or an abort of ODE.
bool sound(Pendulum& world, AccurateStep& step, double h) {
  const auto before = bits(world);
  try {
    step(h);
  } catch (const AccurateStepError&) {
    CHECK(same(bits(world), before));
    return false;
  }
  for (const double number : bits(world)) CHECK(std::isfinite(number));
  CHECK_BETWEEN(gap(world), 0, 1e-9);  // what is left at most; of trees, rounding
  return true;
}

/// Steps far too large, speeds far too high, with and without ground.
void check_large_steps() {
  int refused_steps = 0, taken = 0;
  for (const bool ground : {false, true}) {
    for (double h = 1e-3; h < 1e12; h *= 3) {
      for (const double speed : {1.0, 30.0, 1e6, 1e30, 1e150}) {
        Pendulum world;
        if (ground) dCreatePlane(world.space, 0, 0, 1, -2.5);
        World::move(world.one, {0, 0.5 * speed, 0}, {speed, 0, 0});
        World::move(world.two, {0, 1.5 * speed, 0}, {speed, 0, 0});
        AccurateStep step(world.id, world.space, plastic());
        (sound(world, step, h) ? taken : refused_steps) += 1;
      }
    }
  }
  std::printf("large steps: %d taken, %d refused\n", taken, refused_steps);
  CHECK(refused_steps > 0 && taken > 0);

  // A free ball that flies out of what ODE's hash space can count.
  World world;
  const dBodyID ball = world.sphere(1, 0.1, {0, 0, 1});
  dCreatePlane(world.space, 0, 0, 1, 0);
  World::move(ball, {1e9, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space, plastic());
  const auto before = bits(world);
  CHECK_THROWS(step(1), AccurateStepError, "farther from the origin");
  CHECK(same(bits(world), before));
  World::move(ball, {1e3, 0, 0}, {0, 0, 0});
  step(1e-3);
  CHECK_NEAR(dBodyGetPosition(ball)[0], 1, 1e-12);
}

/// Overlaps that nothing can push out.
void check_vices() {
  World vice;
  const dBodyID ball = vice.sphere(1, 0.1, {0, 0, 0});
  dCreatePlane(vice.space, 1, 0, 0, -0.05);
  dCreatePlane(vice.space, -1, 0, 0, -0.05);
  AccurateStep squeeze(vice.id, vice.space, plastic());
  auto before = bits(vice);
  CHECK_THROWS(squeeze(1e-3), AccurateStepError, "can not be pushed");
  CHECK(same(bits(vice), before));
  World::place(ball, {0, 0, 0}, Quaterniond::Identity());

  // Two links on hinges, the first hinge inside a slanted wall: pushing would have to pull it out.
  Pendulum hung;
  dCreatePlane(hung.space, 0, 1, 0.2, 0);
  AccurateStep step(hung.id, hung.space, plastic());
  before = bits(hung);
  CHECK_THROWS(step(1e-3), AccurateStepError, "can not be pushed");
  CHECK(same(bits(hung), before));

  // A box put 5 mm deep into the ground comes out at once.
  World sunk;
  const dBodyID box = sunk.box(1, {0.4, 0.3, 0.1}, {0, 0, 0.045});
  dCreatePlane(sunk.space, 0, 0, 1, 0);
  AccurateStep lift(sunk.id, sunk.space, plastic());
  lift(1e-3);
  CHECK_NEAR(dBodyGetPosition(box)[2], 0.05, 1e-8);
}

void check_options() {
  Pendulum world;
  const auto refuse = [&](const char* message, const std::function<void(AccurateStepOptions&)>& spoil) {
    AccurateStepOptions options;
    spoil(options);
    CHECK_THROWS(AccurateStep(world.id, world.space, options), AccurateStepError, message);
  };
  for (const double gap : {0.0, -1e-3, nan, std::numeric_limits<double>::infinity()}) {
    refuse("start_gap must be", [gap](AccurateStepOptions& o) { o.start_gap = gap; });
  }
  for (const double speed : {-1e-3, nan, std::numeric_limits<double>::infinity()}) {
    refuse("rest_speed must be", [speed](AccurateStepOptions& o) { o.rest_speed = speed; });
  }
  for (const int most : {0, -1})
    refuse("most_impacts must be", [most](AccurateStepOptions& o) { o.most_impacts = most; });
  for (const int order : {0, 5, -8})
    refuse("order must be 4 or 8", [order](AccurateStepOptions& o) { o.order = order; });
  refuse("number 0 of AccurateStepOptions::bodies is null", [](AccurateStepOptions& o) { o.bodies = {nullptr}; });
  World elsewhere;
  const dBodyID stranger = elsewhere.sphere(1, 0.1, {0, 0, 0});
  refuse("number 0 of AccurateStepOptions::bodies is of another world",
         [&](AccurateStepOptions& o) { o.bodies = {stranger}; });
  refuse("impact_order must be", [](AccurateStepOptions& o) { o.impact_order = static_cast<odeval::ImpactOrder>(2); });

  for (const double restitution : {-0.1, 1.1, nan}) {
    World falling;
    falling.sphere(1, 0.1, {0, 0, 0.1});
    dCreatePlane(falling.space, 0, 0, 1, 0);
    AccurateStepOptions options;
    options.contact = [restitution](dxGeom*, dxGeom*) { return std::optional(Bounce{restitution}); };
    AccurateStep step(falling.id, falling.space, options);
    const auto before = bits(falling);
    CHECK_THROWS(step(1e-3), AccurateStepError, "a restitution must be 0 to 1");
    CHECK(same(bits(falling), before));
  }
}

/// What the user's functions throw comes through, and leaves a world that goes on.
void check_functions_that_throw() {
  struct Trouble : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  bool in_contact = false, in_impact = false;
  World world;
  world.sphere(1, 0.1, {0, 0, 0.1 + 1e-6});
  // A quaternion that ODE made from a matrix makes another one in the last digits: both must come back.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const dMatrix3 rows = {turn(0, 0), turn(0, 1), turn(0, 2), 0,          turn(1, 0), turn(1, 1),
                         turn(1, 2), 0,          turn(2, 0), turn(2, 1), turn(2, 2), 0};
  dBodySetRotation(world.sphere(1, 0.1, {0, 0, 1}), rows);
  dCreatePlane(world.space, 0, 0, 1, 0);
  AccurateStepOptions options;
  options.contact = [&](dxGeom*, dxGeom*) {
    if (in_contact) throw Trouble("contact");
    return std::optional(Bounce{1});
  };
  options.after_impact = [&](const odeval::Touch&) {
    if (in_impact) throw Trouble("impact");
  };
  AccurateStep step(world.id, world.space, options);
  for (bool* const where : {&in_contact, &in_impact}) {
    const auto before = bits(world);
    *where = true;
    CHECK_THROWS(step(1e-2), Trouble, where == &in_contact ? "contact" : "impact");
    *where = false;
    CHECK(same(bits(world), before));
    dGeomDestroy(dCreateSphere(world.space, 0.1));  // ODE aborts here when the space is locked
  }
  step(1e-2);
  CHECK(!step.touches().empty());
}

/// Changes between making the step and its first call, and between calls.
void check_noticed() {
  const auto refused_first = [](const char* message, const std::function<void(Pendulum&)>& spoil) {
    Pendulum world;
    AccurateStep step(world.id, world.space);
    spoil(world);
    CHECK_THROWS(step(1e-3), AccurateStepError, message);
    refused_later(message, spoil);
  };
  refused_first("a damping that is not", [](Pendulum& w) { dBodySetLinearDamping(w.two, 2); });
  refused_first("limited angular speed", [](Pendulum& w) { dBodySetMaxAngularSpeed(w.one, 10); });
  refused_first("gyroscopic term off", [](Pendulum& w) { dBodySetGyroscopicMode(w.one, 0); });

  refused_first("has a motor", [](Pendulum& w) {
    dJointSetHingeParam(w.first, dParamFMax, 1);
    dJointSetHingeParam(w.first, dParamVel, nan);
  });

  // What is taken as it is now: the same bits as a step made afterwards.
  const auto taken = [](const std::function<void(Pendulum&)>& change) {
    for (const int steps_before : {0, 3}) {
      Pendulum changed, fresh;
      AccurateStep step(changed.id, changed.space), other(fresh.id, fresh.space);
      for (int k = 0; k < steps_before; ++k) step(1e-3), other(1e-3);
      change(changed);
      change(fresh);
      AccurateStep made_after(fresh.id, fresh.space);
      step(1e-3);
      made_after(1e-3);
      CHECK(same(bits(changed), bits(fresh)));
      CHECK_EQUAL(step.joints(), made_after.joints());
    }
  };
  taken([](Pendulum& w) {
    dMass mass;
    dMassSetBoxTotal(&mass, 5, 0.1, 0.1, 1);
    dBodySetMass(w.two, &mass);
  });
  taken([](Pendulum& w) { dBodySetAngularDamping(w.two, 0.1); });
  taken([](Pendulum& w) { dBodySetKinematic(w.one); });
  taken([](Pendulum& w) { dJointDisable(w.second); });
  taken([](Pendulum& w) {  // the new joint may have the old one's address
    dJointDestroy(w.second);
    w.second = w.hinge(w.one, w.two, {0, 0, -1.3}, {1, 0, 0});
  });
  taken([](Pendulum& w) { dJointSetHingeParam(w.first, dParamFMax, 1); });
  taken([](Pendulum& w) { dJointSetHingeParam(w.second, dParamLoStop, 0); });
  taken([](Pendulum& w) { dJointSetHingeAxis(w.second, 0, 0, 1); });
  taken([](Pendulum& w) {
    dGeomDestroy(dBodyGetFirstGeom(w.two));
    dBodyDestroy(w.two);
    w.bodies.pop_back();
  });
  taken([](Pendulum& w) {
    dBodyDestroy(w.two);  // its geom stays, on the world
    w.bodies.pop_back();
  });
}

/// Errors say which joint and which body, in words that do not change from step to step.
void check_names() {
  Pendulum world;
  world.sphere(1, 0.1, {5, 0, 0});
  AccurateStep step(world.id, world.space);
  const auto message = [&] {
    try {
      step(1e-3);
    } catch (const AccurateStepError& error) {
      CHECK(error.joint == world.second);
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const auto motor = [&](double force) {
    dJointSetHingeParam(world.second, dParamFMax, force);
    dJointSetHingeParam(world.second, dParamVel, force > 0 ? nan : 0);
  };
  motor(1);
  CHECK(message().find("the hinge between body 0 and body 1 has a motor") != std::string::npos);
  motor(0);
  const Vector3d place = vec(dBodyGetPosition(world.two));
  dBodySetPosition(world.two, place[0], place[1], place[2] + 0.01);
  CHECK(message().find("the hinge between body 0 and body 1 is 0.01") != std::string::npos);
  dBodySetPosition(world.two, place[0], place[1], place[2]);
  for (int k = 0; k < 5; ++k) step(1e-3);
  // ODE puts geoms and joints that were touched last in front.
  dBodySetPosition(world.bodies[2], 6, 0, 0);
  const dJointID extra = world.ball(world.one, nullptr, {0, 0, 0});
  motor(1);
  CHECK(message().find("the hinge between body 0 and body 1 has a motor") != std::string::npos);
  motor(0);
  dJointDestroy(extra);
  dBodySetMaxAngularSpeed(world.bodies[2], 10);
  try {
    step(1e-3);
    CHECK(false);
  } catch (const AccurateStepError& error) {
    CHECK(error.body == world.bodies[2]);
    CHECK(std::string(error.what()).find("body 2 has a limited angular speed") != std::string::npos);
  }
}

/// The user changes the world between steps.
void check_changes() {
  Pendulum world;
  AccurateStep step(world.id, world.space);
  step(1e-3);
  CHECK_EQUAL(step.joints(), std::size_t{2});
  dJointDestroy(world.second);
  step(1e-3);
  CHECK_EQUAL(step.joints(), std::size_t{1});
  const double before = dBodyGetLinearVel(world.two)[2];
  step(1e-3);
  CHECK_NEAR(dBodyGetLinearVel(world.two)[2], before - 9.81e-3, 1e-14);  // falls freely
  world.sphere(1, 0.1, {5, 0, 0});
  step(1e-3);
  CHECK_EQUAL(step.bodies(), std::size_t{3});
}

/// Forces of the user act for one step; gravity can be switched off for a body; a body without a geom is named.
void check_forces() {
  World world;
  const dBodyID seen = world.sphere(2, 0.1, {0, 0, 0});
  const dBodyID unseen = dBodyCreate(world.id);
  dBodySetGravityMode(unseen, 0);
  World::place(unseen, {0, 0, 0}, Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitX())));  // torques are the world's
  CHECK_THROWS(AccurateStep(world.id, world.space), AccurateStepError, "found 1 of the world's 2 bodies");
  AccurateStepOptions options;
  options.bodies = {unseen};
  AccurateStep step(world.id, world.space, options);
  CHECK_EQUAL(step.bodies(), std::size_t{2});
  dBodyAddForce(seen, 3, 0, 0);
  dBodyAddTorque(unseen, 0, 0, 0.5);
  step(0.1);
  CHECK_NEAR(dBodyGetLinearVel(seen)[0], 0.15, 1e-15);
  CHECK_NEAR(dBodyGetPosition(seen)[2], -9.81 * 0.005, 1e-15);
  CHECK_EQUAL(dBodyGetLinearVel(unseen)[2], 0.0);
  dMass mass;
  dBodyGetMass(unseen, &mass);
  CHECK_NEAR((vec(dBodyGetAngularVel(unseen)) - Vector3d(0, 0, 0.05 / mass.I[10])).norm(), 0, 1e-14);
  CHECK_EQUAL(dBodyGetForce(seen)[0], 0.0);
  step(0.1);
  CHECK_NEAR(dBodyGetLinearVel(seen)[0], 0.15, 1e-15);
}

/// dJointFeedback: a pendulum at rest carries its weight, and a torque about what its hinge can not turn.
void check_feedback() {
  Pendulum world;
  dJointFeedback first{}, second{};
  dJointSetFeedback(world.first, &first);
  dJointSetFeedback(world.second, &second);
  World::move(world.one, {0, 0, 0}, {0, 0, 0});
  World::move(world.two, {0, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space);
  dBodyAddTorque(world.two, 0, 0.3, 0.2);
  step(1e-3);
  CHECK_NEAR((vec(second.t2) - Vector3d(0, -0.3, -0.2)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(second.t1) - Vector3d(0, 0.3, 0.2)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(first.t1) - Vector3d(0, -0.3, -0.2)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(first.f1) - Vector3d(0, 0, 2 * 9.81)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(second.f1) - Vector3d(0, 0, -9.81)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(second.f2) - Vector3d(0, 0, 9.81)).norm(), 0, 1e-12);
}

}  // namespace

int main() {
  check_unsupported();
  check_bad_numbers();
  check_start_gaps();
  check_large_steps();
  check_vices();
  check_options();
  check_functions_that_throw();
  check_noticed();
  check_names();
  check_changes();
  check_forces();
  check_feedback();
  return odeval::test::verdict();
}
