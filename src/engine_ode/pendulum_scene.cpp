#include "engine_ode/pendulum_scene.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "engine_ode/library.hpp"

namespace odeval::engine_ode {
namespace {

constexpr dReal real(double value) { return static_cast<dReal>(value); }

/// ODE's own word for "no limit".
dReal real_or_infinity(double value) { return std::isinf(value) ? dInfinity : real(value); }

/// Side lengths of the link's box along its body axes.
Vec3 box_sides(const Link& link, const PlanarFrame& frame) {
  Vec3 sides;
  for (std::size_t k = 0; k < 3; ++k) {
    sides[k] = std::fabs(frame.along_body[k]) * link.length_m + std::fabs(frame.across_body[k]) * link.width_m +
               std::fabs(frame.hinge_axis[k]) * link.depth_m;
  }
  return sides;
}

Vec3 moved(const Vec3& from, double length, const Vec3& direction) {
  return {from[0] + length * direction[0], from[1] + length * direction[1], from[2] + length * direction[2]};
}

}  // namespace

PendulumScene::PendulumScene(const Scenario& scenario, int hinges) : PendulumScene() {
  use_library();
  world_ = dWorldCreate();
  space_ = dHashSpaceCreate(nullptr);
  contact_group_ = dJointGroupCreate(0);
  set_world(scenario);
  add_links(scenario, hinges);
  if (scenario.wall) {
    add_wall(scenario);
  } else {
    dCreatePlane(space_, 0, 0, 1, 0);  // the ground of C.1, which its loop never tests for contact
  }
}

PendulumScene::~PendulumScene() {
  if (world_ == nullptr) return;
  dJointGroupDestroy(contact_group_);
  dSpaceDestroy(space_);
  dWorldDestroy(world_);
  dThreadingFreeImplementation(threading_);
}

// The parts of an abandoned world stay reachable until the process ends, so that a leak checker sees they are meant to.
void PendulumScene::abandon() {
  struct Remains {
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    dThreadingImplementationID threading;
    std::vector<dJointFeedback> feedback;
  };
  static auto& graveyard = *new std::vector<std::unique_ptr<Remains>>;
  graveyard.push_back(
      std::make_unique<Remains>(Remains{world_, space_, contact_group_, threading_, std::move(feedback_)}));
  world_ = nullptr;
}

// Every default is set, since some differ between precisions (CFM) and others may between versions.
void PendulumScene::set_world(const Scenario& scenario) {
  // A threading implementation of its own: a fault leaves its unfinished job there and not in the one all worlds share.
  threading_ = dThreadingAllocateSelfThreadedImplementation();
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_), threading_);

  const OdeSettings& ode = scenario.ode;
  dWorldSetGravity(world_, 0, 0, real(-scenario.gravity));
  dWorldSetERP(world_, real(ode.erp));
  dWorldSetCFM(world_, real(ode.cfm));
  dWorldSetQuickStepNumIterations(world_, ode.iterations);
  dWorldSetQuickStepW(world_, real(ode.sor_w));
  dWorldSetContactMaxCorrectingVel(world_, real_or_infinity(ode.max_correcting_vel));
  dWorldSetContactSurfaceLayer(world_, real(ode.surface_layer));
  dWorldSetAutoDisableFlag(world_, 0);
  dWorldSetLinearDamping(world_, 0);
  dWorldSetAngularDamping(world_, 0);
  dWorldSetMaxAngularSpeed(world_, dInfinity);
}

