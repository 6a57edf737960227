#include "engines/ode_rk4/watch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace odeval::engine_rk4 {
namespace {

std::uint64_t bits(const void* pointer) { return reinterpret_cast<std::uintptr_t>(pointer); }
std::uint64_t bits(double number) { return std::bit_cast<std::uint64_t>(number); }
std::uint64_t bits(int number) { return static_cast<std::uint64_t>(number); }

/// Spreads every bit over all (the finalizer of splitmix64, Steele, Lea & Flood 2014).
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

/// Which geoms are on which bodies, in any order: ODE puts a geom that moves in front.
std::uint64_t geoms(dSpaceID space) {
  std::uint64_t sum = 0;
  if (space == nullptr) return sum;
  for (int i = 0; i < dSpaceGetNumGeoms(space); ++i) {
    const dGeomID geom = dSpaceGetGeom(space, i);
    if (dGeomIsSpace(geom) != 0) {
      sum += geoms(reinterpret_cast<dSpaceID>(geom));
    } else {
      sum += mixed(bits(geom) + mixed(bits(dGeomGetBody(geom))));
    }
  }
  return sum;
}

/// Calls `see` with numbers that say what bodies and joints are, until it returns false. What may have been destroyed
/// is not asked: a body that was found through a joint comes after the one whose list of joints would show it.
template <class See>
bool look_at_bodies(const Mechanism& mechanism, See&& see) {
  for (const Body& body : mechanism.bodies) {
    const int joints = dBodyGetNumJoints(body.id);
    for (int j = 0; j < joints; ++j) {
      if (!see(bits(dBodyGetJoint(body.id, j)))) return false;
    }
    dMass mass;
    dBodyGetMass(body.id, &mass);
    const int flags = (dBodyIsKinematic(body.id) != 0 ? 1 : 0) + (dBodyGetGyroscopicMode(body.id) != 0 ? 2 : 0);
    bool same = see(bits(joints)) && see(bits(flags)) && see(bits(mass.mass)) &&
                see(bits(dBodyGetLinearDamping(body.id))) && see(bits(dBodyGetAngularDamping(body.id))) &&
                see(bits(dBodyGetLinearDampingThreshold(body.id))) &&
                see(bits(dBodyGetAngularDampingThreshold(body.id))) && see(bits(dBodyGetMaxAngularSpeed(body.id)));
    for (const int element : {0, 1, 2, 5, 6, 10}) same = same && see(bits(mass.I[element]));
    if (!same) return false;
  }
  return true;
}

template <class See>
bool look_at_joints(const Mechanism& mechanism, See&& see) {
  for (const Joint& joint : mechanism.joints) {
    const dJointID id = joint.id;
    const dJointType type = dJointGetType(id);
    const Parameters parameters = parameters_of(id);
    bool same = see(bits(static_cast<int>(type))) && see(bits(dJointIsEnabled(id))) &&
                see(bits(dJointGetBody(id, 0))) && see(bits(dJointGetBody(id, 1))) && see(bits(parameters.groups));
    for (int k = 0; k < parameters.groups; ++k) {
      // A motor's velocity and limit are read at every step, and so are none of what it has not.
      const auto get = [&](int parameter) { return parameters.get(id, parameter + 0x100 * k); };
      same = same && see(bits(get(dParamFMax) != 0 ? 1 : 0)) && see(bits(get(dParamLoStop))) &&
             see(bits(get(dParamHiStop))) && see(bits(get(dParamBounce)));
    }
    if (type == dJointTypeAMotor) {
      same = same && see(bits(dJointGetAMotorMode(id)));
      for (int k = 0; k < parameters.groups; ++k) same = same && see(bits(dJointGetAMotorAxisRel(id, k)));
    }
    if (type == dJointTypeHinge2) {
      for (const int of : {dParamSuspensionERP, dParamSuspensionCFM}) same = same && see(bits(parameters.get(id, of)));
    }
    if (type == dJointTypeDBall || type == dJointTypeDHinge) same = same && see(bits(dJointGetDBallDistance(id)));
    if (!same) return false;
  }
  return true;
}

/// An anchor and an axis, each in the frame of a body that it is fixed to; zeros for what a joint has not. Where ODE
/// calls the world the first body, the second one's.
std::array<double, 6> place(dJointID joint) {
  using Get = void (*)(dJointID, dReal*);
  const bool reversed = dJointGetBody(joint, 0) == nullptr;
  const dBodyID body = dJointGetBody(joint, reversed ? 1 : 0);
  std::array<double, 6> found{};
  const auto anchor = [&](Get get, dBodyID of) {
    dVector3 now, on_body{};
    get(joint, now);
    if (of != nullptr) {
      dBodyGetPosRelPoint(of, now[0], now[1], now[2], on_body);
    } else {
      std::copy_n(now, 3, on_body);
    }
    std::copy_n(on_body, 3, found.begin());
  };
  const auto axis = [&](Get get) {
    dVector3 now, in_body;
    get(joint, now);
    dBodyVectorFromWorld(body, now[0], now[1], now[2], in_body);
    std::copy_n(in_body, 3, found.begin() + 3);
  };
  const dBodyID other = dJointGetBody(joint, 1);
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      anchor(reversed ? dJointGetBallAnchor2 : dJointGetBallAnchor, body);
      break;
    case dJointTypeHinge:
      anchor(reversed ? dJointGetHingeAnchor2 : dJointGetHingeAnchor, body);
      axis(dJointGetHingeAxis);
      break;
    case dJointTypeUniversal:
      anchor(reversed ? dJointGetUniversalAnchor2 : dJointGetUniversalAnchor, body);
      axis(reversed ? dJointGetUniversalAxis2 : dJointGetUniversalAxis1);
      break;
    case dJointTypeSlider:
      axis(dJointGetSliderAxis);
      break;
    case dJointTypeHinge2:
      anchor(dJointGetHinge2Anchor, body);
      axis(dJointGetHinge2Axis1);
      break;
    case dJointTypePiston:
      anchor(dJointGetPistonAnchor, body);
      axis(dJointGetPistonAxis);
      break;
    case dJointTypePR:
      anchor(dJointGetPRAnchor, other);
      axis(dJointGetPRAxis1);
      break;
    case dJointTypePU:
      anchor(dJointGetPUAnchor, other);
      axis(dJointGetPUAxis1);
      break;
    case dJointTypeDBall:
      anchor(reversed ? dJointGetDBallAnchor2 : dJointGetDBallAnchor1, body);
      break;
    case dJointTypeDHinge:
      anchor(reversed ? dJointGetDHingeAnchor2 : dJointGetDHingeAnchor1, body);
      axis(dJointGetDHingeAxis);
      break;
    default:
      break;
  }
  return found;
}

}  // namespace

