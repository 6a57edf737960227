#pragma once
// Bodies and joints of an ODE world, as its public functions describe them, and the equations of constraint.
//
// World frame throughout. A twist (v, w) is the velocity of a body's centre and its angular velocity. A joint is up to
// six scalar constraints C = 0 of six kinds, each with its row J (C' = J u over the twists u of its two bodies) and
// the part of C'' that holds no acceleration:
//
//   point     r_a - r_b = 0           three rows: the anchors coincide
//   square    p . n = c               p fixed in body a, n in body b; c = 0 but for a hinge2
//   slide     p . (r_b - r_a) = 0     p fixed in body a
//   distance  |r_a - r_b| = d
//   roll      n . r = c, v_a + w_a x (r - x_a) = 0, r the lowest point of a sphere: two of them of velocities alone
//   gear      l . (r_a - r_b)' + R_a w_a . n_a + R_b w_b . n_b = 0, of velocities alone
//
//   ball      point                       universal  point, square
//   hinge     point, 2 square             slider     2 slide, 3 square
//   fixed     point, 3 square             piston     2 slide, 2 square
//   PR        2 slide, 2 square           PU         2 slide, square
//   dball     distance                    dhinge     distance, slide, 2 square
//   plane2d   slide, 2 square             hinge2     point or (sprung) 2 slide, square, and one more if it is locked
//   transmission  gear
#include <ode/ode.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engines/ode_rk4/block_ldl.hpp"

namespace odeval::engine_rk4 {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

struct Pose {
  Vector3d position;
  Eigen::Vector4d turn;  // quaternion (w, x, y, z), body to world
};

struct Twist {
  Vector3d linear;
  Vector3d angular;
};

struct BodyNow {
  Pose pose;
  Twist twist;
};
using State = std::vector<BodyNow>;

/// What ODE takes off a velocity once a step where it is above a threshold, and the drag that it stands for.
struct Damping {
  double share, threshold;
  double rate = 0;  // 1/s, for the step at hand

  void stand_for(double h) { rate = -std::log1p(-share) / h; }
  double of(const Vector3d& velocity) const { return velocity.norm() > threshold ? rate : 0; }
};

struct Body {
  dBodyID id;
  double inverse_mass;       // 0: kinematic, it moves as it moves
  Matrix3d inertia;          // body frame
  Matrix3d inverse_inertia;  // body frame
  Damping linear, angular;

  bool asleep = false;  // disabled: no forces, until something moves it

  bool damped() const { return linear.share > 0 || angular.share > 0; }
};

constexpr std::size_t world_body = static_cast<std::size_t>(-1);

struct Point {
  Vector3d on_a, on_b;  // body frames; world frame for the world
};
struct Square {
  Vector3d p, n;  // p in a's frame, n in b's
  double cosine = 0;
};
struct Slide {
  Vector3d p;           // in a's frame
  Vector3d on_a, on_b;  // points
};

struct Distance {
  Vector3d on_a, on_b;
  double length;
};
/// Two wheels of a transmission about axes of their bodies: what meshes goes at one speed along a line that turns with
/// the wheels' places.
struct Gear {
  Vector3d on_a, on_b;      // the wheels' centres
  Vector3d axis_a, axis_b;  // in a's and in b's frame
  bool intersects;          // the axes: the line is square to both of them
  double across, along;     // else: of the way d from b's centre to a's, l ~ across d x n_a + along d
  double of_a, of_b;        // radii, signed
};
/// A sphere of body a on a plane of the world, sticking: the point where they touch stands still.
struct Roll {
  Vector3d centre;        // of the sphere, in a's frame
  Vector3d normal;        // out of the plane
  double radius, height;  // of the sphere; of its lowest point along the normal
};
/// The suspension of a hinge2, along an axis: force and speed as ODE's ERP and CFM have them at the step at hand.
struct Spring {
  Vector3d axis;        // in a's frame
  Vector3d on_a, on_b;  // points, apart by nothing where it rests
  double erp, cfm;
  double stiffness = 0, damping = 0;  // N/m, N s/m
  double bearable = 0;                // of a step, as far as it is known (springs.cpp)
};

/// What a motor may do at the moment.
enum class Drive {
  released,  // nothing: in impacts, which last no time
  holds,     // keeps its velocity: one more equation
  pushes,    // at its limit of force
};
/// A motor along or about one axis.
struct Motor {
  enum class Carrier { world, a, b };
  bool slides;    // along the axis, else about it
  Vector3d axis;  // in the frame of its carrier
  Carrier carrier;
  Vector3d on_b;    // where it slides, a point of its line, in b's frame
  int group;        // of ODE's parameters
  double velocity;  // of a against b, m/s or rad/s
  double most;      // N or N m
  Drive drive = Drive::released;
  double force = 0;     // on a, while it pushes; while it holds, at the end of the last motion
  bool midway = false;  // where it slides: its point is in the middle of the two bodies, or at the only one
  bool late = false;    // contacts act on what it moves, at the end of a step: what it gives for them it gives there
  double at_end = 0;    // N s or N m s, that it gave there last
  double expected = 0;  // N or N m: of a late one that does not hold, within the step
};

/// How far a hinge may turn or a slider may slide, of a against b.
struct Stop {
  bool slides;
  Vector3d axis;  // in a's frame
  Vector3d of_a;  // in a's frame: of a slider, where its axis meets `of_b`; of a hinge, a direction square to its axis
  Vector3d of_b;  // in b's frame: a point; or the direction that `of_a` has at angle 0
  double at_start;  // m, of a slider where the points meet
  double low, high;
  double bounce;
};

struct Joint {
  dJointID id;       // null: what sticks at contacts (footholds.hpp)
  std::size_t a, b;  // b may be world_body
  std::vector<Point> points;
  std::vector<Square> squares;
  std::vector<Slide> slides;
  std::vector<Distance> distances;
  std::vector<Gear> gears;
  std::vector<Motor> motors;
  std::vector<Stop> stops;
  std::vector<Spring> springs;
  std::vector<Roll> rolls = {};

