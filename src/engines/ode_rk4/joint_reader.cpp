#include "engines/ode_rk4/joint_reader.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

// Of a suspension's CFM times the lighter mass, s^2 times what ODE's CFM is in: softer than the world's default by far.
constexpr double rigid = 1e-6;
// Of a transmission's wheels, rad: joints keep their axes better by far.
constexpr double askew = 1e-6;

struct Frame {
  Vector3d position = Vector3d::Zero();
  Matrix3d turn = Matrix3d::Identity();

  Vector3d point(const Vector3d& in_world) const { return turn.transpose() * (in_world - position); }
  Vector3d direction(const Vector3d& in_world) const { return turn.transpose() * in_world; }
};

Frame frame_of(dBodyID body) {
  if (body == nullptr) return {};
  Frame frame;
  frame.position = vector(dBodyGetPosition(body));
  const dReal* q = dBodyGetQuaternion(body);
  frame.turn = rotation({q[0], q[1], q[2], q[3]});
  return frame;
}

/// Builds a joint's constraints from anchors and axes in the world at its present pose.
class JointReader {
 public:
  JointReader(dJointID id, const std::map<dBodyID, std::size_t>& numbers, const LMotorRel& lmotor_rel)
      : id_(id), lmotor_rel_(lmotor_rel) {
    // Without a second body ODE may hold the only one as the first or, reversed, as the second.
    dBodyID a = dJointGetBody(id, 0);
    dBodyID b = dJointGetBody(id, 1);
    reversed_ = a == nullptr;
    if (reversed_) std::swap(a, b);
    joint_ = {id, numbers.at(a), b == nullptr ? world_body : numbers.at(b), {}, {}, {}, {}, {}, {}, {}, {}};
    a_ = frame_of(a);
    b_ = frame_of(b);
  }

  Joint read() {
    switch (dJointGetType(id_)) {
      case dJointTypeBall:
        anchors(dJointGetBallAnchor, dJointGetBallAnchor2);
        break;
      case dJointTypeHinge:
        hinge();
        break;
      case dJointTypeUniversal:
        universal();
        break;
      case dJointTypeSlider:
        slider();
        break;
      case dJointTypeFixed:
        point(b_.position, b_.position);
        same_turn();
        break;
      case dJointTypeAMotor:
        if (dJointGetAMotorMode(id_) != dAMotorUser) refuse_this(" has mode dAMotorEuler; dAMotorUser is supported");
        angular_motors();
        break;
      case dJointTypeLMotor:
        linear_motors();
        break;
      case dJointTypeTransmission:
        transmission();
        break;
      case dJointTypeHinge2:
        hinge2();
        break;
      case dJointTypePiston:
        piston();
        break;
      case dJointTypePR:
        prismatic_rotoide();
        break;
      case dJointTypePU:
        prismatic_universal();
        break;
      case dJointTypePlane2D:
        plane();
        break;
      case dJointTypeDBall:
        distance();
        break;
      case dJointTypeDHinge:
        distance();
        along(axis(dJointGetDHingeAxis));
        joint_.slides.push_back(
            {a_.direction(axis(dJointGetDHingeAxis)), joint_.distances.front().on_a, joint_.distances.front().on_b});
        break;
      default:
        refuse_this(" is of a kind that is not supported; contacts are made by the step itself");
    }
    return joint_;
  }

 private:
  [[noreturn]] void refuse_this(const std::string& why) const {
    refuse(name(joint_) + why, dJointGetBody(id_, 0), id_);
  }

  using GetVector = void (*)(dJointID, dReal*);

