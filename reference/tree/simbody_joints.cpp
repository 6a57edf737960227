#include "reference/tree/simbody_joints.hpp"

#include <cmath>
#include <stdexcept>
#include <variant>

#include "reference/tree/simbody_numbers.hpp"

namespace odeval::reference {
namespace {

/// Axes x, y, z by columns, in the world.
SimTK::Rotation of_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  return simbody(Rotation{x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]});
}

/// Two unit directions at right angles to a unit direction and to each other: a, b, then it, right-handed.
std::array<Vec3, 2> across(const Vec3& axis) {
  const Vec3 far = std::fabs(axis[0]) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 a = unit(cross(far, axis));
  return {a, cross(axis, a)};
}

/// A body on its joint, and the joint's frame in the world at t = 0: both bodies' halves of it coincide there. A joint
/// that Simbody does not have is made of two, with a massless body between them.
struct Hanging {
  SimTK::MobilizedBody& parent;
  const SimTK::Transform& parent_place;
  const SimTK::Body::Rigid& body;
  const SimTK::Transform& place;
  bool body_is_first;  // of the joint
  SimTK::GeneralForceSubsystem& loads;

  template <class Mobilizer>
  static SimTK::MobilizedBody hang(SimTK::MobilizedBody& carrier, const SimTK::Transform& carrier_place,
                                   const SimTK::Body& carried, const SimTK::Transform& carried_place,
                                   const SimTK::Rotation& axes, const Vec3& anchor) {
    const SimTK::Transform frame(axes, simbody(anchor));
    return Mobilizer(carrier, ~carrier_place * frame, carried, ~carried_place * frame);
  }
  template <class Mobilizer>
  Chain on(const SimTK::Rotation& axes, const Vec3& anchor) const {
    return {{hang<Mobilizer>(parent, parent_place, body, place, axes, anchor)}, {parent_place.R()}};
  }
  template <class First, class Second>
  Chain on(const SimTK::Rotation& axes, const SimTK::Rotation& next_axes, const Vec3& anchor) const {
    const SimTK::Transform between(simbody(anchor));
    SimTK::MobilizedBody middle = hang<First>(parent, parent_place, SimTK::Body::Massless(), between, axes, anchor);
    const SimTK::MobilizedBody end = hang<Second>(middle, between, body, place, next_axes, anchor);
    return {{middle, end}, {parent_place.R(), SimTK::Rotation()}};
  }

  static SimTK::Rotation about_z(const Vec3& axis) {
    const auto [x, y] = across(axis);
    return of_axes(x, y, axis);
  }
  static SimTK::Rotation along_x(const Vec3& axis) {
    const auto [y, z] = across(axis);
    return of_axes(axis, y, z);
  }
  /// Of a universal joint, which turns about the parent's x and its own y.
  SimTK::Rotation crossed(const Vec3& axis1, const Vec3& axis2) const {
    const Vec3& x = body_is_first ? axis2 : axis1;
    const Vec3& y = body_is_first ? axis1 : axis2;
    return of_axes(x, y, cross(x, y));
  }

