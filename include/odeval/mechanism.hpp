#pragma once
// What is simulated: rigid bodies, the joints between them, motors, stops, and what may touch what.
//
// Nothing here belongs to an engine. Units are SI; everything is in the world frame at t = 0 unless it says otherwise.
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "odeval/frame.hpp"
#include "odeval/softness.hpp"

namespace odeval {

// ---- Shapes, with their centre in a body's centre of mass and their sides along its axes

/// A box; a shape's sides are whole ones, not halves.
struct Box {
  Vec3 sides_m{};  // along the body's x, y, z
};
/// A ball.
struct Sphere {
  double diameter_m = 0;
};
/// A round bar along the body's z.
struct Cylinder {
  double diameter_m = 0;
  double length_m = 0;
};
/// The same with half a ball on either end.
struct Capsule {
  double diameter_m = 0;
  double length_m = 0;  // with both ends: at least the diameter
};
/// It is what touches, what is drawn and, by default, where the mass is.
using Shape = std::variant<Box, Sphere, Cylinder, Capsule>;

/// Sides of the box around a shape, m; of a sphere the diameter, three times.
Vec3 sides_m(const Shape& shape);
/// Whether it looks the same from every side: what has no edges to draw and no axes to turn.
inline bool is_sphere(const Shape& shape) { return std::holds_alternative<Sphere>(shape); }

/// Whether it is a cylinder or a capsule.
bool is_bar(const Shape& shape);
/// Moments of inertia of a uniform solid about its own axes, kg m²: m (y² + z²) / 12 and so on of a box, m d² / 10 of a
/// ball.
Vec3 uniform_moments_kgm2(const Shape& shape, double mass_kg);

// ---- Bodies

/// Turned by an angle about a unit vector, by the right hand.
struct AxisAngle {
  Vec3 axis{};           // unit, the same in the world and in the body
  double angle_rad = 0;  // of any size
};
/// How a body is turned from the world's axes, in the form in which it was said: a rotation vector (rad), or an axis
/// and an angle. An engine takes it in that form: through the other the same attitude differs in its last bits.
using Attitude = std::variant<Vec3, AxisAngle>;

/// The attitude as a rotation vector, rad.
Vec3 rotation_vector(const Attitude& attitude);

/// One of the shapes of a body.
struct Part {
  Shape shape;
  Frame place{};          // of its centre, from the body's centre of mass along the body's own axes
  std::string name = {};  // within its body, by which contacts know it; need not be there
};

/// A rigid body and how it starts.
struct Body {
  Shape shape;          // with its centre in the centre of mass
  double mass_kg = 0;   // > 0
  Vec3 position_m{};    // of its centre of mass
  Attitude attitude{};  // of its own axes
  Vec3 velocity_m_s{};  // of its centre of mass
  Vec3 spin_rad_s{};    // angular velocity
  /// Inertia tensor about the centre of mass along the body's own axes, by rows, symmetric, kg m². Absent: that of a
  /// uniform solid of the body's shape.
  std::optional<std::array<double, 9>> inertia_kgm2 = {};
  std::string name = {};  // for contacts and tables; need not be there
  /// Of a body of several shapes, all of them: they touch and are drawn in the place of `shape`, a box about the centre
  /// of mass that holds them, and `inertia_kgm2` is there.
  std::vector<Part> several = {};

  /// What touches and is drawn: one or more.
  std::vector<Part> parts() const;
  /// What contacts know one of them by: "hammer.head", or of a shape without a name the body's.
  std::string touches_as(const Part& part) const;

