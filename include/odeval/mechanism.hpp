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

#include "odeval/geometry.hpp"

namespace odeval {

// ---- Shapes, with their centre in a body's centre of mass and their sides along its axes

struct Box {
  Vec3 sides_m{};
};
struct Sphere {
  double diameter_m = 0;
};
using Shape = std::variant<Box, Sphere>;

/// Sides of the box around a shape, m; of a sphere the diameter, three times.
Vec3 sides_m(const Shape& shape);
inline bool is_sphere(const Shape& shape) { return std::holds_alternative<Sphere>(shape); }

// ---- Bodies

/// Turned by an angle about a unit vector.
struct AxisAngle {
  Vec3 axis{};
  double angle_rad = 0;
};
/// How a body is turned from the world's axes, in the form in which it was said: a rotation vector (rad), or an axis and
/// an angle. An engine takes it in that form: through the other the same attitude differs in its last bits.
using Attitude = std::variant<Vec3, AxisAngle>;

/// The attitude as a rotation vector, rad.
Vec3 rotation_vector(const Attitude& attitude);

/// A rigid body and how it starts.
struct Body {
  Shape shape;
  double mass_kg = 0;
  Vec3 position_m{};    // of its centre of mass
  Attitude attitude{};  // of its own axes
  Vec3 velocity_m_s{};  // of its centre of mass
  Vec3 spin_rad_s{};
  /// Inertia tensor about the centre of mass along the body's own axes, by rows, symmetric, kg m². Absent: that of a
  /// uniform solid of the body's shape.
  std::optional<std::array<double, 9>> inertia_kgm2 = {};
  std::string name = {};

  /// Moments of a uniform solid about its own axes, kg m².
  Vec3 uniform_moments_kgm2() const;
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
  Vec3 anchor_m{};  // as of a ball joint
  Vec3 axis{0, 1, 0};  // unit
};
/// Every switch over kinds is a visit of this variant, so that a new kind is a list of compile errors and never an else.
using JointKind = std::variant<BallJoint, HingeJoint>;

/// Where a joint's halves meet when it is closed.
const Vec3& anchor_m(const JointKind& kind);

/// Drives a joint along its axis at a speed, with no more than a force. Positive turns the first body about the axis
/// against the second, or against the world.
struct Motor {
  double speed_rad_s = 0;
  double most_torque_Nm = 0;
};
/// Ends of a joint's way, counted as the motor counts, from where the joint stands at t = 0.
struct Stop {
  double low_rad = 0;
  double high_rad = 0;
  double restitution = 0;
};

/// Between two bodies, or a body and the world.
struct Joint {
  JointKind kind;
  std::size_t first = 0;              // number of a body
  std::optional<std::size_t> second;  // absent: the world
  Vec3 opening_m{};                   // by how much the first body stands away from its place in the closed joint
  std::optional<Motor> motor = {};    // of a hinge
  std::optional<Stop> stop = {};      // of a hinge

  /// The body whose force the joint tells: the second, or the first where the second is the world.
  std::size_t carried() const { return second.value_or(first); }
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
struct Friction {
  double limit = 0;  // a coefficient; in the constant-force model newtons, of a whole body
  FrictionModel model = FrictionModel::pyramid;
};

/// How two things touch: the first contact of the mechanism that names them both is theirs. What no contact names passes
/// through, and so do bodies that a joint connects.
struct Contact {
  double restitution = 0;                 // speed after an impact over speed before
  std::optional<Friction> friction = {};  // absent: nothing rubs, and no setting of friction has a meaning
  std::string first = {};                 // name of a body or an obstacle; empty: any
  std::string second = {};                // likewise

  /// Whether the contact is of these two, in either order.
  bool is_between(std::string_view a, std::string_view b) const;
};

struct Mechanism {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Obstacle> obstacles;
  std::vector<Contact> contacts;
};

/// A body's joint for tables that show one force a body: the one that carries it, or else the first that it is part of.
struct Carrier {
  std::size_t joint = 0;
  double sign = 1;  // -1: the joint tells the force on the other body
};
/// Nothing when no joint holds the body.
std::optional<Carrier> carrier_of(const Mechanism& mechanism, std::size_t body);

}  // namespace odeval
