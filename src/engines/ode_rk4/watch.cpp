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
  dMass mass;
  for (const Body& body : mechanism.bodies) {
    const int joints = dBodyGetNumJoints(body.id);
    for (int j = 0; j < joints; ++j) {
      if (!see(bits(dBodyGetJoint(body.id, j)))) return false;
    }
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
    if (type == dJointTypeLMotor) {
      for (int k = 0; k < parameters.groups; ++k) {
        dVector3 axis;  // in the frame of what it is fixed to
        dJointGetLMotorAxis(id, k, axis);
        for (const int i : {0, 1, 2}) same = same && see(bits(axis[i]));
      }
    }
    if (type == dJointTypeTransmission) {
      const bool chain = dJointGetTransmissionMode(id) == dTransmissionChainDrive;  // else radii follow
      same = same && see(bits(dJointGetTransmissionMode(id))) && see(bits(dJointGetTransmissionBacklash(id))) &&
             see(bits(chain ? dJointGetTransmissionRadius1(id) : dJointGetTransmissionRatio(id))) &&
             see(bits(chain ? dJointGetTransmissionRadius2(id) : 0));
    }
    if (type == dJointTypeHinge2) {
      for (const int of : {dParamSuspensionERP, dParamSuspensionCFM}) same = same && see(bits(parameters.get(id, of)));
    }
    if (type == dJointTypeDBall || type == dJointTypeDHinge) same = same && see(bits(dJointGetDBallDistance(id)));
    if (!same) return false;
  }
  return true;
}

using GetVector = void (*)(dJointID, dReal*);

/// Whose frame an anchor or an axis is fixed in.
enum class FixedTo { moved, second };  // the first body, or where ODE calls the world that, the second; the second

/// What tells where a kind of joint is: null for what it has not; a kind may have two. Where ODE calls the world the
/// first body, `reversed` tells the same of the second one.
struct PlaceOfKind {
  dJointType type;
  GetVector anchor, anchor_reversed;
  FixedTo anchor_of;
  GetVector axis, axis_reversed;
  FixedTo axis_of = FixedTo::moved;
};
constexpr std::array places{
    PlaceOfKind{dJointTypeBall, dJointGetBallAnchor, dJointGetBallAnchor2, FixedTo::moved, nullptr, nullptr},
    PlaceOfKind{dJointTypeHinge, dJointGetHingeAnchor, dJointGetHingeAnchor2, FixedTo::moved, dJointGetHingeAxis,
                dJointGetHingeAxis},
    PlaceOfKind{dJointTypeUniversal, dJointGetUniversalAnchor, dJointGetUniversalAnchor2, FixedTo::moved,
                dJointGetUniversalAxis1, dJointGetUniversalAxis2},
    PlaceOfKind{dJointTypeSlider, nullptr, nullptr, FixedTo::moved, dJointGetSliderAxis, dJointGetSliderAxis},
    PlaceOfKind{dJointTypeHinge2, dJointGetHinge2Anchor, dJointGetHinge2Anchor, FixedTo::moved, dJointGetHinge2Axis1,
                dJointGetHinge2Axis1},
    PlaceOfKind{dJointTypePiston, dJointGetPistonAnchor, dJointGetPistonAnchor, FixedTo::moved, dJointGetPistonAxis,
                dJointGetPistonAxis},
    PlaceOfKind{dJointTypePR, dJointGetPRAnchor, dJointGetPRAnchor, FixedTo::second, dJointGetPRAxis1,
                dJointGetPRAxis1},
    PlaceOfKind{dJointTypePU, dJointGetPUAnchor, dJointGetPUAnchor, FixedTo::second, dJointGetPUAxis1,
                dJointGetPUAxis1},
    PlaceOfKind{dJointTypeTransmission, dJointGetTransmissionAnchor1, dJointGetTransmissionAnchor1, FixedTo::moved,
                dJointGetTransmissionAxis1, dJointGetTransmissionAxis1},
    PlaceOfKind{dJointTypeTransmission, dJointGetTransmissionAnchor2, dJointGetTransmissionAnchor2, FixedTo::second,
                dJointGetTransmissionAxis2, dJointGetTransmissionAxis2, FixedTo::second},
    PlaceOfKind{dJointTypeDBall, dJointGetDBallAnchor1, dJointGetDBallAnchor2, FixedTo::moved, nullptr, nullptr},
    PlaceOfKind{dJointTypeDHinge, dJointGetDHingeAnchor1, dJointGetDHingeAnchor2, FixedTo::moved, dJointGetDHingeAxis,
                dJointGetDHingeAxis},
};

/// An anchor and an axis, each in the frame of a body that it is fixed to; zeros for what a joint has not.
std::array<double, 6> place(dJointID joint, const PlaceOfKind& kind) {
  std::array<double, 6> found{};
  const bool reversed = dJointGetBody(joint, 0) == nullptr;
  const dBodyID moved = dJointGetBody(joint, reversed ? 1 : 0);
  dVector3 now, in_body;
  if (const GetVector get = reversed ? kind.anchor_reversed : kind.anchor; get != nullptr) {
    get(joint, now);
    const dBodyID of = kind.anchor_of == FixedTo::moved ? moved : dJointGetBody(joint, 1);
    if (of != nullptr) dBodyGetPosRelPoint(of, now[0], now[1], now[2], in_body);
    std::copy_n(of != nullptr ? in_body : now, 3, found.begin());
  }
  if (const GetVector get = reversed ? kind.axis_reversed : kind.axis; get != nullptr) {
    get(joint, now);
    const dBodyID of = kind.axis_of == FixedTo::moved ? moved : dJointGetBody(joint, 1);
    dBodyVectorFromWorld(of, now[0], now[1], now[2], in_body);
    std::copy_n(in_body, 3, found.begin() + 3);
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
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const dJointID id = mechanism.joints[j].id;
    for (std::size_t kind = 0; kind < places.size(); ++kind) {
      if (places[kind].type == dJointGetType(id)) places_.push_back({j, kind, place(id, places[kind])});
    }
  }
}

bool Watch::changed(dSpaceID space, const Mechanism& mechanism) const {
  if (geoms(space) != geoms_) return true;  // before any body: one that was destroyed has left its geoms
  std::size_t k = 0;
  const auto compare = [&](std::uint64_t number) { return k < seen_.size() && seen_[k++] == number; };
  if (!look_at_bodies(mechanism, compare) || !look_at_joints(mechanism, compare) || k != seen_.size()) return true;
  return !std::ranges::all_of(places_, [&](const Place& before) {  // kinds are as before: joints have been looked at
    // Of turning to and fro, with a wide margin: far less than one would move an anchor.
    constexpr double rounding = 1e-9;
    const std::array<double, 6> now = place(mechanism.joints[before.joint].id, places[before.kind]);
    return std::ranges::equal(now, before.where, [](double one, double other) {
      return std::fabs(one - other) <= rounding * (1 + std::fabs(one));
    });
  });
}

}  // namespace odeval::engine_rk4