  /// Moments of a uniform solid of its shape, kg m².
  Vec3 uniform_moments_kgm2() const { return odeval::uniform_moments_kgm2(shape, mass_kg); }
  /// Number of its own axis along the longest side; of equally long ones the last.
  std::size_t long_axis() const;
};

// ---- Joints

/// Holds a point of one body on a point of the other.
struct BallJoint {
  Vec3 anchor_m{};  // where its halves meet when it is closed
};
/// Holds a point and an axis; leaves one turn about the axis.
struct HingeJoint {
  Vec3 anchor_m{};     // as of a ball joint
  Vec3 axis{0, 1, 0};  // unit
};
/// Leaves one way along an axis; nothing turns.
struct SliderJoint {
  Vec3 anchor_m{};     // a point of the line along which it slides
  Vec3 axis{0, 0, 1};  // unit
};
/// Holds a point and two axes at right angles; leaves a turn about each.
struct UniversalJoint {
  Vec3 anchor_m{};      // as of a ball joint
  Vec3 axis1{1, 0, 0};  // unit, fixed in the first body
  Vec3 axis2{0, 1, 0};  // unit, fixed in the second body, or in the world
};
/// Leaves nothing: two bodies move as one.
struct FixedJoint {
  Vec3 anchor_m{};  // as of a ball joint
};
/// Leaves a way along an axis and a turn about it.
struct PistonJoint {
  Vec3 anchor_m{};     // a point of the axis
  Vec3 axis{0, 0, 1};  // unit
};
/// A hinge on a slider (ODE's PR): leaves a way along an axis and a turn about another at right angles to it.
struct SlidingHingeJoint {
  Vec3 anchor_m{};      // a point of the hinge, which the second body carries, or the world
  Vec3 axis1{1, 0, 0};  // unit, of the way, fixed in the first body
  Vec3 axis2{0, 1, 0};  // unit, of the turn
};
/// A universal joint on a slider (ODE's PU).
struct SlidingUniversalJoint {
  Vec3 anchor_m{};      // of the universal joint, which the second body carries, or the world
  Vec3 way{0, 0, 1};    // unit, fixed in the first body
  Vec3 axis1{1, 0, 0};  // as of a universal joint
  Vec3 axis2{0, 1, 0};  // likewise
};
/// A wheel that is steered and sprung: turns about two axes, and goes along the first against a spring and a damper.
struct Hinge2Joint {
  Vec3 anchor_m{};       // of the second body, where the suspension is relaxed
  Vec3 axis1{0, 0, 1};   // unit, of steering and suspension, fixed in the first body
  Vec3 axis2{0, 1, 0};   // unit, of the wheel, fixed in the second body, at right angles to the other
  double stiffness = 0;  // of the suspension, N/m
  double damping = 0;    // likewise, N s/m; one of the two is above 0
};
/// Holds a body in the plane z = 0, which it may turn in: the first body, and the second is the world.
struct PlaneJoint {
  Vec3 anchor_m{};  // a point of the body
};
/// Every switch over kinds is a visit of this variant, so that a new kind is a list of compile errors and never an
/// else.
using JointKind = std::variant<BallJoint, HingeJoint, SliderJoint, UniversalJoint, FixedJoint, PistonJoint,
                               SlidingHingeJoint, SlidingUniversalJoint, Hinge2Joint, PlaneJoint>;

/// Where a joint's halves meet when it is closed; of a slider a point of its line.
const Vec3& anchor_m(const JointKind& kind);

/// What a joint leaves free as its bodies stand at t = 0: unit directions at right angles to each other.
struct Freedom {
  std::vector<Vec3> ways;   // of the anchor of one body against that of the other
  std::vector<Vec3> turns;  // of one body against the other
};
/// Of a kind; empty of one that leaves nothing.
Freedom freedom_of(const JointKind& kind);

/// One of the motions of a joint that leaves several, which may be driven: a turn about an axis, or a way along it.
struct Driveable {
  bool slides = false;
  Vec3 axis{};  // unit
};
/// Those of a kind, in the order of its axes; of a piston the way and then the turn, of a plane the ways of the body's
/// centre along the world's x and y and the turn about z. Empty of kinds with one motion, or whose motions have no axes
/// of their own.
std::vector<Driveable> driveable_of(const JointKind& kind);

// What drives, stops and loads a joint that leaves one motion, a hinge or a slider. All of it counts along the axis:
// the first body against the second, or against the world, from where the joint stands at t = 0; in rad and N m of a
// hinge, in m and N of a slider.

/// Drives a joint at a speed, with no more than a force.
struct Motor {
  double speed = 0;  // wanted, rad/s or m/s
  double most = 0;   // never more, either way, N m or N
};
/// Ends of a joint's way, rad or m.
struct Stop {
  double low = 0;          // at most 0, where the joint starts
  double high = 0;         // at least 0
  double restitution = 0;  // speed after striking the end over speed before
};
/// Pulls a joint to where it rests, and brakes it: -stiffness (q - rest) - damping qd.
struct JointSpring {
  double stiffness = 0;  // N m/rad or N/m
  double damping = 0;    // N m s/rad or N s/m
  double rest = 0;       // rad or m
};
/// A number over time: a constant, a sine and a table, added up.
struct Signal {
  double constant = 0;
  double amplitude = 0;  // of the sine
  double frequency_Hz = 0;
  double phase_rad = 0;           // at t = 0
  std::vector<double> times_s{};  // of the table, rising; straight lines between them, the ends' values beyond
  std::vector<double> values{};   // likewise

  double at(double t) const;
};
/// Presses a joint to where it shall be: kp (target - q) - kd qd.
struct Controller {
  double kp = 0;         // N m/rad or N/m
  double kd = 0;         // N m s/rad or N s/m
  Signal target{};       // rad or m
  bool sampled = false;  // once a step, and held over it, as programs do it; else at every moment
};
/// What drives, stops and loads one of several motions. It counts as of a hinge or a slider, about or along its axis.
struct AxisDrive {
  std::size_t motion = 0;           // number in driveable_of
  std::size_t number = 0;           // that files have for it, from 1
  std::optional<Motor> motor = {};  // these as of a Joint
  std::optional<Stop> stop = {};
  std::vector<JointSpring> springs = {};
  std::vector<Signal> torques = {};
  std::vector<Controller> controllers = {};
};

/// Between two bodies, or a body and the world.
struct Joint {
  JointKind kind;
  std::size_t first = 0;              // number of a body: ODE's first
  std::optional<std::size_t> second;  // absent: the world
  Vec3 opening_m{};                   // by how much the first body stands away from its place in the closed joint
  std::optional<Motor> motor = {};    // of a hinge or a slider, as all that follows
  std::optional<Stop> stop = {};
  std::vector<JointSpring> springs = {};
  std::vector<Signal> torques = {};  // of a slider forces
  std::vector<Controller> controllers = {};
  std::string name = {};               // for tables and files; need not be there
  std::vector<AxisDrive> drives = {};  // of a kind with several motions, instead of these; each with something in it

