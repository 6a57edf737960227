// What the accurate step does not do, and worlds it can not start from: a clear error, and nothing changed.
#include <cstring>
#include <functional>
#include <limits>

#include "engine_rk4/accurate_step.hpp"
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
  refused("has stops", [](Pendulum& w) { dJointSetHingeParam(w.first, dParamLoStop, -1); });
  refused("has stops", [](Pendulum& w) { dJointSetHingeParam(w.first, dParamHiStop, 1); });
  refused("has a motor", [](Pendulum& w) { dJointSetHingeParam(w.second, dParamFMax, 1); });
  refused("kind that is not supported", [](Pendulum& w) {
    const dJointID joint = dJointCreateHinge2(w.id, nullptr);
    dJointAttach(joint, w.one, w.two);
  });
  refused("kinematic", [](Pendulum& w) { dBodySetKinematic(w.one); });
  refused("disabled", [](Pendulum& w) { dBodyDisable(w.two); });
  refused("damped", [](Pendulum& w) { dBodySetLinearDamping(w.two, 0.1); });
  refused("damped", [](Pendulum& w) { dBodySetAngularDamping(w.one, 0.1); });
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
  CHECK_NEAR(dBodyGetAngularVel(unseen)[2], 0.05 / mass.I[10], 1e-14);
  CHECK_EQUAL(dBodyGetForce(seen)[0], 0.0);
  step(0.1);
  CHECK_NEAR(dBodyGetLinearVel(seen)[0], 0.15, 1e-15);
}

/// dJointFeedback: a pendulum at rest carries its weight; moving, Newton's law for each body.
void check_feedback() {
  Pendulum world;
  dJointFeedback first{}, second{};
  dJointSetFeedback(world.first, &first);
  dJointSetFeedback(world.second, &second);
  World::move(world.one, {0, 0, 0}, {0, 0, 0});
  World::move(world.two, {0, 0, 0}, {0, 0, 0});
  AccurateStep step(world.id, world.space);
  step(1e-3);
  CHECK_NEAR((vec(first.f1) - Vector3d(0, 0, 2 * 9.81)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(second.f1) - Vector3d(0, 0, -9.81)).norm(), 0, 1e-12);
  CHECK_NEAR((vec(second.f2) - Vector3d(0, 0, 9.81)).norm(), 0, 1e-12);
}

}  // namespace

int main() {
  check_unsupported();
  check_bad_numbers();
  check_start_gaps();
  check_changes();
  check_forces();
  check_feedback();
  return odeval::test::verdict();
}