  void hinge() {
    motor(dJointGetHingeParam, 0, false, axis(dJointGetHingeAxis), Motor::Carrier::a);
    hinge_stop();
    anchors(dJointGetHingeAnchor, dJointGetHingeAnchor2);
    along(axis(dJointGetHingeAxis));
  }
  void universal() {
    for (const int group : {0, 0x100}) no_stops(dJointGetUniversalParam, group);
    const Vector3d of_a = axis(reversed_ ? dJointGetUniversalAxis2 : dJointGetUniversalAxis1);
    const Vector3d of_b = axis(reversed_ ? dJointGetUniversalAxis1 : dJointGetUniversalAxis2);
    motor(dJointGetUniversalParam, 0, false, of_a, Motor::Carrier::a);
    motor(dJointGetUniversalParam, 0x100, false, of_b, Motor::Carrier::b);
    anchors(dJointGetUniversalAnchor, dJointGetUniversalAnchor2);
    square(of_a, of_b);
  }
  void slider() {
    motor(dJointGetSliderParam, 0, true, slider_axis(), Motor::Carrier::a,
          joint_.b == world_body ? a_.position : b_.position);
    slider_stop();
    slide(axis(dJointGetSliderAxis), b_.position, b_.position);
    same_turn();
  }
  using GetParameter = dReal (*)(dJointID, int);

  void no_stops(GetParameter get, int group) const {
    if (get(id_, dParamLoStop + group) == -dInfinity && get(id_, dParamHiStop + group) == dInfinity) return;
    refuse_this(
        " has stops; only hinges and sliders may: set dParamLoStop to -dInfinity and dParamHiStop to dInfinity");
  }

  void motor(GetParameter get, int group, bool slides, const Vector3d& in_world, Motor::Carrier carrier,
             const Vector3d& on_line = Vector3d::Zero()) {
    if (get(id_, dParamFMax + group) == 0) return;
    const Vector3d in_frame = carrier == Motor::Carrier::a   ? a_.direction(in_world)
                              : carrier == Motor::Carrier::b ? b_.direction(in_world)
                                                             : in_world;
    joint_.motors.push_back({slides, in_frame, carrier, b_.point(on_line), group, 0, 0});
  }

  void angular_motors() {
    for (int k = 0; k < dJointGetAMotorNumAxes(id_); ++k) {
      no_stops(dJointGetAMotorParam, 0x100 * k);
      dVector3 v;
      dJointGetAMotorAxis(id_, k, v);
      const int rel = dJointGetAMotorAxisRel(id_, k);
      motor(dJointGetAMotorParam, 0x100 * k, false, vector(v).normalized(),
            rel == 0                  ? Motor::Carrier::world
            : (rel == 1) != reversed_ ? Motor::Carrier::a
                                      : Motor::Carrier::b);
    }
  }
  void linear_motors() {
    for (int k = 0; k < dJointGetLMotorNumAxes(id_); ++k) {
      no_stops(dJointGetLMotorParam, 0x100 * k);
      if (dJointGetLMotorParam(id_, dParamFMax + 0x100 * k) == 0) continue;
      if (!lmotor_rel_) {
        refuse_this(
            " pushes along axes that ODE does not tell of what they are fixed to: say so in "
            "AccurateStepOptions::lmotor_axis_rel");
      }
      const int rel = lmotor_rel_(id_, k);
      if (rel < 0 || rel > 2) refuse_this(" has an axis whose AccurateStepOptions::lmotor_axis_rel is not 0, 1 or 2");
      dVector3 v;
      dJointGetLMotorAxis(id_, k, v);  // as it is stored, in the frame of what it is fixed to
      const auto carrier = rel == 0                             ? Motor::Carrier::world
                           : rel == 1 || joint_.b == world_body ? Motor::Carrier::a
                                                                : Motor::Carrier::b;
      joint_.motors.push_back({true, vector(v).normalized(), carrier, Vector3d::Zero(), 0x100 * k, 0, 0});
      joint_.motors.back().midway = true;
    }
  }
  void stop(GetParameter get, int group, bool slides, const Vector3d& axis, const Vector3d& of_a, const Vector3d& of_b,
            double at_start) {
    const double low = get(id_, dParamLoStop + group), high = get(id_, dParamHiStop + group);
    const double bounce = get(id_, dParamBounce + group);
    if (low == -dInfinity && high == dInfinity) return;
    if (!(low <= high)) {
      refuse_this(" has stops the wrong way round: dParamLoStop " + shown(low) + ", dParamHiStop " + shown(high));
    }
    if (!(bounce >= 0 && bounce <= 1)) {
      refuse_this(" has stops with a dParamBounce of " + shown(bounce) + "; it must be 0 to 1");
    }
    joint_.stops.push_back({slides, a_.direction(axis), of_a, of_b, at_start, low, high, bounce});
  }
  /// About an axis of both bodies, that have turned by an angle.
  void turning_stop(GetParameter get, int group, const Vector3d& n, double angle) {
    const Vector3d across = n.unitOrthogonal();
    stop(get, group, false, n, a_.direction(across), b_.direction(Eigen::AngleAxisd(-angle, n) * across), 0);
  }
  void sliding_stop(GetParameter get, int group, const Vector3d& axis, const Vector3d& at, double position) {
    stop(get, group, true, axis, a_.point(at), b_.point(at), position);
  }
  void hinge_stop() {
    turning_stop(dJointGetHingeParam, 0, axis(dJointGetHingeAxis), (reversed_ ? -1 : 1) * dJointGetHingeAngle(id_));
  }
  /// Motors and stops of a slider go by the position that ODE reports; those of a hinge do not.
  Vector3d slider_axis() const { return (reversed_ ? -1 : 1) * axis(dJointGetSliderAxis); }
  void slider_stop() {
    sliding_stop(dJointGetSliderParam, 0, slider_axis(), b_.position, dJointGetSliderPosition(id_));
  }