  /// The body whose force the joint tells: the second, or the first where the second is the world.
  std::size_t carried() const { return second.value_or(first); }
  /// Whether anything drives, stops or loads it.
  bool driven() const { return motor || stop || loaded() || !drives.empty(); }
  /// Whether springs, torques or controllers act on it.
  bool loaded() const { return !springs.empty() || !torques.empty() || !controllers.empty(); }
  /// Whether a controller looks at it once a step.
  bool sampled() const;
  /// The load of all that acts at every moment, at a time and a way q with its rate.
  double steady_load(double t, double q, double rate) const;
  /// Of the controllers that look once a step.
  double sampled_load(double t, double q, double rate) const;
};

/// The joint with what acts on one of its several motions in the place of what acts on a hinge or a slider.
Joint alone(const Joint& joint, const AxisDrive& drive);

/// A spring and a damper on the straight line between a point of one body and a point of another, or of the world. It
/// pulls by stiffness (length - rest) + damping d(length)/dt.
struct Strut {
  std::size_t first = 0;              // number of a body
  std::optional<std::size_t> second;  // absent: the world
  Vec3 first_end_m{};                 // in the world at t = 0, fixed in the first body
  Vec3 second_end_m{};                // likewise, in the second body or the world
  double stiffness_N_m = 0;
  double damping_Ns_m = 0;
  double rest_m = 0;
};

// ---- Contacts

/// All that lies below a plane.
struct HalfSpace {
  Vec3 normal{0, 0, 1};  // unit, away from what is solid
  double offset_m = 0;   // of the plane from the origin, along the normal
};
/// A box that does not move; its sides lie along the world's axes.
struct FixedBox {
  Vec3 centre_m{};
  Vec3 sides_m{};
};
/// What stands in the world and does not move.
struct Obstacle {
  std::variant<HalfSpace, FixedBox> shape;
  std::string name;
};

/// What bounds the force of friction on a body.
enum class FrictionModel {
  pyramid,   // a coefficient times the normal force (ODE's dContactApprox1)
  constant,  // a force, whatever the normal force is
};
/// What bounds friction, and by how much.
struct Friction {
  double limit = 0;  // a coefficient; in the constant-force model newtons, of a whole body
  FrictionModel model = FrictionModel::pyramid;
};

/// How two things touch: the first contact of the mechanism that names them both is theirs. What no contact names
/// passes through, and so do bodies that a joint connects.
struct Contact {
  double restitution = 0;                 // speed after an impact over speed before
  std::optional<Friction> friction = {};  // absent: nothing rubs, and no setting of friction has a meaning
  std::string first = {};                 // name of a body or an obstacle, or "body.shape"; empty: any
  std::string second = {};                // likewise
  std::optional<Softness> softness = {};  // of its own, in the place of that of the world; at the step of the run
  std::optional<Spring> spring = {};      // in the place of `softness`: each point that touches is one

  /// Whether the contact is of these two, in either order. They are told as Body::touches_as has it: a shape is also
  /// meant where its body is named, a body is not where one of its shapes is.
  bool is_between(std::string_view a, std::string_view b) const;
  /// Its own softness at a step; nothing where it has that of the world.
  std::optional<Softness> softness_at(double step_s) const;
};

/// The part of a start that a joint does not allow.
struct Misfit {
  double speed_m_s = 0;   // of the anchors against each other, across what is free
  double spin_rad_s = 0;  // of the bodies against each other, likewise
};

/// Everything that moves and what it can meet. Numbers of bodies and joints are places in these lists.
struct Mechanism {
  std::vector<Body> bodies;         // in the order of columns in traces
  std::vector<Joint> joints;        // in the order in which an engine is given them
  std::vector<Obstacle> obstacles;  // what stands still
  std::vector<Contact> contacts;    // which of them touch; empty: none
  std::vector<Strut> struts = {};   // springs between points
};

/// How far the velocities and spins of its bodies are from what the joint leaves free; an opening is not looked at.
Misfit misfit_of(const Mechanism& mechanism, const Joint& joint);

/// What the digits of a file may leave of it, m/s or rad/s: 1e-9 of the fastest that moves, and never less than that
/// of 1.
double allowed_misfit(const Mechanism& mechanism);

/// A body's joint for tables that show one force a body: the one that carries it, or else the first that it is part of.
struct Carrier {
  std::size_t joint = 0;  // number
  double sign = 1;        // -1: the joint tells the force on the other body
};
/// Nothing when no joint holds the body.
std::optional<Carrier> carrier_of(const Mechanism& mechanism, std::size_t body);

}  // namespace odeval
