#pragma once
// Joint coordinates of a chain that swings in a plane: a view of a mechanism, not its definition.
//
// A generator (src/model) makes a view and the mechanism that it belongs to in one go. References in joint coordinates
// read the view, engines the mechanism; where angles are told, and where a camera stands, the view says.
#include <array>
#include <optional>
#include <vector>

#include "odeval/geometry.hpp"

namespace odeval {

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

/// Bodies in space: pictures look along +y, with x to the right and z up.
inline constexpr PlanarFrame space_frame{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, 0};

/// What a link looks like, and so where its mass is.
enum class LinkShape { box, sphere };

/// A link of mass between its hinge and the next one, `length` away.
///
/// box     uniform; `width` lies in the plane of swing, `depth` along the hinge
/// sphere  uniform, of diameter `width` about the next hinge, on a massless rod; `depth` is its `width`
struct Link {
  double mass_kg = 0;   // > 0, of the whole link
  double length_m = 0;  // from hinge to hinge
  double width_m = 0;
  double depth_m = 0;
  LinkShape shape = LinkShape::box;

  /// Distance of the centre of mass from the near hinge, m.
  double centre_m() const { return shape == LinkShape::box ? length_m / 2 : length_m; }
  /// Of the far hinge from the centre of mass, m.
  double beyond_centre_m() const { return length_m - centre_m(); }

  // Moments of inertia about the centre, kg m².
  /// For rotation in the plane (report, D.1).
  double inertia_kgm2() const { return moment_kgm2(length_m, width_m); }
  /// About the link's own direction.
  double inertia_along_kgm2() const { return moment_kgm2(width_m, depth_m); }
  /// About the direction across it in the plane.
  double inertia_across_kgm2() const { return moment_kgm2(length_m, depth_m); }

 private:
  /// a and b: the sides of a box across the axis.
  double moment_kgm2(double a, double b) const {
    return shape == LinkShape::box ? mass_kg * (a * a + b * b) / 12.0 : mass_kg * width_m * width_m / 10.0;
  }
};

/// A flat wall that fills x <= face (world frame).
struct Wall {
  double face_m = 0;       // x
  double restitution = 1;  // speed after an impact over speed before
};

/// Link i is body i of the mechanism, and hangs on joint i.
struct PlanarView {
  PlanarFrame frame;         // where the plane lies
  std::vector<Link> links;   // n, from the first hinge outwards
  std::vector<double> q0;    // n, rad, at t = 0; q1 from the horizontal, the others relative to the link before
  std::vector<double> qd0;   // n, rad/s, likewise
  std::optional<Wall> wall;  // absent: nothing touches
};

}  // namespace odeval
