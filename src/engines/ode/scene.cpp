#include "engines/ode/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engines/ode/library.hpp"
#include "odeval/error.hpp"

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

// Without friction mu is 0, and there is nothing to share, approximate or lay. What a spring and a damper give back is
// theirs, whatever [ode] says of bounces.
Surface surface_of(const Contact& contact, const OdeSettings& ode, double step_s) {
  Surface surface;
  surface.parameters.mode = contact.spring ? 0 : dContactBounce;
  surface.parameters.bounce = real(contact.spring ? 0 : ode.bounce.value_or(contact.restitution));
  surface.parameters.bounce_vel = real(ode.bounce_vel);
  if (const std::optional<Softness> own = contact.softness_at(step_s)) {
    surface.parameters.mode |= dContactSoftERP | dContactSoftCFM;
    surface.parameters.soft_erp = real(own->erp);
    surface.parameters.soft_cfm = real(own->cfm);
  }
  if (!contact.friction) return surface;
  surface.parameters.mu = real(contact.friction->limit);
  surface.shared = contact.friction->model == FrictionModel::constant;
  if (!surface.shared) surface.parameters.mode |= dContactApprox1;
  surface.along_sliding = ode.friction_axes == FrictionAxes::sliding;
  return surface;
}

/// Whether cylinders touch cylinders and capsules: ODE has that of libccd, which a build may leave out, and then finds
/// no contact.
bool has_libccd() {
  const std::array geoms{dCreateCylinder(nullptr, 1, 1), dCreateCylinder(nullptr, 1, 1)};
  dGeomSetPosition(geoms[1], real(0.5), real(0.25), real(0.125));
  dContactGeom contact;
  const int found = dCollide(geoms[0], geoms[1], 1, &contact, sizeof contact);
  for (const dGeomID geom : geoms) dGeomDestroy(geom);
  return found > 0;
}

/// Whether a cylinder of the one may touch a bar of the other.
bool meet(const std::vector<Contact>& contacts, const Body& first, const Body& second) {
  const auto may_touch = [&](const Part& one, const Part& other) {
    return std::ranges::any_of(contacts, [&](const Contact& contact) {
      return contact.is_between(first.touches_as(one), second.touches_as(other));
    });
  };
  for (const Part& one : first.parts()) {
    if (!std::holds_alternative<Cylinder>(one.shape)) continue;
    for (const Part& other : second.parts()) {
      if (is_bar(other.shape) && may_touch(one, other)) return true;
    }
  }
  return false;
}

/// Throws UserError for bodies that should touch and would pass through each other.
void check_shapes(const Mechanism& mechanism) {
  for (const Body& first : mechanism.bodies) {
    for (const Body& second : mechanism.bodies) {
      if (&first == &second || !meet(mechanism.contacts, first, second)) continue;
      if (has_libccd()) return;
      throw UserError(
          "bodies '" + first.name + "' and '" + second.name +
          "' cannot touch: this ODE was built without libccd, which has cylinders touch cylinders and capsules");
    }
  }
}

}  // namespace

