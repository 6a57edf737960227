#pragma once
// What the examples share: a world that is stepped by dWorldStep, or with the argument `accurate` by
// odeval::AccurateStep.
#include <ode/ode.h>

#include <cstdio>
#include <cstring>
#include <functional>
#include <odeval/accurate_step.hpp>
#include <optional>

class EitherStep {
 public:
  /// All geoms touch each other alike, but for those of bodies that a joint connects; `forces` are added at every step.
  EitherStep(int argc, char** argv, odeval::Bounce touch, odeval::AccurateStepOptions options = {})
      : touch_(touch), forces_(options.forces) {
    dWorldSetGravity(world, 0, 0, -9.81);
    if (argc < 2 || std::strcmp(argv[1], "accurate") != 0) return;
    options.contact = [touch](dGeomID, dGeomID) { return std::optional(touch); };
    options_ = std::move(options);
  }
  ~EitherStep() {
    accurate_.reset();
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space);
    dWorldDestroy(world);
    dCloseODE();
  }
  EitherStep(const EitherStep&) = delete;
  EitherStep& operator=(const EitherStep&) = delete;

  void operator()(double h) {
    if (options_ && !accurate_) accurate_.emplace(world, space, *options_);  // once the world is built
    if (accurate_) return (*accurate_)(h);
    if (forces_) forces_(0);
    dSpaceCollide(space, this, &near);
    dWorldStep(world, h);
    dJointGroupEmpty(contacts_);
  }

  const char* name() const { return options_ ? "AccurateStep" : "dWorldStep"; }

 private:
  static bool started() { return dInitODE2(0) != 0; }
  static void near(void* self, dGeomID one, dGeomID other) {
    const auto& step = *static_cast<EitherStep*>(self);
    const dBodyID a = dGeomGetBody(one), b = dGeomGetBody(other);
    if (a != nullptr && b != nullptr && dAreConnectedExcluding(a, b, dJointTypeContact) != 0) return;
    dContact contact[8]{};
    const int count = dCollide(one, other, 8, &contact[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      contact[i].surface.mode = dContactBounce | dContactApprox1;
      contact[i].surface.mu = step.touch_.friction;
      contact[i].surface.bounce = step.touch_.restitution;
      dJointAttach(dJointCreateContact(step.world, step.contacts_, &contact[i]), a, b);
    }
  }

  bool started_ = started();  // before the world
  odeval::Bounce touch_;
  std::function<void(double)> forces_;
  std::optional<odeval::AccurateStepOptions> options_;
  std::optional<odeval::AccurateStep> accurate_;
  dJointGroupID contacts_ = dJointGroupCreate(0);

 public:
  dWorldID world = dWorldCreate();
  dSpaceID space = dHashSpaceCreate(nullptr);
};

/// A uniform box with a geom.
inline dBodyID box(EitherStep& step, double mass, double x, double y, double z, double length, double width,
                   double height) {
  const dBodyID body = dBodyCreate(step.world);
  dMass m;
  dMassSetBoxTotal(&m, mass, length, width, height);
  dBodySetMass(body, &m);
  dBodySetPosition(body, x, y, z);
  dGeomSetBody(dCreateBox(step.space, length, width, height), body);
  return body;
}

inline dBodyID ball(EitherStep& step, double mass, double x, double y, double z, double radius) {
  const dBodyID body = dBodyCreate(step.world);
  dMass m;
  dMassSetSphereTotal(&m, mass, radius);
  dBodySetMass(body, &m);
  dBodySetPosition(body, x, y, z);
  dGeomSetBody(dCreateSphere(step.space, radius), body);
  return body;
}

inline dJointID hinge(EitherStep& step, dBodyID a, dBodyID b, double x, double y, double z) {
  const dJointID joint = dJointCreateHinge(step.world, nullptr);
  dJointAttach(joint, a, b);
  dJointSetHingeAnchor(joint, x, y, z);
  dJointSetHingeAxis(joint, 0, 1, 0);
  return joint;
}
