#include "engine_ode/scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine_ode/library.hpp"

namespace odeval::engine_ode {
namespace {

/// ODE's own word for "no limit".
dReal real_or_infinity(double value) { return std::isinf(value) ? dInfinity : real(value); }

/// The first direction of friction along the way the contact slides, where it slides at all.
void lay_along_sliding(dContact& contact, dBodyID body1, dBodyID body2) {
  const dReal* const p = contact.geom.pos;
  const dReal* const n = contact.geom.normal;
  Vec3 slip{};
  for (const auto& [body, sign] : {std::pair{body1, 1.0}, std::pair{body2, -1.0}}) {
    if (body == nullptr) continue;
    dVector3 velocity;
    dBodyGetPointVel(body, p[0], p[1], p[2], velocity);
    for (std::size_t k = 0; k < 3; ++k) slip[k] += sign * static_cast<double>(velocity[k]);
  }
  const Vec3 normal{n[0], n[1], n[2]};
  const double away = dot(slip, normal);
  for (std::size_t k = 0; k < 3; ++k) slip[k] -= away * normal[k];
  const double speed = std::sqrt(dot(slip, slip));
  constexpr double noticeable = 1e-9;  // m/s; slower, the direction is rounding
  if (speed < noticeable) return;
  contact.surface.mode |= dContactFDir1;
  for (std::size_t k = 0; k < 3; ++k) contact.fdir1[k] = real(slip[k] / speed);
}

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
  gyroscopic_ = ode.gyroscopic;  // of bodies, not of the world
  dWorldSetAutoDisableFlag(world_, 0);
  dWorldSetLinearDamping(world_, 0);
  dWorldSetAngularDamping(world_, 0);
  dWorldSetMaxAngularSpeed(world_, dInfinity);
}

dBodyID Scene::add_body(const dMass& mass, dGeomID geom) {
  const dBodyID body = dBodyCreate(world_);
  dBodySetGyroscopicMode(body, gyroscopic_ ? 1 : 0);
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
    contact.surface = scene.surface_.parameters;
    contact.geom = found[i];
    if (scene.surface_.shared) contact.surface.mu /= real(count);
    if (scene.surface_.along_sliding) lay_along_sliding(contact, body1, body2);
    const dJointID joint = dJointCreateContact(scene.world_, scene.contact_group_, &contact);
    dJointAttach(joint, body1, body2);
    scene.depth_ = std::max(scene.depth_, static_cast<double>(found[i].depth));
  }
  scene.contacts_ += count;
}

}  // namespace odeval::engine_ode
