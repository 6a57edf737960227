#include "engines/ode/joint_axis.hpp"

#include <cmath>

#include "engines/ode/build_mechanism.hpp"
#include "engines/ode/library.hpp"

namespace odeval::engine_ode {
namespace {

struct FindAxis {
  dJointID joint;
  std::size_t motion;

  JointAxis operator()(const UniversalJoint&) const {
    return {told_by(joint, motion == 0 ? dJointGetUniversalAxis1 : dJointGetUniversalAxis2),
            told_by(joint, dJointGetUniversalAnchor)};
  }
  JointAxis operator()(const PistonJoint&) const {
    return {told_by(joint, dJointGetPistonAxis), told_by(joint, dJointGetPistonAnchor2)};
  }
  JointAxis operator()(const SlidingHingeJoint&) const {
    return {told_by(joint, motion == 0 ? dJointGetPRAxis1 : dJointGetPRAxis2), told_by(joint, dJointGetPRAnchor)};
  }
  JointAxis operator()(const SlidingUniversalJoint&) const {
    const auto axis = motion == 0 ? dJointGetPUAxisP : motion == 1 ? dJointGetPUAxis1 : dJointGetPUAxis2;
    return {told_by(joint, axis), told_by(joint, dJointGetPUAnchor)};
  }
  JointAxis operator()(const Hinge2Joint&) const {
    return {told_by(joint, motion == 0 ? dJointGetHinge2Axis1 : dJointGetHinge2Axis2),
            told_by(joint, dJointGetHinge2Anchor)};
  }
  JointAxis operator()(const PlaneJoint& plane) const {
    return {driveable_of(plane)[motion].axis, vector(dBodyGetPosition(dJointGetBody(joint, 0)))};
  }
  template <class Other>
  JointAxis operator()(const Other&) const {
    throw Fault("a joint without several motions");
  }
};

struct FindWay {
  dJointID joint;
  std::size_t motion;

  double operator()(const UniversalJoint&) const {
    return motion == 0 ? dJointGetUniversalAngle1(joint) : dJointGetUniversalAngle2(joint);
  }
  double operator()(const PistonJoint&) const {
    return motion == 0 ? dJointGetPistonPosition(joint) : dJointGetPistonAngle(joint);
  }
  double operator()(const SlidingHingeJoint&) const {
    return motion == 0 ? dJointGetPRPosition(joint) : dJointGetPRAngle(joint);
  }
  double operator()(const SlidingUniversalJoint&) const {
    return motion == 0 ? dJointGetPUPosition(joint) : motion == 1 ? dJointGetPUAngle1(joint) : dJointGetPUAngle2(joint);
  }
  /// ODE tells the second angle the other way round: of the second body against the first.
  double operator()(const Hinge2Joint&) const {
    return motion == 0 ? dJointGetHinge2Angle1(joint) : -dJointGetHinge2Angle2(joint);
  }
  double operator()(const PlaneJoint&) const {
    const dBodyID body = dJointGetBody(joint, 0);
    if (motion < 2) return dBodyGetPosition(body)[motion];
    // Rows of four; only about z. Its own x and y turn with it, and so does what half of the second turned back by a
    // right angle adds to the first: nothing alone where one of them stands, or their sum where it lies on its back.
    const dReal* const turned = dBodyGetRotation(body);
    return std::atan2(turned[4] - turned[1] / 2, turned[0] + turned[5] / 2);
  }
  template <class Other>
  double operator()(const Other&) const {
    throw Fault("a joint without several motions");
  }
};

}  // namespace

JointAxis axis_of(dJointID joint, const JointKind& kind, std::size_t motion) {
  return std::visit(FindAxis{joint, motion}, kind);
}

double way_of(dJointID joint, const JointKind& kind, std::size_t motion) {
  return std::visit(FindWay{joint, motion}, kind);
}

double rate_of(dJointID joint, const JointKind& kind, std::size_t motion) {
  const auto [axis, at] = axis_of(joint, kind, motion);
  double rate = 0;
  for (const int k : {0, 1}) {
    const dBodyID body = dJointGetBody(joint, k);
    if (body == nullptr) continue;
    dVector3 velocity;
    dBodyGetPointVel(body, real(at[0]), real(at[1]), real(at[2]), velocity);
    const bool slides = driveable_of(kind)[motion].slides;
    rate += (k == 0 ? 1 : -1) * dot(axis, vector(slides ? velocity : dBodyGetAngularVel(body)));
  }
  return rate;
}

}  // namespace odeval::engine_ode