Scene::Scene(const Scenario& scenario) : Scene() {
  use_library();
  world_ = dWorldCreate();
  space_ = dHashSpaceCreate(nullptr);
  contact_group_ = dJointGroupCreate(0);
  set_world(scenario);
  add_mechanism(scenario);
  set_surfaces(scenario);
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

void Scene::add_mechanism(const Scenario& scenario) {
  const Mechanism& mechanism = scenario.mechanism;
  std::vector<dBodyID> bodies;
  for (const Body& what : mechanism.bodies) {
    const dBodyID body = bodies.emplace_back(make_body(world_, space_, what, scenario.ode));
    // ODE puts a body's newest geom first.
    std::vector<Part> parts = what.parts();
    for (dGeomID geom = dBodyGetFirstGeom(body); geom != nullptr; geom = dBodyGetNextGeom(geom)) {
      number(geom, what.touches_as(parts.back()));
      parts.pop_back();
    }
    bodies_.push_back(
        {dBodyGetPosition(body), dBodyGetRotation(body), dBodyGetLinearVel(body), dBodyGetAngularVel(body)});
  }
  for (const Joint& joint : mechanism.joints) {
    add_joint(joint, make_joint(world_, joint, bodies, mechanism.bodies, scenario.step_s));
  }
  for (const Strut& strut : mechanism.struts) {
    loads_.add(bodies[strut.first], strut.second ? bodies[*strut.second] : nullptr, strut);
  }
  for (const Obstacle& obstacle : mechanism.obstacles) number(make_obstacle(space_, obstacle), obstacle.name);
}

void Scene::add_joint(const Joint& joint, dJointID made) {
  dJointFeedback& feedback = *feedback_.emplace_back(std::make_unique<dJointFeedback>());
  dJointSetFeedback(made, &feedback);
  joint_forces_.push_back(joint.second ? feedback.f2 : feedback.f1);
  joints_.push_back(made);
  loads_.add(made, joint);
}

/// A geom knows its number, counted from 1.
void Scene::number(dGeomID geom, std::string_view name) {
  names_.emplace_back(name);
  dGeomSetData(geom, reinterpret_cast<void*>(names_.size()));
}

void Scene::set_surfaces(const Scenario& scenario) {
  const std::vector<Contact>& contacts = scenario.mechanism.contacts;
  if (contacts.empty()) return;
  check_shapes(scenario.mechanism);
  for (const Contact& contact : contacts) surfaces_.push_back(surface_of(contact, scenario.ode, scenario.step_s));
  for (const std::string& first : names_) {
    for (const std::string& second : names_) {
      const auto found =
          std::ranges::find_if(contacts, [&](const Contact& contact) { return contact.is_between(first, second); });
      of_pair_.push_back(found == contacts.end() ? nullptr
                                                 : &surfaces_[static_cast<std::size_t>(found - contacts.begin())]);
    }
  }
}

const Surface* Scene::surface_between(dGeomID first, dGeomID second) const {
  if (of_pair_.empty()) return nullptr;
  const auto number = [](dGeomID geom) { return reinterpret_cast<std::size_t>(dGeomGetData(geom)) - 1; };
  return of_pair_[number(first) * names_.size() + number(second)];
}

void Scene::collide() {
  contacts_ = 0;
  depth_ = 0;
  touches_.clear();
  dSpaceCollide(space_, this, &near_callback);
}

void Scene::near_callback(void* data, dGeomID first, dGeomID second) {
  auto& scene = *static_cast<Scene*>(data);
  const dBodyID body1 = dGeomGetBody(first);
  const dBodyID body2 = dGeomGetBody(second);
  if (body1 == nullptr && body2 == nullptr) return;  // two obstacles
  if (body1 != nullptr && body2 != nullptr && dAreConnectedExcluding(body1, body2, dJointTypeContact) != 0) return;
  const Surface* const surface = scene.surface_between(first, second);
  if (surface == nullptr) return;

  constexpr int most = 20;
  dContactGeom found[most];
  const int count = dCollide(first, second, most, found, sizeof(dContactGeom));
  for (int i = 0; i < count; ++i) {
    dContact contact{};
    contact.surface = surface->parameters;
    contact.geom = found[i];
    if (surface->shared) contact.surface.mu /= real(count);
    if (surface->along_sliding) lay_along_sliding(contact, body1, body2);
    const dJointID joint = dJointCreateContact(scene.world_, scene.contact_group_, &contact);
    dJointAttach(joint, body1, body2);
    if (scene.keeps_touches_) dJointSetFeedback(joint, &scene.touches_.emplace_back(Touch{body1, body2}).feedback);
    scene.depth_ = std::max(scene.depth_, static_cast<double>(found[i].depth));
  }
  scene.contacts_ += count;
}

}  // namespace odeval::engine_ode
