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

void add_body(Scene& scene, const Body& what) {
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
  dBodySetPosition(body, real(what.position_m[0]), real(what.position_m[1]), real(what.position_m[2]));
  dBodySetLinearVel(body, real(what.velocity_m_s[0]), real(what.velocity_m_s[1]), real(what.velocity_m_s[2]));
  dBodySetAngularVel(body, real(what.spin_rad_s[0]), real(what.spin_rad_s[1]), real(what.spin_rad_s[2]));
  scene.show(body, nullptr);
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
  for (const Body& body : scenario.bodies) add_body(scene, body);
  if (scenario.ground) add_ground(scene, scenario);
}

}  // namespace odeval::engine_ode