  /// Of constraints; those of motors come after.
  Eigen::Index constraints() const {
    return static_cast<Eigen::Index>(3 * points.size() + squares.size() + slides.size() + distances.size() +
                                     gears.size() + 3 * rolls.size());
  }
  Eigen::Index rows() const { return constraints() + static_cast<Eigen::Index>(motors.size()); }
};

/// What one joint says at one state. Rows beyond its own are zero, as are those of motors that do not hold.
struct JointRows {
  Matrix6 of_a, of_b;  // J, columns (linear, angular)
  Vector6 error;       // C: m, or rad for squares
  Vector6 bias;        // C'' without accelerations
};

struct Mechanism {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<std::pair<std::size_t, std::size_t>> neighbours;  // joints that share a body
  std::map<dBodyID, std::size_t> numbers;
};

/// One of ODE's vectors.
inline Vector3d vector(const dReal* v) { return {v[0], v[1], v[2]}; }

/// Rotation matrix of a quaternion of any length but 0.
inline Matrix3d rotation(const Eigen::Vector4d& turn) {
  const double w = turn[0], x = turn[1], y = turn[2], z = turn[3];
  const double s = 2 / turn.squaredNorm();
  Matrix3d r;
  r << 1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),  //
      s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x),   //
      s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y);
  return r;
}

/// Reads the given bodies, those of the space's geoms in the order they were made, and what their joints lead to, and
/// numbers them in this order; those of an earlier reading keep theirs. `lmotor_rel` tells what the axes of linear
/// motors are fixed to. Throws AccurateStepError.
using LMotorRel = std::function<int(dxJoint*, int)>;
Mechanism read_mechanism(dWorldID world, dSpaceID space, std::span<dxBody* const> given, const Mechanism& earlier = {},
                         const LMotorRel& lmotor_rel = {});

/// Adds a joint between bodies of the mechanism.
void add(Mechanism& mechanism, Joint joint);

/// How ODE tells motors and stops of a kind of joint: by axis, in groups of parameters.
struct Parameters {
  dReal (*get)(dJointID, int);
  int groups;  // 0x100 apart
};
Parameters parameters_of(dJointID joint);

/// Velocities and limits of motors, as they are now.
void read_motors(Mechanism& mechanism);
/// The line of a motor or a spring, and the point that a force along it acts at.
struct MotorLine {
  Vector3d axis;
  Vector3d on_a, on_b;  // arms from the bodies' centres
};
MotorLine line_of(const Joint& joint, const Motor& motor, const State& state, std::span<const Matrix3d> turns);
/// Of a against b, m/s or rad/s.
double motor_speed(const Joint& joint, const MotorLine& line, bool slides, const State& state);

/// Of a spring, and the force along it on a.
MotorLine line_of(const Joint& joint, const Spring& spring, const State& state, std::span<const Matrix3d> turns);
double pull(const Joint& joint, const Spring& spring, const State& state, std::span<const Matrix3d> turns);

/// "the hinge between body 0 and body 1"
std::string name(const Joint& joint);

/// Fills `rows` for a joint at a state; `turns` are the rotation matrices of the state's bodies. What is zero at every
/// state is not written and must be zero before.
void constrain(const Joint& joint, const State& state, std::span<const Matrix3d> turns, JointRows& rows);

}  // namespace odeval::engine_rk4
