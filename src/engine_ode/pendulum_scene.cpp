#include "engine_ode/pendulum_scene.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::engine_ode {
namespace {

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

void add_links(Scene& scene, const Scenario& scenario, int hinges) {
  const PlanarFrame& frame = scenario.problem->frame;
  const Vec3 axis = frame.axis();
  Vec3 near = frame.hinge_m;
  Vec3 near_velocity{};
  double angle = 0;
  double rate = 0;
  dBodyID parent = nullptr;

  for (std::size_t i = 0; i < scenario.links.size(); ++i) {
    const Link& link = scenario.links[i];
    angle += scenario.q0[i];
    rate += scenario.qd0[i];
    const Vec3 along = moved(moved({}, std::cos(angle), frame.horizontal), std::sin(angle), frame.up);
    const Vec3 across = cross(axis, along);  // a point at distance s along the link moves with rate * s * across
    const Vec3 centre = moved(near, link.centre_m(), along);
    const Vec3 velocity = moved(near_velocity, rate * link.centre_m(), across);

    const Vec3 sides = box_sides(link, frame);
    dMass mass;
    dGeomID geom = nullptr;
    if (link.shape == Shape::box) {
      dMassSetBoxTotal(&mass, real(link.mass_kg), real(sides[0]), real(sides[1]), real(sides[2]));
      geom = dCreateBox(scene.space(), real(sides[0]), real(sides[1]), real(sides[2]));
    } else {
      dMassSetSphereTotal(&mass, real(link.mass_kg), real(link.width_m / 2));
      geom = dCreateSphere(scene.space(), real(link.width_m / 2));
    }
    const dBodyID body = scene.add_body(mass, geom);
    dMatrix3 rotation;
    dRFromAxisAndAngle(rotation, real(axis[0]), real(axis[1]), real(axis[2]), real(angle + frame.rest_turn_rad));
    dBodySetRotation(body, rotation);
    dBodySetPosition(body, real(centre[0]), real(centre[1]), real(centre[2]));
    dBodySetLinearVel(body, real(velocity[0]), real(velocity[1]), real(velocity[2]));
    dBodySetAngularVel(body, real(rate * axis[0]), real(rate * axis[1]), real(rate * axis[2]));

    // The first link is body 0 of its hinge, to the world; every other link is body 1, after its parent (C.2).
    // C.5 hangs its link on a further body that a fixed joint holds inside the wall, in contact with it in every step;
    // the world itself is what that body stands for.
    dJointID first = nullptr;
    for (int copy = 0; copy < hinges; ++copy) {
      const dJointID hinge = dJointCreateHinge(scene.world(), nullptr);
      if (parent == nullptr) {
        dJointAttach(hinge, body, nullptr);
      } else {
        dJointAttach(hinge, parent, body);
      }
      dJointSetHingeAnchor(hinge, real(near[0]), real(near[1]), real(near[2]));
      dJointSetHingeAxis(hinge, real(frame.hinge_axis[0]), real(frame.hinge_axis[1]), real(frame.hinge_axis[2]));
      if (copy == 0) first = hinge;
    }
    scene.show(body, first);
    parent = body;
    near = moved(near, link.length_m, along);
    near_velocity = moved(near_velocity, rate * link.length_m, across);
  }
}

// The report's wall is a box of 1.8 x 2.0 x 5.5 m whose middle is the origin: face at x = 0.9, top at z = 2.75, below
// the hinge at z = 3. The scenario's wall is the plane of that face, so the box keeps its thickness and grows in height
// (and depth) beyond the link's reach: no link swings over it, and none that the report's wall would stop goes free.
void add_wall(Scene& scene, const Scenario& scenario) {
  const Link& link = scenario.links.front();
  const double reach = std::hypot(link.length_m, link.width_m / 2);
  const double thickness = 1.8;
  const double depth = std::max(2.0, 2 * link.depth_m);
  const double height = std::max(5.5, 2 * (scenario.problem->frame.hinge_m[2] + reach + 1));
  const dGeomID wall = dCreateBox(scene.space(), real(thickness), real(depth), real(height));
  dGeomSetPosition(wall, real(scenario.wall->face_m - thickness / 2), 0, 0);

  Surface surface;
  surface.parameters.mode = dContactBounce;
  surface.parameters.mu = 0;  // C.5 leaves it unset; the scenario's wall has no friction
  surface.parameters.bounce = real(scenario.ode.bounce.value_or(scenario.restitution()));
  surface.parameters.bounce_vel = real(scenario.ode.bounce_vel);
  scene.set_surface(surface);
}

void build(Scene& scene, const Scenario& scenario, int hinges) {
  add_links(scene, scenario, hinges);
  if (scenario.wall) {
    add_wall(scene, scenario);
  } else {
    dCreatePlane(scene.space(), 0, 0, 1, 0);  // the ground of C.1, which its loop never tests for contact
  }
}

}  // namespace

void build_pendulum(Scene& scene, const Scenario& scenario) { build(scene, scenario, 1); }

void build_doubled_pendulum(Scene& scene, const Scenario& scenario) { build(scene, scenario, 2); }

}  // namespace odeval::engine_ode
