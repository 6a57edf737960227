#include "engines/ode/build_mechanism.hpp"

#include <cmath>
#include <numbers>

#include "engines/ode/library.hpp"

namespace odeval::engine_ode {
namespace {

void put(dBodyID body, const Vec3& position) {
  dBodySetPosition(body, real(position[0]), real(position[1]), real(position[2]));
}

struct SetAttitude {
  dBodyID body;

  void operator()(const Vec3& vector) const {
    const double angle = length(vector);
    if (angle == 0) return;
    dQuaternion quaternion;
    const double part = std::sin(angle / 2) / angle;
    quaternion[0] = real(std::cos(angle / 2));
    for (std::size_t k = 0; k < 3; ++k) quaternion[k + 1] = real(part * vector[k]);
    dBodySetQuaternion(body, quaternion);
  }

  void operator()(const AxisAngle& turn) const {
    dMatrix3 rotation;
    dRFromAxisAndAngle(rotation, real(turn.axis[0]), real(turn.axis[1]), real(turn.axis[2]), real(turn.angle_rad));
    dBodySetRotation(body, rotation);
  }
};

struct MakeGeom {
  dSpaceID space;

  dGeomID operator()(const Box& box) const {
    const auto& [x, y, z] = box.sides_m;
    return dCreateBox(space, real(x), real(y), real(z));
  }
  dGeomID operator()(const Sphere& ball) const { return dCreateSphere(space, real(ball.diameter_m / 2)); }
  dGeomID operator()(const Cylinder& bar) const {
    return dCreateCylinder(space, real(bar.diameter_m / 2), real(bar.length_m));
  }
  dGeomID operator()(const Capsule& bar) const {
    return dCreateCapsule(space, real(bar.diameter_m / 2), real(bar.length_m - bar.diameter_m));
  }
};

constexpr int along_z = 3;  // ODE's number of a bar's direction

struct SetUniform {
  dMass& mass;
  dReal total;

  void operator()(const Box& box) const {
    const auto& [x, y, z] = box.sides_m;
    dMassSetBoxTotal(&mass, total, real(x), real(y), real(z));
  }
  void operator()(const Sphere& ball) const { dMassSetSphereTotal(&mass, total, real(ball.diameter_m / 2)); }
  void operator()(const Cylinder& bar) const {
    dMassSetCylinderTotal(&mass, total, along_z, real(bar.diameter_m / 2), real(bar.length_m));
  }
  void operator()(const Capsule& bar) const {
    dMassSetCapsuleTotal(&mass, total, along_z, real(bar.diameter_m / 2), real(bar.length_m - bar.diameter_m));
  }
};

dMass mass_of(const Body& body) {
  dMass mass;
  if (body.inertia_kgm2) {
    const std::array<double, 9>& i = *body.inertia_kgm2;
    dMassSetParameters(&mass, real(body.mass_kg), 0, 0, 0, real(i[0]), real(i[4]), real(i[8]), real(i[1]), real(i[2]),
                       real(i[5]));
  } else {
    std::visit(SetUniform{mass, real(body.mass_kg)}, body.shape);
  }
  return mass;
}

void add_geom(dSpaceID space, dBodyID body, const Part& part, bool central) {
  const dGeomID geom = std::visit(MakeGeom{space}, part.shape);
  dGeomSetBody(geom, body);
  if (central) return;  // an offset of nothing costs time, and bits
  const Vec3& at = part.place.position_m;
  dMatrix3 rotation{};
  for (std::size_t k = 0; k < 9; ++k) rotation[4 * (k / 3) + k % 3] = real(part.place.rotation[k]);
  dGeomSetOffsetPosition(geom, real(at[0]), real(at[1]), real(at[2]));
  dGeomSetOffsetRotation(geom, rotation);
}

/// One maker a kind of joint: attached already, between bodies in the place that they have in the closed joint.
struct MakeJoint {
  dWorldID world;
  dBodyID first;
  dBodyID second;  // null: the world
  double step_s;