void PendulumScene::add_links(const Scenario& scenario, int hinges) {
  const PlanarFrame& frame = scenario.problem->frame;
  const Vec3 axis = frame.axis();
  Vec3 near = frame.hinge_m;
  Vec3 near_velocity{};
  double angle = 0;
  double rate = 0;
  dBodyID parent = nullptr;
  feedback_.resize(scenario.links.size());

  for (std::size_t i = 0; i < scenario.links.size(); ++i) {
    const Link& link = scenario.links[i];
    angle += scenario.q0[i];
    rate += scenario.qd0[i];
    const Vec3 along = moved(moved({}, std::cos(angle), frame.horizontal), std::sin(angle), frame.up);
    const Vec3 across = cross(axis, along);  // a point at distance s along the link moves with rate * s * across
    const Vec3 centre = moved(near, link.length_m / 2, along);
    const Vec3 velocity = moved(near_velocity, rate * link.length_m / 2, across);

    const dBodyID body = dBodyCreate(world_);
    dBodySetGyroscopicMode(body, 1);
    dBodySetFiniteRotationMode(body, 0);
    dMass mass;
    const Vec3 sides = box_sides(link, frame);
    dMassSetBoxTotal(&mass, real(link.mass_kg), real(sides[0]), real(sides[1]), real(sides[2]));
    dBodySetMass(body, &mass);
    dMatrix3 rotation;
    dRFromAxisAndAngle(rotation, real(axis[0]), real(axis[1]), real(axis[2]), real(angle + frame.rest_turn_rad));
    dBodySetRotation(body, rotation);
    dBodySetPosition(body, real(centre[0]), real(centre[1]), real(centre[2]));
    dBodySetLinearVel(body, real(velocity[0]), real(velocity[1]), real(velocity[2]));
    dBodySetAngularVel(body, real(rate * axis[0]), real(rate * axis[1]), real(rate * axis[2]));
    const dGeomID box = dCreateBox(space_, real(sides[0]), real(sides[1]), real(sides[2]));
    dGeomSetBody(box, body);

    // The first link is body 0 of its hinge, to the world; every other link is body 1, after its parent (C.2).
    // C.5 hangs its link on a further body that a fixed joint holds inside the wall, in contact with it in every step;
    // the world itself is what that body stands for.
    for (int copy = 0; copy < hinges; ++copy) {
      const dJointID hinge = dJointCreateHinge(world_, nullptr);
      if (parent == nullptr) {
        dJointAttach(hinge, body, nullptr);
      } else {
        dJointAttach(hinge, parent, body);
      }
      dJointSetHingeAnchor(hinge, real(near[0]), real(near[1]), real(near[2]));
      dJointSetHingeAxis(hinge, real(frame.hinge_axis[0]), real(frame.hinge_axis[1]), real(frame.hinge_axis[2]));
      if (copy == 0) dJointSetFeedback(hinge, &feedback_[i]);
    }

    bodies_.push_back({dBodyGetPosition(body), dBodyGetRotation(body), dBodyGetLinearVel(body),
                       dBodyGetAngularVel(body), parent == nullptr ? feedback_[i].f1 : feedback_[i].f2});
    parent = body;
    near = moved(near, link.length_m, along);
    near_velocity = moved(near_velocity, rate * link.length_m, across);
  }
}

// The report's wall is a box of 1.8 x 2.0 x 5.5 m whose middle is the origin: face at x = 0.9, top at z = 2.75, below
// the hinge at z = 3. The scenario's wall is the plane of that face, so the box keeps its thickness and grows in height
// (and depth) beyond the link's reach: no link swings over it, and none that the report's wall would stop goes free.
void PendulumScene::add_wall(const Scenario& scenario) {
  const Link& link = scenario.links.front();
  const double reach = std::hypot(link.length_m, link.width_m / 2);
  const double thickness = 1.8;
  const double depth = std::max(2.0, 2 * link.depth_m);
  const double height = std::max(5.5, 2 * (scenario.problem->frame.hinge_m[2] + reach + 1));
  const dGeomID wall = dCreateBox(space_, real(thickness), real(depth), real(height));
  dGeomSetPosition(wall, real(scenario.wall->face_m - thickness / 2), 0, 0);

  surface_.mode = dContactBounce;
  surface_.mu = 0;  // C.5 leaves it unset; the scenario's wall has no friction
  surface_.bounce = real(scenario.ode.bounce.value_or(scenario.wall->restitution));
  surface_.bounce_vel = real(scenario.ode.bounce_vel);
}

void PendulumScene::collide() {
  contacts_ = 0;
  depth_ = 0;
  dSpaceCollide(space_, this, &near_callback);
}

void PendulumScene::near_callback(void* data, dGeomID first, dGeomID second) {
  auto& scene = *static_cast<PendulumScene*>(data);
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
