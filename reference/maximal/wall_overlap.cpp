#include "reference/maximal/wall_overlap.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::reference::maximal {

using Eigen::Index;
using Eigen::Vector3d;

std::span<const Contact> WallOverlap::contacts(const Body& body) {
  const Vector3d normal = Vector3d::UnitX();
  const Eigen::RowVector3d toward = body.rotation.row(0);  // x components of the body's axes
  Index facing = 0;
  toward.cwiseAbs().maxCoeff(&facing);
  const Index u = (facing + 1) % 3;
  const Index v = (facing + 2) % 3;
  Vector3d corner;
  corner[facing] = std::copysign(half_sides_[facing], -toward[facing]);

  depth_ = 0;
  std::size_t count = 0;
  for (const double side_u : {-1.0, 1.0}) {
    for (const double side_v : {-1.0, 1.0}) {
      corner[u] = side_u * half_sides_[u];
      corner[v] = side_v * half_sides_[v];
      const Vector3d position = body.position + body.rotation * corner;
      const double depth = face_ - position.x();
      if (!(depth >= 0)) continue;
      found_[count++] = {body_, world, position, normal, depth};
      depth_ = std::max(depth_, depth);
    }
  }
  return {found_.data(), count};
}

}  // namespace odeval::reference::maximal
