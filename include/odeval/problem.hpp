#pragma once
// The kinds of problem a scenario can pose, and how each lies in the world.
#include <array>
#include <string_view>

namespace odeval {

using Vec3 = std::array<double, 3>;

constexpr double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// How a plane of motion lies in the world. World frame: z points up, gravity along -z.
///
/// An absolute angle a of a link is counted from `horizontal` towards `up` (counter-clockwise seen
/// from the tip of `axis()`); the link's direction is horizontal*cos(a) + up*sin(a).
struct PlanarFrame {
  Vec3 hinge_m;          // first hinge
  Vec3 horizontal;       // unit
  Vec3 up;               // unit
  Vec3 hinge_axis;       // unit, the axis the report gave the hinges; +axis() or -axis()
  Vec3 along_body;       // unit, body frame: from a link's near hinge to its far end
  Vec3 across_body;      // unit, body frame: in the plane, axis() x along, where `width` lies
  double rest_turn_rad;  // a link at angle a is turned by a + rest_turn about axis()

  /// Axis of positive rotation.
  constexpr Vec3 axis() const { return cross(horizontal, up); }
};

/// What a problem is made of, and so which tables of a scenario file it has.
enum class Family {
  pendulum,  // links on hinges in a plane: q0, qd0, [[links]], [wall]
  bodies,    // bodies in space, alone or on a ground: [[bodies]], [ground], [joint]
};

struct Problem {
  std::string_view name;
  std::string_view summary;
  int links;  // 0: as many as the scenario says
  bool wall;
  PlanarFrame frame;
  Family family = Family::pendulum;
  bool ground = false;    // of bodies: whether there is something to lie on
  bool friction = false;  // of a ground: whether it holds what slides on it
  bool joint = false;     // of bodies: whether a joint holds the first
};

/// Report C.2: boxes hang along -z of their own frame and turn about x.
inline constexpr PlanarFrame hanging_frame{
    {0, 0, 2.1}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1.57079632679489661923};
/// Report C.5: the box lies along +x of its own frame and turns about y.
inline constexpr PlanarFrame lying_frame{{1, 0, 3}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0};

/// Potra et al. (IJNME 66, 2006): the same plane about (0, 0, 2).
inline constexpr PlanarFrame potra_frame{{0, 0, 2}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0};
/// Bodies: pictures look along +y, with x to the right and z up.
inline constexpr PlanarFrame body_frame{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, 0};

}  // namespace odeval
