#pragma once
// When a swinging link touches the wall. One link on one hinge.
//
// The link's outline in the plane of swing is a rectangle with four corners, at s = 0 or l along it
// and at +w/2 or -w/2 across it. A corner's distance from the wall's face is
//
//   d(q) = hinge_x + s cos q - side w/2 sin q - face        (side = +1: the counter-clockwise side)
//
// and since the wall is flat the link touches it when the nearest corner does: the smallest d is 0.
#include <array>
#include <cmath>
#include <cstddef>

#include "odeval/planar_view.hpp"

namespace odeval::reference {

class WallContact {
 public:
  static constexpr std::size_t corners = 4;

  explicit WallContact(const PlanarView& view)
      : length_(view.links.at(0).length_m),
        half_width_(view.links.at(0).width_m / 2),
        offset_(view.frame.hinge_m[0] - view.wall.value().face_m) {}

  /// Signed distance of a corner from the wall's face, m; negative inside the wall.
  template <class Real>
  Real distance(std::size_t corner, Real q) const {
    using std::cos;
    using std::sin;
    return offset_ + along(corner) * cos(q) - across(corner) * sin(q);
  }

  /// d(distance)/dq of that corner, m/rad.
  template <class Real>
  Real slope(std::size_t corner, Real q) const {
    using std::cos;
    using std::sin;
    return -along(corner) * sin(q) - across(corner) * cos(q);
  }

  /// Distance of the corner nearest the wall, m.
  double nearest_distance(double q) const {
    double nearest = distance(0, q);
    for (std::size_t corner = 1; corner < corners; ++corner) nearest = std::fmin(nearest, distance(corner, q));
    return nearest;
  }

 private:
  double along(std::size_t corner) const { return corner < 2 ? length_ : 0.0; }
  double across(std::size_t corner) const { return corner % 2 == 0 ? half_width_ : -half_width_; }

  double length_;
  double half_width_;
  double offset_;
};

/// A link that leaves the wall slower than this, with its weight against the wall, is at rest. The bounces left out
/// would move it by less than v^2 / (2 a), about 1e-15 rad where the weight turns it with 10 rad/s^2.
inline constexpr double rest_speed_rad_s = 1e-7;

}  // namespace odeval::reference
