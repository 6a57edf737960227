#pragma once
// The motions of joints that leave several, as ODE has them.
#include <ode/ode.h>

#include <cstddef>

#include "odeval/mechanism.hpp"

namespace odeval::engine_ode {

inline Vec3 vector(const dReal* v) { return {v[0], v[1], v[2]}; }

/// What ODE calls a joint's anchor or axis.
inline Vec3 told_by(dJointID joint, void (*get)(dJointID, dVector3)) {
  dVector3 told;
  get(joint, told);
  return vector(told);
}

/// A motion of a joint: its axis now, and a point of it that both bodies share.
struct JointAxis {
  Vec3 axis;  // unit
  Vec3 at;
};

/// Of a motion by its number in driveable_of. Throws Fault for a kind that has none.
JointAxis axis_of(dJointID joint, const JointKind& kind, std::size_t motion);

/// Where it stands, as the joint counts (mechanism.hpp): rad, within half a turn, or m. Of a plane2d, for which ODE has
/// no word, the body's centre and turn in the world.
double way_of(dJointID joint, const JointKind& kind, std::size_t motion);

/// How fast it goes, rad/s or m/s. ODE's own words for the rates of ways have the bodies' turning in them.
double rate_of(dJointID joint, const JointKind& kind, std::size_t motion);

}  // namespace odeval::engine_ode
