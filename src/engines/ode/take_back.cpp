#include "engines/ode/take_back.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "engines/ode/library.hpp"
#include "engines/ode/scene.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_ode {
namespace {

Vec3 vector(const dReal* v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

/// Of a unit quaternion w, x, y, z.
Vec3 rotation_vector(const dReal* q) {
  const Vec3 part = (q[0] < 0 ? -1.0 : 1.0) * vector(q + 1);
  const double sine = length(part);
  if (sine == 0) return {};
  return (2 * std::atan2(sine, std::fabs(static_cast<double>(q[0]))) / sine) * part;
}

Body body_of(dBodyID body) {
  dMass mass;
  dBodyGetMass(body, &mass);
  Body taken{.shape = Box{},
             .mass_kg = static_cast<double>(mass.mass),
             .position_m = vector(dBodyGetPosition(body)),
             .attitude = rotation_vector(dBodyGetQuaternion(body)),
             .velocity_m_s = vector(dBodyGetLinearVel(body)),
             .spin_rad_s = vector(dBodyGetAngularVel(body))};
  std::array<double, 9>& inertia = taken.inertia_kgm2.emplace();
  for (std::size_t k = 0; k < 9; ++k) inertia[k] = static_cast<double>(mass.I[k + k / 3]);  // rows of four
  return taken;
}

Vec3 asked(void (*get)(dJointID, dReal*), dJointID joint) {
  dVector3 answer{};
  get(joint, answer);
  return vector(answer);
}

JointKind kind_of(dJointID joint) {
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      return BallJoint{asked(dJointGetBallAnchor, joint)};
    case dJointTypeHinge:
      return HingeJoint{asked(dJointGetHingeAnchor, joint), asked(dJointGetHingeAxis, joint)};
    case dJointTypeSlider:  // which has no anchor: any point does
      return SliderJoint{vector(dBodyGetPosition(dJointGetBody(joint, 0))), asked(dJointGetSliderAxis, joint)};
    case dJointTypeUniversal:
      return UniversalJoint{asked(dJointGetUniversalAnchor, joint), asked(dJointGetUniversalAxis1, joint),
                            asked(dJointGetUniversalAxis2, joint)};
    case dJointTypeFixed:
      return FixedJoint{vector(dBodyGetPosition(dJointGetBody(joint, 0)))};
    default:
      throw MachineError("a joint of a kind that is not taken back from ODE");
  }
}

}  // namespace

Mechanism take_back(const Scenario& scenario) try {
  const Scene scene(scenario);
  Mechanism taken;
  std::vector<dBodyID> bodies;
  for (int i = 0; i < dSpaceGetNumGeoms(scene.space()); ++i) {
    const dGeomID geom = dSpaceGetGeom(scene.space(), i);
    if (dGeomGetBody(geom) != nullptr) bodies.push_back(dGeomGetBody(geom));
  }
  std::ranges::sort(bodies, {}, [](dBodyID body) { return dGeomGetData(dBodyGetFirstGeom(body)); });  // their numbers
  bodies.erase(std::ranges::unique(bodies).begin(), bodies.end());
  for (const dBodyID body : bodies) taken.bodies.push_back(body_of(body));
  const auto number = [&](dBodyID body) {
    return static_cast<std::size_t>(std::ranges::find(bodies, body) - bodies.begin());
  };
  std::set<dJointID> seen;
  for (const dBodyID body : bodies) {
    for (int i = 0; i < dBodyGetNumJoints(body); ++i) {
      const dJointID joint = dBodyGetJoint(body, i);
      if (!seen.insert(joint).second) continue;
      const dBodyID second = dJointGetBody(joint, 1);
      taken.joints.push_back({.kind = kind_of(joint), .first = number(dJointGetBody(joint, 0)), .second = {}});
      if (second != nullptr) taken.joints.back().second = number(second);
    }
  }
  return taken;
} catch (const Fault& fault) {
  throw MachineError("scenario '" + scenario.name + "' can not be built: " + fault.what());
}

}  // namespace odeval::engine_ode