  dJointID operator()(const BallJoint& ball) const {
    const auto& [x, y, z] = ball.anchor_m;
    const dJointID joint = dJointCreateBall(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetBallAnchor(joint, real(x), real(y), real(z));
    return joint;
  }

  dJointID operator()(const HingeJoint& hinge) const {
    const auto& [x, y, z] = hinge.anchor_m;
    const dJointID joint = dJointCreateHinge(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetHingeAnchor(joint, real(x), real(y), real(z));
    dJointSetHingeAxis(joint, real(hinge.axis[0]), real(hinge.axis[1]), real(hinge.axis[2]));
    return joint;
  }

  dJointID operator()(const SliderJoint& slider) const {
    const auto& [x, y, z] = slider.axis;
    const dJointID joint = dJointCreateSlider(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetSliderAxis(joint, real(x), real(y), real(z));
    return joint;
  }

  dJointID operator()(const UniversalJoint& cross) const {
    const auto& [x, y, z] = cross.anchor_m;
    const auto& [x1, y1, z1] = cross.axis1;
    const auto& [x2, y2, z2] = cross.axis2;
    const dJointID joint = dJointCreateUniversal(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetUniversalAnchor(joint, real(x), real(y), real(z));
    dJointSetUniversalAxis1(joint, real(x1), real(y1), real(z1));
    dJointSetUniversalAxis2(joint, real(x2), real(y2), real(z2));
    return joint;
  }

  dJointID operator()(const FixedJoint&) const {
    const dJointID joint = dJointCreateFixed(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetFixed(joint);
    return joint;
  }

  dJointID operator()(const PistonJoint& piston) const {
    const auto& [x, y, z] = piston.anchor_m;
    const auto& [ax, ay, az] = piston.axis;
    const dJointID joint = dJointCreatePiston(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetPistonAnchor(joint, real(x), real(y), real(z));
    dJointSetPistonAxis(joint, real(ax), real(ay), real(az));
    return joint;
  }

  dJointID operator()(const SlidingHingeJoint& pr) const {
    const auto& [x, y, z] = pr.anchor_m;
    const auto& [x1, y1, z1] = pr.axis1;
    const auto& [x2, y2, z2] = pr.axis2;
    const dJointID joint = dJointCreatePR(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetPRAnchor(joint, real(x), real(y), real(z));
    dJointSetPRAxis1(joint, real(x1), real(y1), real(z1));
    dJointSetPRAxis2(joint, real(x2), real(y2), real(z2));
    return joint;
  }

  dJointID operator()(const SlidingUniversalJoint& pu) const {
    const auto& [x, y, z] = pu.anchor_m;
    const auto& [xp, yp, zp] = pu.way;
    const auto& [x1, y1, z1] = pu.axis1;
    const auto& [x2, y2, z2] = pu.axis2;
    const dJointID joint = dJointCreatePU(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetPUAnchor(joint, real(x), real(y), real(z));
    dJointSetPUAxis1(joint, real(x1), real(y1), real(z1));
    dJointSetPUAxis2(joint, real(x2), real(y2), real(z2));
    dJointSetPUAxisP(joint, real(xp), real(yp), real(zp));
    return joint;
  }

  dJointID operator()(const Hinge2Joint& wheel) const {
    if (second == nullptr) throw Fault("a hinge2 joint must have two bodies");
    const auto& [x, y, z] = wheel.anchor_m;
    dVector3 axis1{};
    dVector3 axis2{};
    for (std::size_t k = 0; k < 3; ++k) {
      axis1[k] = real(wheel.axis1[k]);
      axis2[k] = real(wheel.axis2[k]);
    }
    const dJointID joint = dJointCreateHinge2(world, nullptr);
    dJointAttach(joint, first, second);
    dJointSetHinge2Anchor(joint, real(x), real(y), real(z));
    dJointSetHinge2Axes(joint, axis1, axis2);
    // Equations (3.6) and (3.7) of ODE's manual.
    const double stiff = step_s * wheel.stiffness;
    dJointSetHinge2Param(joint, dParamSuspensionERP, real(stiff / (stiff + wheel.damping)));
    dJointSetHinge2Param(joint, dParamSuspensionCFM, real(1 / (stiff + wheel.damping)));
    return joint;
  }

  dJointID operator()(const PlaneJoint&) const {
    if (second != nullptr) throw Fault("a plane2d joint must hold its body to the world");
    const dJointID joint = dJointCreatePlane2D(world, nullptr);
    dJointAttach(joint, first, second);
    return joint;
  }
};

using SetParameter = void (*)(dJointID, int, dReal);

/// ODE's words for one motion of a joint.
struct Limot {
  SetParameter set_parameter;
  int group;  // ODE's number of the motion
};

void set_drive(dJointID joint, const Limot& limot, const Joint& what) {
  const auto set = [&](int parameter, double value) {
    limot.set_parameter(joint, dParamGroup * limot.group + parameter, real(value));
  };
  if (what.motor) {
    set(dParamVel, what.motor->speed);
    set(dParamFMax, what.motor->most);
  }
  if (what.stop) {
    if (!(what.stop->low <= 0 && what.stop->high >= 0)) throw Fault("a stop must have its ends on either side of 0");
    set(dParamLoStop, what.stop->low);
    set(dParamHiStop, what.stop->high);
    set(dParamBounce, what.stop->restitution);
  }
}

/// ODE counts an angle within half a turn, and ignores ends that are not.
void check_turn(const std::optional<Stop>& stop) {
  const double half_turn = std::numbers::pi;
  if (stop && !(stop->low > -half_turn && stop->high < half_turn)) {
    throw Fault("a stop of a turn must have its ends within half a turn");
  }
}

/// Motors and stops, where the kind has axes for them.
struct Drive {
  dJointID joint;
  const Joint& what;

  void operator()(const BallJoint&) const { refuse("a ball joint", true); }
  void operator()(const FixedJoint&) const { refuse("a fixed joint", true); }
  void operator()(const UniversalJoint&) const {
    refuse("a universal joint", false);
    set_several({{dJointSetUniversalParam, 0}, {dJointSetUniversalParam, 1}}, 2);
  }
  void operator()(const PistonJoint&) const {
    refuse("a piston joint", false);
    set_several({{dJointSetPistonParam, 0}, {dJointSetPistonParam, 1}}, 2);
  }
  void operator()(const SlidingHingeJoint&) const {
    refuse("a PR joint", false);
    set_several({{dJointSetPRParam, 0}, {dJointSetPRParam, 1}}, 2);
  }
  void operator()(const SlidingUniversalJoint&) const {
    refuse("a PU joint", false);
    set_several({{dJointSetPUParam, 2}, {dJointSetPUParam, 0}, {dJointSetPUParam, 1}}, 3);  // ODE's third is the way
  }
  void operator()(const Hinge2Joint&) const {
    refuse("a hinge2 joint", false);
    set_several({{dJointSetHinge2Param, 0}, {dJointSetHinge2Param, 1}}, 1);
  }
  void operator()(const PlaneJoint&) const {
    refuse("a plane2d joint", false);
    set_several({{dJointSetPlane2DXParam, 0}, {dJointSetPlane2DYParam, 0}, {dJointSetPlane2DAngleParam, 0}}, 0);
  }
  void operator()(const SliderJoint&) const { set_drive(joint, {dJointSetSliderParam, 0}, what); }
  void operator()(const HingeJoint&) const {
    check_turn(what.stop);
    set_drive(joint, {dJointSetHingeParam, 0}, what);
  }

 private:
  /// ODE has stops of the first so many of them.
  void set_several(std::initializer_list<Limot> motions, std::size_t stopped) const {
    for (const AxisDrive& each : what.drives) {
      if (each.stop && each.motion >= stopped) throw Fault("ODE has no stops of this motion of the joint");
      if (!driveable_of(what.kind)[each.motion].slides) check_turn(each.stop);
      set_drive(joint, motions.begin()[each.motion], alone(what, each));
    }
  }
  void refuse(const char* kind, bool several) const {
    if (what.motor || what.stop || what.loaded() || (several && !what.drives.empty())) {
      throw Fault(kind + std::string(" has no one axis for motors, stops and loads"));
    }
  }
};

struct MakeObstacle {
  dSpaceID space;

  dGeomID operator()(const HalfSpace& plane) const {
    const auto& [x, y, z] = plane.normal;
    return dCreatePlane(space, real(x), real(y), real(z), real(plane.offset_m));
  }
  dGeomID operator()(const FixedBox& box) const {
    const dGeomID geom = dCreateBox(space, real(box.sides_m[0]), real(box.sides_m[1]), real(box.sides_m[2]));
    dGeomSetPosition(geom, real(box.centre_m[0]), real(box.centre_m[1]), real(box.centre_m[2]));
    return geom;
  }
};

}  // namespace

dBodyID make_body(dWorldID world, dSpaceID space, const Body& what, const OdeSettings& ode) {
  const dMass mass = mass_of(what);
  const dBodyID body = dBodyCreate(world);
  dBodySetGyroscopicMode(body, ode.gyroscopic ? 1 : 0);
  dBodySetFiniteRotationMode(body, ode.rotation == Turning::finite ? 1 : 0);
  dBodySetMass(body, &mass);
  for (const Part& part : what.parts()) add_geom(space, body, part, what.several.empty());
  std::visit(SetAttitude{body}, what.attitude);
  put(body, what.position_m);
  dBodySetLinearVel(body, real(what.velocity_m_s[0]), real(what.velocity_m_s[1]), real(what.velocity_m_s[2]));
  dBodySetAngularVel(body, real(what.spin_rad_s[0]), real(what.spin_rad_s[1]), real(what.spin_rad_s[2]));
  return body;
}

// A joint remembers where the bodies were when it was given its anchor: the first body stands in its place for that.
dJointID make_joint(dWorldID world, const Joint& what, const std::vector<dBodyID>& bodies,
                    const std::vector<Body>& starts, double step_s) {
  const dBodyID first = bodies[what.first];
  const Vec3& start = starts[what.first].position_m;
  put(first, start - what.opening_m);
  const dBodyID second = what.second ? bodies[*what.second] : nullptr;
  const dJointID joint = std::visit(MakeJoint{world, first, second, step_s}, what.kind);
  std::visit(Drive{joint, what}, what.kind);
  put(first, start);
  return joint;
}

dGeomID make_obstacle(dSpaceID space, const Obstacle& obstacle) {
  return std::visit(MakeObstacle{space}, obstacle.shape);
}

}  // namespace odeval::engine_ode