  /// The steering axis is a's, the wheel's is b's. Without a CFM of its own worth the name the suspension is rigid.
  void hinge2() {
    const Vector3d steering = axis(dJointGetHinge2Axis1), wheel = axis(dJointGetHinge2Axis2);
    const Vector3d at_a = vector_of(dJointGetHinge2Anchor), at_b = vector_of(dJointGetHinge2Anchor2);
    const double cfm = dJointGetHinge2Param(id_, dParamSuspensionCFM);
    if (cfm * softest_mass() > rigid) {
      slide(steering, at_a, at_b);
      joint_.springs.push_back({a_.direction(steering), a_.point(at_a), b_.point(at_b),
                                dJointGetHinge2Param(id_, dParamSuspensionERP), cfm});
    } else {
      point(at_a, at_b);
    }
    square(steering, wheel, steering.dot(wheel));
    const Vector3d across = (wheel - steering.dot(wheel) * steering).normalized();
    const double angle = dJointGetHinge2Angle1(id_);
    const auto at_angle = [&](double of) { return Vector3d(Eigen::AngleAxisd(angle - of, steering) * across); };
    const double low = dJointGetHinge2Param(id_, dParamLoStop);
    if (low == dJointGetHinge2Param(id_, dParamHiStop)) {  // locked, as rear wheels are
      square(steering.cross(at_angle(low)), wheel);
    } else {
      motor(dJointGetHinge2Param, 0, false, steering, Motor::Carrier::a);
      stop(dJointGetHinge2Param, 0, false, steering, a_.direction(at_angle(0)), b_.direction(wheel), 0);
    }
    motor(dJointGetHinge2Param, 0x100, false, wheel, Motor::Carrier::b);
  }
  double softest_mass() const {
    dMass a, b;
    dBodyGetMass(dJointGetBody(id_, 0), &a);
    dBodyGetMass(dJointGetBody(id_, 1), &b);
    return std::min(a.mass, b.mass);
  }

