#include "engine_ode/scene.hpp"

#include <algorithm>
#include <cmath>

#include "engine_ode/library.hpp"

namespace odeval::engine_ode {
namespace {

/// ODE's own word for "no limit".
dReal real_or_infinity(double value) { return std::isinf(value) ? dInfinity : real(value); }

}  // namespace

Scene::Scene(const Scenario& scenario) : Scene() {
  use_library();
  world_ = dWorldCreate();
  space_ = dHashSpaceCreate(nullptr);
  contact_group_ = dJointGroupCreate(0);
  set_world(scenario);
}

Scene::~Scene() {
  if (world_ == nullptr) return;
  dJointGroupDestroy(contact_group_);
  dSpaceDestroy(space_);
  dWorldDestroy(world_);
  dThreadingFreeImplementation(threading_);
}

// The parts of an abandoned world stay reachable until the process ends, so that a leak checker sees they are meant to.
void Scene::abandon() {
  struct Remains {
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    dThreadingImplementationID threading;
    std::vector<std::unique_ptr<dJointFeedback>> feedback;
  };
  static auto& graveyard = *new std::vector<std::unique_ptr<Remains>>;
  graveyard.push_back(
      std::make_unique<Remains>(Remains{world_, space_, contact_group_, threading_, std::move(feedback_)}));
  world_ = nullptr;
}

// Every default is set, since some differ between precisions (CFM) and others may between versions.
void Scene::set_world(const Scenario& scenario) {
  // A threading implementation of its own: a fault leaves its unfinished job there and not in the one all worlds share.
  threading_ = dThreadingAllocateSelfThreadedImplementation();
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_), threading_);

  const OdeSettings& ode = scenario.ode;
  dWorldSetGravity(world_, 0, 0, real(-scenario.gravity));
  const Softness softness = ode.softness(scenario.step_s);
  dWorldSetERP(world_, real(softness.erp));
  dWorldSetCFM(world_, real(softness.cfm));
  dWorldSetQuickStepNumIterations(world_, ode.iterations);
  dWorldSetQuickStepW(world_, real(ode.sor_w));
  dWorldSetContactMaxCorrectingVel(world_, real_or_infinity(ode.max_correcting_vel));
  dWorldSetContactSurfaceLayer(world_, real(ode.surface_layer));
  dWorldSetAutoDisableFlag(world_, 0);
  dWorldSetLinearDamping(world_, 0);
  dWorldSetAngularDamping(world_, 0);
  dWorldSetMaxAngularSpeed(world_, dInfinity);
}

dBodyID Scene::add_body(const dMass& mass, dGeomID geom) {
  const dBodyID body = dBodyCreate(world_);
  dBodySetGyroscopicMode(body, 1);
  dBodySetFiniteRotationMode(body, 0);
  dBodySetMass(body, &mass);
  dGeomSetBody(geom, body);
  return body;
}

void Scene::show(dBodyID body, dJointID joint) {
  const dReal* force = nullptr;
  if (joint != nullptr) {
    if (dJointGetFeedback(joint) == nullptr) {
      dJointSetFeedback(joint, feedback_.emplace_back(std::make_unique<dJointFeedback>()).get());
    }
    dJointFeedback& feedback = *dJointGetFeedback(joint);
    force = dJointGetBody(joint, 0) == body ? feedback.f1 : feedback.f2;
  }
  bodies_.push_back(
      {dBodyGetPosition(body), dBodyGetRotation(body), dBodyGetLinearVel(body), dBodyGetAngularVel(body), force});
}

void Scene::collide() {
  contacts_ = 0;
  depth_ = 0;
  dSpaceCollide(space_, this, &near_callback);
}

void Scene::near_callback(void* data, dGeomID first, dGeomID second) {
  auto& scene = *static_cast<Scene*>(data);
  const dBodyID body1 = dGeomGetBody(first);
  const dBodyID body2 = dGeomGetBody(second);
  if (body1 != nullptr && body2 != nullptr && dAreConnectedExcluding(body1, body2, dJointTypeContact) != 0) return;

  constexpr int most = 20;
  dContactGeom found[most];
  const int count = dCollide(first, second, most, found, sizeof(dContactGeom));
  for (int i = 0; i < count; ++i) {
    dContact contact{};
    contact.surface = scene.surface_;
    contact.geom = found[i];
    const dJointID joint = dJointCreateContact(scene.world_, scene.contact_group_, &contact);
    dJointAttach(joint, body1, body2);
    scene.depth_ = std::max(scene.depth_, static_cast<double>(found[i].depth));
  }
  scene.contacts_ += count;
}

}  // namespace odeval::engine_ode
