#include "reference/maximal/links_in_plane.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace odeval::reference::maximal {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<LinkInPlane> links_at_start(const PlanarView& view) {
  std::vector<LinkInPlane> links;
  LinkInPlane hinge{};  // a link at its near hinge
  for (std::size_t i = 0; i < view.links.size(); ++i) {
    hinge.angle += view.q0[i];
    hinge.rate += view.qd0[i];
    links.push_back(hinge.along(view.links[i].centre_m()));
    hinge = hinge.along(view.links[i].length_m);
  }
  return links;
}

PlaneInWorld::PlaneInWorld(const PlanarFrame& frame)
    : hinge_(eigen(frame.hinge_m)),
      horizontal_(eigen(frame.horizontal)),
      up_(eigen(frame.up)),
      axis_(eigen(frame.axis())),
      along_body_(eigen(frame.along_body)),
      across_body_(eigen(frame.across_body)) {}

Matrix3d PlaneInWorld::rotation(double angle) const {
  const Vector3d along = direction(std::cos(angle), std::sin(angle));
  const Vector3d across = axis_.cross(along);
  return along * along_body_.transpose() + across * across_body_.transpose() +
         axis_ * along_body_.cross(across_body_).transpose();
}

double PlaneInWorld::angle(const Matrix3d& rotation, double near) const {
  const Vector3d along = rotation * along_body_;
  const double angle = std::atan2(along.dot(up_), along.dot(horizontal_));
  constexpr double turn = 2 * std::numbers::pi;
  return angle + turn * std::round((near - angle) / turn);
}

Vector3d PlaneInWorld::box_sides(const Link& link) const {
  return along_body_.cwiseAbs() * link.length_m + across_body_.cwiseAbs() * link.width_m +
         along_body_.cross(across_body_).cwiseAbs() * link.depth_m;
}

BodyState body_state(const Vector3d& position, const Matrix3d& rotation, const Vector3d& velocity, const Vector3d& spin,
                     double angle) {
  BodyState state;
  state.position = vec3(position);
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(state.rotation.data()) = rotation;
  state.velocity = vec3(velocity);
  state.spin = vec3(spin);
  state.angle = angle;
  return state;
}

}  // namespace odeval::reference::maximal
