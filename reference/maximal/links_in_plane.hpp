#pragma once
// The links of a pendulum as rigid bodies in their plane of motion, and how that plane lies in the world.
#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "odeval/motion.hpp"
#include "odeval/planar_view.hpp"
#include "reference/planar/point_in_plane.hpp"

namespace odeval::reference::maximal {

/// One link: a point of it, at first the centre of mass.
struct LinkInPlane : PointInPlane<double> {
  double angle;  // rad, absolute
  double rate;   // rad/s

  LinkInPlane along(double s) const {
    return {PointInPlane::along(s, std::cos(angle), std::sin(angle), rate), angle, rate};
  }
};

/// The links at t = 0, joints closed.
std::vector<LinkInPlane> links_at_start(const PlanarView& view);

inline Eigen::Vector3d eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Vec3 vec3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

/// The plane in the world.
class PlaneInWorld {
 public:
  explicit PlaneInWorld(const PlanarFrame& frame);

  Eigen::Vector3d axis() const { return axis_; }
  Eigen::Vector3d point(double x, double y) const { return hinge_ + direction(x, y); }
  Eigen::Vector3d direction(double x, double y) const { return x * horizontal_ + y * up_; }
  /// Body to world, of a link at that angle.
  Eigen::Matrix3d rotation(double angle) const;
  /// Absolute angle of a link so turned, on the branch nearest to `near`.
  double angle(const Eigen::Matrix3d& rotation, double near) const;
  /// Side lengths of the link's box along its body axes.
  Eigen::Vector3d box_sides(const Link& link) const;

 private:
  Eigen::Vector3d hinge_, horizontal_, up_, axis_;
  Eigen::Vector3d along_body_, across_body_;
};

/// A link as it is recorded.
BodyState body_state(const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& velocity,
                     const Eigen::Vector3d& spin, double angle);

}  // namespace odeval::reference::maximal