  Chain operator()(const BallJoint& ball) const {
    return on<SimTK::MobilizedBody::Ball>(SimTK::Rotation(), ball.anchor_m);
  }
  Chain operator()(const HingeJoint& hinge) const {
    return on<SimTK::MobilizedBody::Pin>(about_z(hinge.axis), hinge.anchor_m);
  }
  Chain operator()(const SliderJoint& slider) const {
    return on<SimTK::MobilizedBody::Slider>(along_x(slider.axis), slider.anchor_m);
  }
  Chain operator()(const UniversalJoint& joint) const {
    return on<SimTK::MobilizedBody::Universal>(crossed(joint.axis1, joint.axis2), joint.anchor_m);
  }
  Chain operator()(const FixedJoint& joint) const {
    return on<SimTK::MobilizedBody::Weld>(SimTK::Rotation(), joint.anchor_m);
  }
  Chain operator()(const PistonJoint& piston) const {
    return on<SimTK::MobilizedBody::Cylinder>(about_z(piston.axis), piston.anchor_m);
  }
  Chain operator()(const SlidingHingeJoint& joint) const {
    using Way = SimTK::MobilizedBody::Slider;
    using Turn = SimTK::MobilizedBody::Pin;
    const SimTK::Rotation way = along_x(joint.axis1);
    const SimTK::Rotation turn = about_z(joint.axis2);
    return body_is_first ? on<Turn, Way>(turn, way, joint.anchor_m) : on<Way, Turn>(way, turn, joint.anchor_m);
  }
  Chain operator()(const SlidingUniversalJoint& joint) const {
    return sliding(joint.way, joint.axis1, joint.axis2, joint.anchor_m);
  }
  Chain operator()(const Hinge2Joint& wheel) const {
    Chain chain = sliding(wheel.axis1, wheel.axis1, wheel.axis2, wheel.anchor_m);
    const SimTK::MobilizedBody& slides = body_is_first ? chain.bodies[1] : chain.bodies[0];
    SimTK::Force::MobilityLinearSpring(loads, slides, SimTK::MobilizerUIndex(0), wheel.stiffness, 0);
    SimTK::Force::MobilityLinearDamper(loads, slides, SimTK::MobilizerUIndex(0), wheel.damping);
    return chain;
  }
  /// Its ways are those of the body's centre.
  Chain operator()(const PlaneJoint&) const {
    return on<SimTK::MobilizedBody::Planar>(SimTK::Rotation(), ours(place.p()));
  }

 private:
  Chain sliding(const Vec3& along, const Vec3& axis1, const Vec3& axis2, const Vec3& anchor) const {
    using Way = SimTK::MobilizedBody::Slider;
    using Turns = SimTK::MobilizedBody::Universal;
    const SimTK::Rotation way = along_x(along);
    const SimTK::Rotation turns = crossed(axis1, axis2);
    return body_is_first ? on<Turns, Way>(turns, way, anchor) : on<Way, Turns>(way, turns, anchor);
  }
};

struct FindMobility {
  std::size_t motion;  // of driveable_of
  bool body_is_first;

  Mobility operator()(const UniversalJoint&) const { return {0, turn(motion)}; }
  Mobility operator()(const PistonJoint&) const { return {0, motion == 0 ? 1 : 0}; }
  Mobility operator()(const SlidingHingeJoint&) const { return {sliding(motion), 0}; }
  Mobility operator()(const SlidingUniversalJoint&) const {
    return {sliding(motion), motion == 0 ? 0 : turn(motion - 1)};
  }
  Mobility operator()(const Hinge2Joint&) const { return {sliding(1), turn(motion)}; }
  Mobility operator()(const PlaneJoint&) const { return {0, motion == 2 ? 0 : static_cast<int>(motion) + 1}; }
  template <class Other>
  Mobility operator()(const Other&) const {
    throw std::logic_error("a joint that has no motion of several to drive");
  }

 private:
  /// The parent's axis is Simbody's first.
  int turn(std::size_t axis) const { return (axis == 0) == body_is_first ? 1 : 0; }
  /// The way comes first, from the parent on, where the parent is the joint's first.
  std::size_t sliding(std::size_t of) const { return (of == 0) == body_is_first ? 1 : 0; }
};

}  // namespace

Chain hang(const HungOn& carrier, const SimTK::Body::Rigid& body, const SimTK::Transform& place, const JointKind& kind,
           SimTK::GeneralForceSubsystem& loads) {
  return std::visit(Hanging{carrier.parent, carrier.parent_place, body, place, carrier.body_is_first, loads}, kind);
}

Mobility mobility_of(const JointKind& kind, std::size_t motion, bool body_is_first) {
  return std::visit(FindMobility{motion, body_is_first}, kind);
}

}  // namespace odeval::reference
