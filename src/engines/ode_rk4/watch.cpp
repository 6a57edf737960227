#include "engines/ode_rk4/watch.hpp"

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
    const int flags = (dBodyIsKinematic(body.id) != 0 ? 1 : 0) + (dBodyIsEnabled(body.id) != 0 ? 2 : 0) +
                      (dBodyGetGyroscopicMode(body.id) != 0 ? 4 : 0);
    bool same = see(bits(joints)) && see(bits(flags)) && see(bits(mass.mass)) &&
                see(bits(dBodyGetLinearDamping(body.id))) && see(bits(dBodyGetAngularDamping(body.id))) &&
                see(bits(dBodyGetMaxAngularSpeed(body.id)));
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
    const auto limits = [&](dReal (*get)(dJointID, int), int group) {
      // A motor's velocity and limit are read at every step, and so are none of what it has not.
      return see(bits(get(id, dParamFMax + group) != 0 ? 1 : 0)) && see(bits(get(id, dParamLoStop + group))) &&
             see(bits(get(id, dParamHiStop + group))) && see(bits(get(id, dParamBounce + group)));
    };
    bool same = see(bits(static_cast<int>(type))) && see(bits(dJointIsEnabled(id))) &&
                see(bits(dJointGetBody(id, 0))) && see(bits(dJointGetBody(id, 1)));
    if (type == dJointTypeHinge) same = same && limits(dJointGetHingeParam, 0);
    if (type == dJointTypeAMotor) {
      same = same && see(bits(dJointGetAMotorNumAxes(id))) && see(bits(dJointGetAMotorMode(id)));
      for (int k = 0; k < dJointGetAMotorNumAxes(id); ++k) {
        same = same && see(bits(dJointGetAMotorAxisRel(id, k))) && limits(dJointGetAMotorParam, 0x100 * k);
      }
    }
    if (type == dJointTypeSlider) same = same && limits(dJointGetSliderParam, 0);
    if (type == dJointTypeUniversal) {
      same = same && limits(dJointGetUniversalParam, 0) && limits(dJointGetUniversalParam, 0x100);
    }
    if (!same) return false;
  }
  return true;
}

/// Anchor and axis in the frame of the joint's first body (the second, where ODE calls the world the first); zeros for
/// what a joint has not.
std::array<double, 6> place(dJointID joint) {
  const dBodyID first = dJointGetBody(joint, 0);
  const bool reversed = first == nullptr;
  const dBodyID body = reversed ? dJointGetBody(joint, 1) : first;
  dVector3 anchor{}, axis{}, on_body{}, in_body{};
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      (reversed ? dJointGetBallAnchor2 : dJointGetBallAnchor)(joint, anchor);
      break;
    case dJointTypeHinge:
      (reversed ? dJointGetHingeAnchor2 : dJointGetHingeAnchor)(joint, anchor);
      dJointGetHingeAxis(joint, axis);
      break;
    case dJointTypeUniversal:
      (reversed ? dJointGetUniversalAnchor2 : dJointGetUniversalAnchor)(joint, anchor);
      (reversed ? dJointGetUniversalAxis2 : dJointGetUniversalAxis1)(joint, axis);
      break;
    case dJointTypeSlider:
      dJointGetSliderAxis(joint, axis);
      break;
    default:
      return {};
  }
  if (dJointGetType(joint) != dJointTypeSlider) dBodyGetPosRelPoint(body, anchor[0], anchor[1], anchor[2], on_body);
  dBodyVectorFromWorld(body, axis[0], axis[1], axis[2], in_body);
  return {on_body[0], on_body[1], on_body[2], in_body[0], in_body[1], in_body[2]};
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
