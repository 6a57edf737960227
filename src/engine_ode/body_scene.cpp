#include "engine_ode/body_scene.hpp"

#include <cmath>

namespace odeval::engine_ode {
namespace {

void turn(dBodyID body, const Vec3& turn_rad) {
  const double angle = std::sqrt(dot(turn_rad, turn_rad));
  if (angle == 0) return;
  dQuaternion quaternion;
  const double part = std::sin(angle / 2) / angle;
  quaternion[0] = real(std::cos(angle / 2));
  for (std::size_t k = 0; k < 3; ++k) quaternion[k + 1] = real(part * turn_rad[k]);
  dBodySetQuaternion(body, quaternion);
}

void put(dBodyID body, const Vec3& position) {
  dBodySetPosition(body, real(position[0]), real(position[1]), real(position[2]));
}

dBodyID add_body(Scene& scene, const Body& what) {
  const auto [x, y, z] = what.size_m;
  dMass mass;
  dGeomID geom = nullptr;
  if (what.shape == Shape::sphere) {
    dMassSetSphereTotal(&mass, real(what.mass_kg), real(x / 2));
    geom = dCreateSphere(scene.space(), real(x / 2));
  } else {
    dMassSetBoxTotal(&mass, real(what.mass_kg), real(x), real(y), real(z));
    geom = dCreateBox(scene.space(), real(x), real(y), real(z));
  }
  const dBodyID body = scene.add_body(mass, geom);
  turn(body, what.turn_rad);
  put(body, what.position_m);
  dBodySetLinearVel(body, real(what.velocity_m_s[0]), real(what.velocity_m_s[1]), real(what.velocity_m_s[2]));
  dBodySetAngularVel(body, real(what.spin_rad_s[0]), real(what.spin_rad_s[1]), real(what.spin_rad_s[2]));
  return body;
}

// A joint remembers where the bodies were when it was given its anchor: the first body stands in its place for that.
dJointID add_joint(Scene& scene, const Scenario& scenario, const std::vector<dBodyID>& bodies) {
  const Joint& what = *scenario.joint;
  const Vec3& start = scenario.bodies.front().position_m;
  put(bodies[0],
      {start[0] - what.displacement_m[0], start[1] - what.displacement_m[1], start[2] - what.displacement_m[2]});
  const dBodyID other = bodies.size() > 1 ? bodies[1] : nullptr;
  const auto& [x, y, z] = what.anchor_m;
  dJointID joint = nullptr;
  if (what.kind == Joint::Kind::hinge) {
    joint = dJointCreateHinge(scene.world(), nullptr);
    dJointAttach(joint, bodies[0], other);
    dJointSetHingeAnchor(joint, real(x), real(y), real(z));
    dJointSetHingeAxis(joint, real(what.axis[0]), real(what.axis[1]), real(what.axis[2]));
  } else {
    joint = dJointCreateBall(scene.world(), nullptr);
    dJointAttach(joint, bodies[0], other);
    dJointSetBallAnchor(joint, real(x), real(y), real(z));
  }
  put(bodies[0], start);
  return joint;
}

void add_ground(Scene& scene, const Scenario& scenario) {
  const Vec3 normal = scenario.ground->normal();
  dCreatePlane(scene.space(), real(normal[0]), real(normal[1]), real(normal[2]), 0);

  Surface surface;
  surface.parameters.mode = dContactBounce;
  surface.parameters.bounce = real(scenario.ode.bounce.value_or(scenario.restitution()));
  surface.parameters.bounce_vel = real(scenario.ode.bounce_vel);
  surface.parameters.mu = real(scenario.ground->friction);
  surface.shared = scenario.ground->friction_model == FrictionModel::constant;
  if (!surface.shared) surface.parameters.mode |= dContactApprox1;
  surface.along_sliding = scenario.ode.friction_axes == FrictionAxes::sliding;
  scene.set_surface(surface);
}

}  // namespace

void build_bodies(Scene& scene, const Scenario& scenario) {
  std::vector<dBodyID> bodies;
  for (const Body& body : scenario.bodies) bodies.push_back(add_body(scene, body));
  const dJointID joint = scenario.joint ? add_joint(scene, scenario, bodies) : nullptr;
  for (const dBodyID body : bodies) scene.show(body, joint);
  if (scenario.ground) add_ground(scene, scenario);
}

}  // namespace odeval::engine_ode
