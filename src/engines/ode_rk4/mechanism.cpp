#include "engines/ode_rk4/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <new>
#include <set>
#include <string_view>

#include "engines/ode_rk4/joint_reader.hpp"
#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

std::string name(std::size_t body) { return body == world_body ? "the world" : "body " + std::to_string(body); }

std::string kind(dJointID joint) {
  if (joint == nullptr) return "contact that sticks";
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      return "ball joint";
    case dJointTypeHinge:
      return "hinge";
    case dJointTypeSlider:
      return "slider";
    case dJointTypeUniversal:
      return "universal joint";
    case dJointTypeFixed:
      return "fixed joint";
    case dJointTypeAMotor:
      return "angular motor";
    case dJointTypeLMotor:
      return "linear motor";
    case dJointTypeHinge2:
      return "hinge2";
    case dJointTypePiston:
      return "piston";
    case dJointTypePR:
      return "PR joint";
    case dJointTypePU:
      return "PU joint";
    case dJointTypePlane2D:
      return "plane2d";
    case dJointTypeDBall:
      return "double ball joint";
    case dJointTypeDHinge:
      return "double hinge";
    case dJointTypeTransmission:
      return "transmission";
    case dJointTypeContact:
      return "contact joint";
    default:
      return "joint of another kind";
  }
}

std::vector<dBodyID> discover(dWorldID world, dSpaceID space, std::span<dxBody* const> given,
                              const std::map<dBodyID, std::size_t>& earlier) {
  std::vector<dBodyID> found;
  std::set<dBodyID> known;
  const auto meet = [&](dBodyID body) {
    if (body != nullptr && dBodyGetWorld(body) == world && known.insert(body).second) found.push_back(body);
  };
  const auto meet_geoms = [&](const auto& self, dSpaceID in) -> void {
    for (int i = dSpaceGetNumGeoms(in); i-- > 0;) {  // the newest is the first
      const dGeomID geom = dSpaceGetGeom(in, i);
      if (dGeomIsSpace(geom) != 0) {
        self(self, reinterpret_cast<dSpaceID>(geom));
      } else {
        meet(dGeomGetBody(geom));
      }
    }
  };
  for (const dBodyID body : given) meet(body);
  if (space != nullptr) meet_geoms(meet_geoms, space);
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (int j = 0; j < dBodyGetNumJoints(found[i]); ++j) {
      const dJointID joint = dBodyGetJoint(found[i], j);
      meet(dJointGetBody(joint, 0));
      meet(dJointGetBody(joint, 1));
    }
  }
  std::ranges::stable_sort(found, {}, [&](dBodyID body) {
    const auto known_as = earlier.find(body);
    return known_as == earlier.end() ? earlier.size() : known_as->second;
  });
  return found;
}

/// ODE has no list of a world's bodies, but writes them down.
std::size_t bodies_in(dWorldID world) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const file = open_memstream(&text, &size);
  if (file == nullptr) throw std::bad_alloc();
  dWorldExportDIF(world, file, "");
  std::fclose(file);
  const std::string_view written(text, size), body = "= dynamics.body {";
  std::size_t count = 0;
  for (std::size_t at = 0; (at = written.find(body, at)) != std::string_view::npos; at += body.size()) ++count;
  std::free(text);
  return count;
}

Body read_body(dBodyID id, std::size_t number) {
  const auto refuse_if = [&](bool bad, const char* why) {
    if (bad) refuse(name(number) + why, id);
  };
  refuse_if(dBodyGetMaxAngularSpeed(id) < dInfinity, " has a limited angular speed; set it to dInfinity");
  refuse_if(dBodyGetGyroscopicMode(id) == 0, " has its gyroscopic term off; set its gyroscopic mode to 1");
  dMass mass;
  dBodyGetMass(id, &mass);
  Body body{id,
            1 / mass.mass,
            {},
            {},
            {dBodyGetLinearDamping(id), dBodyGetLinearDampingThreshold(id)},
            {dBodyGetAngularDamping(id), dBodyGetAngularDampingThreshold(id)}};
  for (const Damping& damping : {body.linear, body.angular}) {
    refuse_if(!(damping.share >= 0 && damping.share < 1), " has a damping that is not at least 0 and less than 1");
  }
  if (dBodyIsKinematic(id) != 0) {
    body.inverse_mass = 0;
    body.inertia = body.inverse_inertia = Matrix3d::Zero();
    body.linear.share = body.angular.share = 0;
    return body;
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) body.inertia(i, j) = mass.I[4 * i + j];
  }
  const Eigen::LLT<Matrix3d> cholesky(body.inertia);
  refuse_if(
      !(mass.mass > 0) || !std::isfinite(mass.mass) || !body.inertia.allFinite() || cholesky.info() != Eigen::Success,
      " has no positive mass and inertia");
  body.inverse_inertia = cholesky.solve(Matrix3d::Identity());
  return body;
}

}  // namespace