  void body_first() const {
    if (reversed_) refuse_this(" has the world as its first body; attach it as the second");
  }
  void piston() {
    body_first();
    const Vector3d along_it = axis(dJointGetPistonAxis);
    const Vector3d at_a = vector_of(dJointGetPistonAnchor), at_b = vector_of(dJointGetPistonAnchor2);
    slide(along_it, at_a, at_b);
    along(along_it);
    motor(dJointGetPistonParam, 0, true, along_it, Motor::Carrier::a, at_b);
    motor(dJointGetPistonParam, 0x100, false, along_it, Motor::Carrier::a);
    sliding_stop(dJointGetPistonParam, 0, along_it, at_b, dJointGetPistonPosition(id_));
    turning_stop(dJointGetPistonParam, 0x100, along_it, dJointGetPistonAngle(id_));
  }
  void prismatic_rotoide() {
    body_first();
    const Vector3d way = axis(dJointGetPRAxis1), turn = axis(dJointGetPRAxis2), at = vector_of(dJointGetPRAnchor);
    slide(way, at, at);
    along(turn);
    motor(dJointGetPRParam, 0, true, way, Motor::Carrier::a, at);
    motor(dJointGetPRParam, 0x100, false, turn, Motor::Carrier::a);
    sliding_stop(dJointGetPRParam, 0, way, at, dJointGetPRPosition(id_));
    turning_stop(dJointGetPRParam, 0x100, turn, dJointGetPRAngle(id_));
  }
  void prismatic_universal() {
    body_first();
    for (const int group : {0, 0x100}) no_stops(dJointGetPUParam, group);
    const Vector3d one = axis(dJointGetPUAxis1), other = axis(dJointGetPUAxis2), way = axis(dJointGetPUAxisP);
    const Vector3d at = vector_of(dJointGetPUAnchor);
    slide(way, at, at);
    square(one, other);
    motor(dJointGetPUParam, 0, false, one, Motor::Carrier::a);
    motor(dJointGetPUParam, 0x100, false, other, Motor::Carrier::b);
    motor(dJointGetPUParam, 0x200, true, way, Motor::Carrier::a, at);
    sliding_stop(dJointGetPUParam, 0x200, way, at, dJointGetPUPosition(id_));
  }
  /// ODE keeps the centre at z = 0, and tells nothing of the motors.
  void plane() {
    body_first();
    if (joint_.b != world_body)
      refuse_this(" holds its first body only, whatever the second is; attach it to the world");
    const Vector3d up = Vector3d::UnitZ();
    joint_.slides.push_back({a_.direction(up), Vector3d::Zero(), Vector3d::Zero()});
    along(up);
  }
  void distance() {
    const double length = dJointGetDBallDistance(id_);
    if (!(length > 0)) refuse_this(" keeps no distance between its anchors; take a ball joint");
    const Vector3d one = vector_of(dJointGetDBallAnchor1), other = vector_of(dJointGetDBallAnchor2);
    joint_.distances.push_back({a_.point(reversed_ ? other : one), b_.point(reversed_ ? one : other), length});
  }

