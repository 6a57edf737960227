#include "engines/ode_rk4/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "engines/ode_rk4/refuse.hpp"

namespace odeval::engine_rk4 {
namespace {

std::string name(std::size_t body) { return body == world_body ? "the world" : "body " + std::to_string(body); }

std::string kind(dJointID joint) {
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

Body read_body(dBodyID id, std::size_t number) {
  const auto refuse_if = [&](bool bad, const char* why) {
    if (bad) refuse(name(number) + why, id);
  };
  refuse_if(dBodyIsKinematic(id) != 0, " is kinematic; only bodies with mass are moved");
  refuse_if(dBodyIsEnabled(id) == 0, " is disabled; enable it with dBodyEnable");
  refuse_if(dBodyGetLinearDamping(id) != 0 || dBodyGetAngularDamping(id) != 0, " is damped; set its damping to 0");
  refuse_if(dBodyGetMaxAngularSpeed(id) < dInfinity, " has a limited angular speed; set it to dInfinity");
  refuse_if(dBodyGetGyroscopicMode(id) == 0, " has its gyroscopic term off; set its gyroscopic mode to 1");
  dMass mass;
  dBodyGetMass(id, &mass);
  Body body{id, 1 / mass.mass, {}, {}};
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
  JointReader(dJointID id, const std::map<dBodyID, std::size_t>& numbers) : id_(id) {
    // Without a second body ODE may hold the only one as the first or, reversed, as the second.
    dBodyID a = dJointGetBody(id, 0);
    dBodyID b = dJointGetBody(id, 1);
    reversed_ = a == nullptr;
    if (reversed_) std::swap(a, b);
    joint_ = {id, numbers.at(a), b == nullptr ? world_body : numbers.at(b), {}, {}, {}, {}, {}};
    a_ = frame_of(a);
    b_ = frame_of(b);
  }

  Joint read() {
    switch (dJointGetType(id_)) {
      case dJointTypeBall:
        anchors(dJointGetBallAnchor, dJointGetBallAnchor2);
        break;
      case dJointTypeHinge:
        motor(dJointGetHingeParam, 0, false, axis(dJointGetHingeAxis), Motor::Carrier::a);
        hinge_stop();
        anchors(dJointGetHingeAnchor, dJointGetHingeAnchor2);
        along(axis(dJointGetHingeAxis));
        break;
      case dJointTypeUniversal:
        for (const int group : {0, 0x100}) no_stops(dJointGetUniversalParam, group);
        motor(dJointGetUniversalParam, 0, false, axis(reversed_ ? dJointGetUniversalAxis2 : dJointGetUniversalAxis1),
              Motor::Carrier::a);
        motor(dJointGetUniversalParam, 0x100, false,
              axis(reversed_ ? dJointGetUniversalAxis1 : dJointGetUniversalAxis2), Motor::Carrier::b);
        anchors(dJointGetUniversalAnchor, dJointGetUniversalAnchor2);
        square(axis(reversed_ ? dJointGetUniversalAxis2 : dJointGetUniversalAxis1),
               axis(reversed_ ? dJointGetUniversalAxis1 : dJointGetUniversalAxis2));
        break;
      case dJointTypeSlider:
        motor(dJointGetSliderParam, 0, true, slider_axis(), Motor::Carrier::a);
        slider_stop();
        slide(axis(dJointGetSliderAxis));
        same_turn();
        break;
      case dJointTypeFixed:
        point(b_.position, b_.position);
        same_turn();
        break;
      case dJointTypeAMotor:
        if (dJointGetAMotorMode(id_) != dAMotorUser) refuse_this(" has mode dAMotorEuler; dAMotorUser is supported");
        angular_motors();
        break;
      default:
        refuse_this(
            " is of a kind that is not supported; ball, hinge, slider, universal and fixed are, and angular "
            "motors, and contacts are made by the step itself");
    }
    return joint_;
  }

 private:
  [[noreturn]] void refuse_this(const char* why) const { refuse(name(joint_) + why, dJointGetBody(id_, 0), id_); }

  using GetVector = void (*)(dJointID, dReal*);
  using GetParameter = dReal (*)(dJointID, int);

  void no_stops(GetParameter get, int group) const {
    if (get(id_, dParamLoStop + group) == -dInfinity && get(id_, dParamHiStop + group) == dInfinity) return;
    refuse_this(
        " has stops; only hinges and sliders may: set dParamLoStop to -dInfinity and dParamHiStop to dInfinity");
  }

  void motor(GetParameter get, int group, bool slides, const Vector3d& in_world, Motor::Carrier carrier) {
    if (get(id_, dParamFMax + group) == 0) return;
    const Vector3d in_frame = carrier == Motor::Carrier::a   ? a_.direction(in_world)
                              : carrier == Motor::Carrier::b ? b_.direction(in_world)
                                                             : in_world;
    joint_.motors.push_back({slides, in_frame, carrier, group, 0, 0});
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
  void stop(GetParameter get, bool slides, const Vector3d& axis, const Vector3d& of_a, const Vector3d& of_b,
            double at_start) {
    const double low = get(id_, dParamLoStop), high = get(id_, dParamHiStop);
    if (low == -dInfinity && high == dInfinity) return;
    joint_.stops.push_back({slides, a_.direction(axis), of_a, of_b, at_start, low, high, get(id_, dParamBounce)});
  }
  void hinge_stop() {
    const Vector3d n = axis(dJointGetHingeAxis);
    const Vector3d across = n.unitOrthogonal();
    const double angle = (reversed_ ? -1 : 1) * dJointGetHingeAngle(id_);
    stop(dJointGetHingeParam, false, n, a_.direction(across), b_.direction(Eigen::AngleAxisd(-angle, n) * across), 0);
  }
  /// Motors and stops of a slider go by the position that ODE reports; those of a hinge do not.
  Vector3d slider_axis() const { return (reversed_ ? -1 : 1) * axis(dJointGetSliderAxis); }
  void slider_stop() {
    stop(dJointGetSliderParam, true, slider_axis(), a_.point(b_.position), b_.point(b_.position),
         dJointGetSliderPosition(id_));
  }

  Vector3d axis(GetVector get) const {
    dVector3 v;
    get(id_, v);
    return vector(v).normalized();
  }

  void anchors(GetVector first, GetVector second) {
    dVector3 one, two;
    first(id_, one);
    second(id_, two);
    point(vector(reversed_ ? two : one), vector(reversed_ ? one : two));
  }
  void point(const Vector3d& of_a, const Vector3d& of_b) { joint_.points.push_back({a_.point(of_a), b_.point(of_b)}); }
  void square(const Vector3d& of_a, const Vector3d& of_b) {
    joint_.squares.push_back({a_.direction(of_a), b_.direction(of_b)});
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
  void slide(const Vector3d& axis) {
    const Vector3d p = axis.unitOrthogonal();
    const Vector3d here = b_.position;
    for (const Vector3d& across : {p, Vector3d(axis.cross(p))}) {
      joint_.slides.push_back({a_.direction(across), a_.point(here), b_.point(here)});
    }
  }

  dJointID id_;
  bool reversed_;
  Joint joint_;
  Frame a_, b_;
};

}  // namespace

std::string name(const Joint& joint) {
  return "the " + kind(joint.id) + " between " + name(joint.a) + " and " + name(joint.b);
}

Mechanism read_mechanism(dWorldID world, dSpaceID space, std::span<dxBody* const> given, const Mechanism& earlier) {
  Mechanism mechanism;
  for (const dBodyID body : discover(world, space, given, earlier.numbers)) {
    mechanism.numbers.emplace(body, mechanism.bodies.size());
    mechanism.bodies.push_back(read_body(body, mechanism.bodies.size()));
  }
  if (mechanism.bodies.empty()) {
    refuse("found no body: give the space that holds their geoms, or name them in AccurateStepOptions::bodies");
  }
  std::set<dJointID> known;
  for (const Body& body : mechanism.bodies) {
    for (int j = 0; j < dBodyGetNumJoints(body.id); ++j) {
      const dJointID id = dBodyGetJoint(body.id, j);
      if (dJointIsEnabled(id) == 0 || !known.insert(id).second) continue;
      mechanism.joints.push_back(JointReader(id, mechanism.numbers).read());
    }
  }
  read_motors(mechanism);
  for (std::size_t i = 0; i < mechanism.joints.size(); ++i) {
    const Joint& one = mechanism.joints[i];
    for (std::size_t j = i + 1; j < mechanism.joints.size(); ++j) {
      const Joint& other = mechanism.joints[j];
      const auto shared = [&](std::size_t body) { return body != world_body && (body == other.a || body == other.b); };
      if (shared(one.a) || shared(one.b)) mechanism.neighbours.emplace_back(i, j);
    }
  }
  return mechanism;
}

void read_motors(Mechanism& mechanism) {
  for (Joint& joint : mechanism.joints) {
    for (Motor& motor : joint.motors) {
      const auto get = [&](int parameter) {
        switch (dJointGetType(joint.id)) {
          case dJointTypeHinge:
            return dJointGetHingeParam(joint.id, parameter + motor.group);
          case dJointTypeSlider:
            return dJointGetSliderParam(joint.id, parameter + motor.group);
          case dJointTypeUniversal:
            return dJointGetUniversalParam(joint.id, parameter + motor.group);
          default:
            return dJointGetAMotorParam(joint.id, parameter + motor.group);
        }
      };
      motor.velocity = get(dParamVel);
      motor.most = get(dParamFMax);
      if (!std::isfinite(motor.velocity) || !(motor.most >= 0)) {
        refuse(name(joint) + " has a motor with a velocity that is not finite, or no limit of force of 0 or more",
               mechanism.bodies[joint.a].id, joint.id);
      }
    }
  }
}

MotorLine line_of(const Joint& joint, const Motor& motor, const State& state, std::span<const Matrix3d> turns) {
  MotorLine line{motor.axis, Vector3d::Zero(), Vector3d::Zero()};
  if (motor.carrier == Motor::Carrier::a) line.axis = turns[joint.a] * motor.axis;
  if (motor.carrier == Motor::Carrier::b && joint.b != world_body) line.axis = turns[joint.b] * motor.axis;
  if (motor.slides && !joint.slides.empty() && joint.b != world_body) {
    line.on_a = state[joint.b].pose.position - state[joint.a].pose.position;
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
  rows.error[k] = p.dot(n);
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

/// Of a motor that holds its velocity; another one's row says nothing.
void constrain(const Motor& motor, const MotorLine& line, const Pair& now, Eigen::Index k, JointRows& rows) {
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
  // The point of a that is at b's centre now moves through a.
  const Vector3d apart = now.v_a + now.w_a.cross(line.on_a) - now.v_b;
  const Vector3d arm_rate = line.on_a.isZero(0) ? Vector3d(Vector3d::Zero()) : Vector3d(now.v_b - now.v_a);
  rows.of_a.block<1, 3>(k, 0) = n.transpose();
  rows.of_b.block<1, 3>(k, 0) = -n.transpose();
  rows.of_a.block<1, 3>(k, 3) = line.on_a.cross(n).transpose();
  rows.bias[k] = turning.dot(apart) + n.dot(now.w_a.cross(arm_rate));
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
  for (const Motor& motor : joint.motors) {
    rows.of_a.row(k).setZero();
    rows.of_b.row(k).setZero();
    rows.bias[k] = 0;
    if (motor.drive == Drive::holds) constrain(motor, line_of(joint, motor, state, turns), now, k, rows);
    ++k;
  }
}

}  // namespace odeval::engine_rk4
