#include "engines/ode_rk4/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <new>
#include <set>
#include <string_view>

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
      add(mechanism, JointReader(id, mechanism.numbers, lmotor_rel).read());
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

namespace {

Matrix3d turn_of(std::size_t body, std::span<const Matrix3d> turns) {
  return body == world_body ? Matrix3d(Matrix3d::Identity()) : turns[body];
}
Vector3d position_of(std::size_t body, const State& state) {
  return body == world_body ? Vector3d(Vector3d::Zero()) : state[body].pose.position;
}

}  // namespace

MotorLine line_of(const Joint& joint, const Motor& motor, const State& state, std::span<const Matrix3d> turns) {
  MotorLine line{motor.axis, Vector3d::Zero(), Vector3d::Zero()};
  if (motor.carrier == Motor::Carrier::a) line.axis = turns[joint.a] * motor.axis;
  if (motor.carrier == Motor::Carrier::b) line.axis = turn_of(joint.b, turns) * motor.axis;
  if (motor.midway) {
    if (joint.b == world_body) return line;
    line.on_a = (state[joint.b].pose.position - state[joint.a].pose.position) / 2;
    line.on_b = -line.on_a;
  } else if (motor.slides) {
    line.on_b = turn_of(joint.b, turns) * motor.on_b;
    line.on_a = position_of(joint.b, state) + line.on_b - state[joint.a].pose.position;
  }
  return line;
}

double motor_speed(const Joint& joint, const MotorLine& line, bool slides, const State& state) {
  const auto of = [&](std::size_t body, const Vector3d& arm) {
    if (body == world_body) return 0.0;
    const Twist& twist = state[body].twist;
    return line.axis.dot(slides ? Vector3d(twist.linear + twist.angular.cross(arm)) : twist.angular);
  };
  return of(joint.a, line.on_a) - of(joint.b, line.on_b);
}

MotorLine line_of(const Joint& joint, const Spring& spring, const State& state, std::span<const Matrix3d> turns) {
  const Vector3d on_b = turn_of(joint.b, turns) * spring.on_b;
  return {turns[joint.a] * spring.axis, position_of(joint.b, state) + on_b - state[joint.a].pose.position, on_b};
}

double pull(const Joint& joint, const Spring& spring, const State& state, std::span<const Matrix3d> turns) {
  const MotorLine line = line_of(joint, spring, state, turns);
  const double length = line.axis.dot(line.on_a - turns[joint.a] * spring.on_a);
  return spring.stiffness * length - spring.damping * motor_speed(joint, line, true, state);
}

namespace {

/// Where a joint's two bodies are, and how they move; the world stands still at the origin.
struct Pair {
  Matrix3d turn_a, turn_b;
  Vector3d x_a, x_b, v_a, v_b, w_a, w_b;