Watch::Watch(dSpaceID space, const Mechanism& mechanism) : geoms_(geoms(space)) {
  const auto note = [this](std::uint64_t number) {
    seen_.push_back(number);
    return true;
  };
  look_at_bodies(mechanism, note);
  look_at_joints(mechanism, note);
  for (const Joint& joint : mechanism.joints) places_.push_back(place(joint.id));
}

bool Watch::changed(dSpaceID space, const Mechanism& mechanism) const {
  if (geoms(space) != geoms_) return true;  // before any body: one that was destroyed has left its geoms
  std::size_t k = 0;
  const auto compare = [&](std::uint64_t number) { return k < seen_.size() && seen_[k++] == number; };
  if (!look_at_bodies(mechanism, compare) || !look_at_joints(mechanism, compare) || k != seen_.size()) return true;
  for (std::size_t j = 0; j < places_.size(); ++j) {
    const auto now = place(mechanism.joints[j].id);
    for (std::size_t i = 0; i < now.size(); ++i) {
      constexpr double rounding =
          1e-9;  // of turning to and fro, with a wide margin: far less than one would move an anchor
      if (std::fabs(now[i] - places_[j][i]) > rounding * (1 + std::fabs(now[i]))) return true;
    }
  }
  return false;
}

}  // namespace odeval::engine_rk4