  /// As dxJointTransmission::getInfo2 has it, before wheels have moved: radii follow from the ratio or the places, but
  /// for those of a chain.
  void transmission() {
    if (dJointGetTransmissionBacklash(id_) > 0) refuse_this(" has backlash; set it to 0");
    const Vector3d at_a = vector_of(dJointGetTransmissionAnchor1), at_b = vector_of(dJointGetTransmissionAnchor2);
    Vector3d n_a = axis(dJointGetTransmissionAxis1);
    const Vector3d n_b = axis(dJointGetTransmissionAxis2), apart = at_a - at_b;
    if (n_a.dot(n_b) < 0) n_a = -n_a;  // as ODE does
    Gear gear{a_.point(at_a), b_.point(at_b), a_.direction(n_a), b_.direction(n_b), false, 0, 0, 0, 0};
    const int mode = dJointGetTransmissionMode(id_);
    if (mode == dTransmissionIntersectingAxes) {
      bevel(at_a, at_b, n_a, n_b, gear);
    } else {
      const double length = apart.norm();
      if (n_a.cross(n_b).norm() > askew || std::fabs(apart.dot(n_a)) > askew * length || length == 0) {
        refuse_this(" has wheels that are not in one plane, at a distance, with parallel axes");
      }
      const double ratio = dJointGetTransmissionRatio(id_);
      const bool chain = mode == dTransmissionChainDrive;
      gear.of_a = -(chain ? dJointGetTransmissionRadius1(id_) : length * ratio / (1 + ratio));
      gear.of_b = chain ? dJointGetTransmissionRadius2(id_) : -length / (1 + ratio);
      // A chain leaves its wheels at an angle to the line through their centres.
      gear.across = chain ? (gear.of_a + gear.of_b) / length : -1;
      gear.along = chain ? -std::sqrt(1 - gear.across * gear.across) : 0;
      if (!(std::fabs(gear.across) <= 1)) refuse_this(" has a wheel that reaches around the other");
    }
    if (!(gear.of_a != 0 && gear.of_b != 0)) refuse_this(" has a wheel of no radius");
    joint_.gears.push_back(gear);
  }
  /// Wheels that touch where their planes meet.
  void bevel(const Vector3d& at_a, const Vector3d& at_b, const Vector3d& n_a, const Vector3d& n_b, Gear& gear) const {
    const double cosine = n_a.dot(n_b), sine = n_a.cross(n_b).norm();
    if (sine < askew) refuse_this(" has axes that are parallel, and a mode for such as intersect");
    const Vector3d l = n_a.cross(n_b) / sine;
    const double a = n_a.dot(at_a), b = n_b.dot(at_b);
    const Vector3d touch = (n_a * (a - b * cosine) + n_b * (b - a * cosine)) / (sine * sine) + l * l.dot(at_a);
    if (std::fabs(l.dot(at_a - at_b)) > askew * (at_a - at_b).norm()) {
      refuse_this(" has axes that do not intersect");
    }
    gear.intersects = true;
    gear.of_a = n_a.dot((touch - at_a).cross(l));
    gear.of_b = -n_b.dot((touch - at_b).cross(l));
  }

  Vector3d vector_of(GetVector get) const {
    dVector3 v;
    get(id_, v);
    return vector(v);
  }
  Vector3d axis(GetVector get) const { return vector_of(get).normalized(); }

  void anchors(GetVector first, GetVector second) {
    point(vector_of(reversed_ ? second : first), vector_of(reversed_ ? first : second));
  }
  void point(const Vector3d& of_a, const Vector3d& of_b) { joint_.points.push_back({a_.point(of_a), b_.point(of_b)}); }
  void square(const Vector3d& of_a, const Vector3d& of_b, double cosine = 0) {
    joint_.squares.push_back({a_.direction(of_a), b_.direction(of_b), cosine});
  }
  /// Both bodies keep this axis.
  void along(const Vector3d& axis) {
    const Vector3d p = axis.unitOrthogonal();
    square(p, axis);
    square(axis.cross(p), axis);
  }
  /// The bodies keep their relative orientation.
  void same_turn() {
    const Matrix3d e = Matrix3d::Identity();
    square(e.col(0), e.col(1));
    square(e.col(1), e.col(2));
    square(e.col(2), e.col(0));
  }
  /// A point of b stays on the line through a point of a.
  void slide(const Vector3d& axis, const Vector3d& of_a, const Vector3d& of_b) {
    const Vector3d p = axis.unitOrthogonal();
    for (const Vector3d& across : {p, Vector3d(axis.cross(p))}) {
      joint_.slides.push_back({a_.direction(across), a_.point(of_a), b_.point(of_b)});
    }
  }

  dJointID id_;
  const LMotorRel& lmotor_rel_;
  bool reversed_;
  Joint joint_;
  Frame a_, b_;
};

}  // namespace

Joint read_joint(dJointID id, const std::map<dBodyID, std::size_t>& numbers, const LMotorRel& lmotor_rel) {
  return JointReader(id, numbers, lmotor_rel).read();
}

}  // namespace odeval::engine_rk4
