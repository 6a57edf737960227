#pragma once
// Where a box overlaps a flat wall, as ODE's box-box collider reports it.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "reference/maximal/ode_step.hpp"

namespace odeval::reference::maximal {

/// Contacts of one body with the wall that fills x <= face.
class WallOverlap {
 public:
  WallOverlap(int body, const Eigen::Vector3d& sides, double face_m)
      : body_(body), half_sides_(sides / 2), face_(face_m) {}

  /// The corners behind the wall's face, of the side of the box that looks at it most squarely.
  std::span<const Contact> contacts(const Body& body);

  /// Of the deepest corner found last, m.
  double depth() const { return depth_; }

 private:
  int body_;
  Eigen::Vector3d half_sides_;
  double face_;
  double depth_ = 0;
  std::array<Contact, 4> found_{};
};

}  // namespace odeval::reference::maximal