std::string name(const Joint& joint) {
  return "the " + kind(joint.id) + " between " + name(joint.a) + " and " + name(joint.b);
}

Mechanism read_mechanism(dWorldID world, dSpaceID space, std::span<dxBody* const> given, const Mechanism& earlier,
                         const LMotorRel& lmotor_rel) {
  Mechanism mechanism;
  for (const dBodyID body : discover(world, space, given, earlier.numbers)) {
    mechanism.numbers.emplace(body, mechanism.bodies.size());
    mechanism.bodies.push_back(read_body(body, mechanism.bodies.size()));
  }
  if (mechanism.bodies.empty()) {
    refuse("found no body: give the space that holds their geoms, or name them in AccurateStepOptions::bodies");
  }
  if (const std::size_t all = bodies_in(world); all > mechanism.bodies.size()) {
    refuse("found " + std::to_string(mechanism.bodies.size()) + " of the world's " + std::to_string(all) +
           " bodies: the others have no geom in the space, and no joint to one that has; name them in "
           "AccurateStepOptions::bodies");
  }
  std::set<dJointID> known;
  for (const Body& body : mechanism.bodies) {
    for (int j = 0; j < dBodyGetNumJoints(body.id); ++j) {
      const dJointID id = dBodyGetJoint(body.id, j);
      if (dJointIsEnabled(id) == 0 || !known.insert(id).second) continue;
      add(mechanism, read_joint(id, mechanism.numbers, lmotor_rel));
    }
  }
  read_motors(mechanism);
  return mechanism;
}

void add(Mechanism& mechanism, Joint joint) {
  const std::size_t number = mechanism.joints.size();
  for (std::size_t i = 0; i < number; ++i) {
    const Joint& other = mechanism.joints[i];
    const auto shared = [&](std::size_t body) { return body != world_body && (body == other.a || body == other.b); };
    if (shared(joint.a) || shared(joint.b)) mechanism.neighbours.emplace_back(i, number);
  }
  mechanism.joints.push_back(std::move(joint));
}

Parameters parameters_of(dJointID joint) {
  switch (dJointGetType(joint)) {
    case dJointTypeHinge:
      return {dJointGetHingeParam, 1};
    case dJointTypeSlider:
      return {dJointGetSliderParam, 1};
    case dJointTypeUniversal:
      return {dJointGetUniversalParam, 2};
    case dJointTypeHinge2:
      return {dJointGetHinge2Param, 2};
    case dJointTypePiston:
      return {dJointGetPistonParam, 2};
    case dJointTypePR:
      return {dJointGetPRParam, 2};
    case dJointTypePU:
      return {dJointGetPUParam, 3};
    case dJointTypeAMotor:
      return {dJointGetAMotorParam, dJointGetAMotorNumAxes(joint)};
    case dJointTypeLMotor:
      return {dJointGetLMotorParam, dJointGetLMotorNumAxes(joint)};
    default:
      return {nullptr, 0};
  }
}

void read_motors(Mechanism& mechanism) {
  for (Joint& joint : mechanism.joints) {
    if (joint.motors.empty()) continue;
    const Parameters parameters = parameters_of(joint.id);
    for (Motor& motor : joint.motors) {
      motor.velocity = parameters.get(joint.id, dParamVel + motor.group);
      motor.most = parameters.get(joint.id, dParamFMax + motor.group);
      if (!std::isfinite(motor.velocity) || !(motor.most >= 0)) {
        refuse(name(joint) + " has a motor with a velocity that is not finite, or no limit of force of 0 or more",
               mechanism.bodies[joint.a].id, joint.id);
      }
    }
  }
}

}  // namespace odeval::engine_rk4
