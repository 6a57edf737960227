#pragma once
// What a scenario file says, in its own words, before a generator makes a mechanism of it.
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/problems.hpp"
#include "odeval/scenario.hpp"

namespace odeval {

enum class BodyShape { box, sphere, cylinder, capsule, none };
/// In the order of the enumeration.
constexpr std::array<std::string_view, 5> body_shape_words{"box", "sphere", "cylinder", "capsule", "none"};
inline std::string word_of(BodyShape shape) { return std::string(body_shape_words[static_cast<std::size_t>(shape)]); }

/// One table [[bodies.shapes]]: more of a body.
struct ShapeTable {
  BodyShape shape = BodyShape::box;
  double mass_kg = 0;
  Vec3 size_m{};          // as a body's
  Vec3 position_m{};      // from where the body's `position` is, along the body's own axes
  Vec3 turn_rad{};        // against them
  std::string name = {};  // within the body; empty: it has none
};

/// One table [[bodies]].
struct BodyTable {
  BodyShape shape = BodyShape::box;  // none: those of its tables [[bodies.shapes]] alone
  double mass_kg = 0;                // 0: its shapes have all of it
  Vec3 size_m{};                     // of the box around it, along its own axes
  Vec3 position_m{};                 // of its shape's centre
  Vec3 centre_m{};                   // of the centre of its mass from there, along its own axes
  Vec3 turn_rad{};                   // rotation vector
  Vec3 velocity_m_s{};               // of what is at its position
  Vec3 spin_rad_s{};
  double aspect = 1;                                       // by how much the sides x and y are divided
  std::string name = {};                                   // empty: "body" and its number, from 1
  std::optional<std::array<double, 6>> inertia_kgm2 = {};  // xx, yy, zz, xy, xz, yz about its own axes; absent: uniform
  std::vector<ShapeTable> shapes = {};
};

/// [ground]: a plane through the origin that falls towards +x.
struct GroundTable {
  double slope_rad = 0;
  double restitution = 0;
  double friction = 0;  // a coefficient, or newtons of a whole body
  FrictionModel friction_model = FrictionModel::pyramid;
};

struct JointWord;  // model/joint_kinds.hpp

/// [joint]: what holds the first body, to the world where it is alone, to the second where there are two.
/// Or one table [[joints]], which says itself what it holds to what.
struct JointTable {
  const JointWord* kind = nullptr;
  Vec3 anchor_m{};                     // where its halves meet when it is closed
  Vec3 axis{0, 1, 0};                  // of a kind that has one
  Vec3 axis2{1, 0, 0};                 // of a kind that has two
  Vec3 axis3{0, 0, 1};                 // of a kind that has three
  std::array<double, 2> suspension{};  // of a kind that has one: N/m, N s/m
  Vec3 displacement_m{};               // from there to the first body's half at t = 0
  std::string parent;                  // names of bodies, or of the parent "world"
  std::string child;
  std::string name = {};  // empty: "joint" and its number, from 1
  // In the order of the joint's motions, of the child against the parent; empty: the file does not say.
  std::vector<double> q = {};   // where it starts, from as it is drawn, rad or m
  std::vector<double> qd = {};  // how much faster than the bodies' velocities say, rad/s or m/s
  // As in a Joint, but of the child against the parent, and from as it is drawn.
  std::array<std::optional<Motor>, 3> motors = {};  // tables motor, motor2 and motor3; the last two of several motions
  std::array<std::optional<Stop>, 3> stops = {};    // keys stops, stops2 and stops3, likewise
};
/// Of a motion, from 0: where it starts.
inline double start_of(const JointTable& joint, std::size_t motion) { return joint.q.empty() ? 0 : joint.q[motion]; }
inline constexpr std::array motor_keys{"motor", "motor2", "motor3"};
inline constexpr std::array stop_keys{"stops", "stops2", "stops3"};
inline constexpr std::array restitution_keys{"stop_restitution", "stop_restitution2", "stop_restitution3"};

/// One table [[springs]], [[torques]] or [[controllers]]: what acts, and the name of the joint that it acts on.
template <class Load>
struct LoadTable {
  std::string joint;
  std::size_t motion = 0;  // of a joint with several, from 1; 0: it says none
  Load load{};
};

/// One table [[planes]]: below it all is solid.
struct PlaneTable {
  std::string name;
  Vec3 normal{0, 0, 1};
  Vec3 point_m{};
};

/// One table [[contacts]].
struct ContactTable {
  std::vector<std::string> between;  // names of two, of a shape "body.shape"; empty: whatever meets
  double restitution = 0;
  std::optional<double> friction = {};  // a coefficient
  std::optional<Softness> softness = {};
  std::optional<Spring> spring = {};
};

/// One table [[struts]].
struct StrutTable {
  std::string parent;  // names of bodies, or of the parent "world"
  std::string child;
  Vec3 from_m{};  // of the parent, in the world at t = 0
  Vec3 to_m{};    // of the child
  double stiffness = 0;
  double damping = 0;
  std::optional<double> rest_m = {};  // absent: as long as it is at t = 0
};

struct Description {
  const Problem* problem = nullptr;
  std::optional<int> n;  // links of a chain; absent: as many as are listed
  std::vector<double> q0;
  std::vector<double> qd0;
  std::vector<Link> links;
  std::optional<Wall> wall;
  std::vector<BodyTable> bodies;
  std::optional<GroundTable> ground;
  std::optional<JointTable> joint;
  std::vector<JointTable> joints;
  std::vector<LoadTable<JointSpring>> springs;
  std::vector<LoadTable<Signal>> torques;
  std::vector<LoadTable<Controller>> controllers;
  std::vector<PlaneTable> planes;
  std::vector<ContactTable> contacts;
  bool limit_of_numbers = false;  // ODE's own limit, where it is the reference, keeps ERP and CFM as numbers
  std::vector<StrutTable> struts;

  /// The body of that name; nothing without one.
  std::optional<std::size_t> body_named(std::string_view name) const;
};

}  // namespace odeval