  Pair(const Joint& joint, const State& state, std::span<const Matrix3d> turns)
      : turn_a(turns[joint.a]),
        turn_b(Matrix3d::Identity()),
        x_a(state[joint.a].pose.position),
        x_b(Vector3d::Zero()),
        v_a(state[joint.a].twist.linear),
        v_b(Vector3d::Zero()),
        w_a(state[joint.a].twist.angular),
        w_b(Vector3d::Zero()) {
    if (joint.b == world_body) return;
    turn_b = turns[joint.b];
    x_b = state[joint.b].pose.position;
    v_b = state[joint.b].twist.linear;
    w_b = state[joint.b].twist.angular;
  }
};

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

void constrain(const Point& point, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d r_a = now.turn_a * point.on_a;
  const Vector3d r_b = now.turn_b * point.on_b;
  rows.of_a.block<3, 3>(k, 0).setIdentity();
  rows.of_a.block<3, 3>(k, 3) = -cross_matrix(r_a);
  rows.of_b.block<3, 3>(k, 0) = -Matrix3d::Identity();
  rows.of_b.block<3, 3>(k, 3) = cross_matrix(r_b);
  rows.error.segment<3>(k) = now.x_a + r_a - now.x_b - r_b;
  rows.bias.segment<3>(k) = now.w_a.cross(now.w_a.cross(r_a)) - now.w_b.cross(now.w_b.cross(r_b));
}

void constrain(const Square& square, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d p = now.turn_a * square.p;
  const Vector3d n = now.turn_b * square.n;
  const Vector3d row = p.cross(n);
  const Vector3d row_rate = now.w_a.cross(p).cross(n) + p.cross(now.w_b.cross(n));
  rows.of_a.block<1, 3>(k, 3) = row.transpose();
  rows.of_b.block<1, 3>(k, 3) = -row.transpose();
  rows.error[k] = p.dot(n) - square.cosine;
  rows.bias[k] = row_rate.dot(now.w_a - now.w_b);
}

void constrain(const Slide& slide, const Pair& now, Eigen::Index k, JointRows& rows) {
  const auto& [turn_a, turn_b, x_a, x_b, v_a, v_b, w_a, w_b] = now;
  const Vector3d p = turn_a * slide.p;
  const Vector3d r_a = turn_a * slide.on_a;
  const Vector3d r_b = turn_b * slide.on_b;
  const Vector3d apart = x_b + r_b - x_a - r_a;
  const Vector3d apart_rate = v_b + w_b.cross(r_b) - v_a - w_a.cross(r_a);
  rows.of_a.block<1, 3>(k, 0) = -p.transpose();
  rows.of_a.block<1, 3>(k, 3) = (p.cross(apart) - r_a.cross(p)).transpose();
  rows.of_b.block<1, 3>(k, 0) = p.transpose();
  rows.of_b.block<1, 3>(k, 3) = r_b.cross(p).transpose();
  rows.error[k] = p.dot(apart);
  rows.bias[k] = w_a.cross(w_a.cross(p)).dot(apart) + 2 * w_a.cross(p).dot(apart_rate) +
                 p.dot(w_b.cross(w_b.cross(r_b)) - w_a.cross(w_a.cross(r_a)));
}

void constrain(const Distance& distance, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d r_a = now.turn_a * distance.on_a;
  const Vector3d r_b = now.turn_b * distance.on_b;
  const Vector3d apart = now.x_a + r_a - now.x_b - r_b;
  const Vector3d apart_rate = now.v_a + now.w_a.cross(r_a) - now.v_b - now.w_b.cross(r_b);
  const double length = apart.norm();
  const Vector3d n = apart / length;
  rows.of_a.block<1, 3>(k, 0) = n.transpose();
  rows.of_a.block<1, 3>(k, 3) = r_a.cross(n).transpose();
  rows.of_b.block<1, 3>(k, 0) = -n.transpose();
  rows.of_b.block<1, 3>(k, 3) = -r_b.cross(n).transpose();
  rows.error[k] = length - distance.length;
  const double along = n.dot(apart_rate);
  rows.bias[k] = n.dot(now.w_a.cross(now.w_a.cross(r_a)) - now.w_b.cross(now.w_b.cross(r_b))) +
                 (apart_rate.squaredNorm() - along * along) / length;
}

void constrain(const Gear& gear, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d r_a = now.turn_a * gear.on_a, r_b = now.turn_b * gear.on_b;
  const Vector3d n_a = now.turn_a * gear.axis_a, n_b = now.turn_b * gear.axis_b;
  const Vector3d apart = now.x_a + r_a - now.x_b - r_b;
  const Vector3d apart_rate = now.v_a + now.w_a.cross(r_a) - now.v_b - now.w_b.cross(r_b);
  const Vector3d n_a_rate = now.w_a.cross(n_a), n_b_rate = now.w_b.cross(n_b);
  Vector3d line = n_a.cross(n_b), line_rate = n_a_rate.cross(n_b) + n_a.cross(n_b_rate);
  if (!gear.intersects) {
    line = gear.across * apart.cross(n_a) + gear.along * apart;
    line_rate = gear.across * (apart_rate.cross(n_a) + apart.cross(n_a_rate)) + gear.along * apart_rate;
  }
  const double length = line.norm();
  const Vector3d l = line / length;
  rows.of_a.block<1, 3>(k, 0) = l.transpose();
  rows.of_a.block<1, 3>(k, 3) = (r_a.cross(l) + gear.of_a * n_a).transpose();
  rows.of_b.block<1, 3>(k, 0) = -l.transpose();
  rows.of_b.block<1, 3>(k, 3) = (gear.of_b * n_b - r_b.cross(l)).transpose();
  // A wheel's speed about its own axis does not change with the axis.
  rows.bias[k] = (line_rate - l * l.dot(line_rate)).dot(apart_rate) / length +
                 l.dot(now.w_a.cross(now.w_a.cross(r_a)) - now.w_b.cross(now.w_b.cross(r_b)));
}

/// Of a motor that holds its velocity; another one's row says nothing. `alone`: against the world.
void constrain(const Motor& motor, bool alone, const MotorLine& line, const Pair& now, Eigen::Index k,
               JointRows& rows) {
  const Vector3d& n = line.axis;
  const Vector3d carried = motor.carrier == Motor::Carrier::a   ? now.w_a
                           : motor.carrier == Motor::Carrier::b ? now.w_b
                                                                : Vector3d(Vector3d::Zero());
  const Vector3d turning = carried.cross(n);
  if (!motor.slides) {
    rows.of_a.block<1, 3>(k, 3) = n.transpose();
    rows.of_b.block<1, 3>(k, 3) = -n.transpose();
    rows.bias[k] = turning.dot(now.w_a - now.w_b);
    return;
  }
  // The point of b moves through a; that in the middle, through both.
  const Vector3d point_rate = now.v_b + now.w_b.cross(line.on_b);
  const Vector3d apart = now.v_a + now.w_a.cross(line.on_a) - point_rate;
  Vector3d rate_a = point_rate - now.v_a, rate_b = now.w_b.cross(line.on_b);
  if (motor.midway) {
    rate_a = alone ? Vector3d(Vector3d::Zero()) : Vector3d((now.v_b - now.v_a) / 2);
    rate_b = -rate_a;
  }
  rows.of_a.block<1, 3>(k, 0) = n.transpose();
  rows.of_b.block<1, 3>(k, 0) = -n.transpose();
  rows.of_a.block<1, 3>(k, 3) = line.on_a.cross(n).transpose();
  rows.of_b.block<1, 3>(k, 3) = -line.on_b.cross(n).transpose();
  rows.bias[k] = turning.dot(apart) + n.dot(now.w_a.cross(rate_a) - now.w_b.cross(rate_b));
}

}  // namespace

void constrain(const Joint& joint, const State& state, std::span<const Matrix3d> turns, JointRows& rows) {
  const Pair now(joint, state, turns);
  Eigen::Index k = 0;
  for (const Point& point : joint.points) {
    constrain(point, now, k, rows);
    k += 3;
  }
  for (const Square& square : joint.squares) constrain(square, now, k++, rows);
  for (const Slide& slide : joint.slides) constrain(slide, now, k++, rows);
  for (const Distance& distance : joint.distances) constrain(distance, now, k++, rows);
  for (const Gear& gear : joint.gears) constrain(gear, now, k++, rows);
  for (const Motor& motor : joint.motors) {
    rows.of_a.row(k).setZero();
    rows.of_b.row(k).setZero();
    rows.bias[k] = 0;
    if (motor.drive == Drive::holds) {
      constrain(motor, joint.b == world_body, line_of(joint, motor, state, turns), now, k, rows);
    }
    ++k;
  }
}

}  // namespace odeval::engine_rk4
