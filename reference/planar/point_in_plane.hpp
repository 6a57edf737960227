#pragma once
// Where the links of a planar chain are and how they move: one way from hinge to hinge, for every type of number.

namespace odeval::reference {

/// Of a link, from the first hinge: x along PlanarFrame::horizontal, y along up.
template <class Real>
struct PointInPlane {
  Real x, y;    // m
  Real vx, vy;  // m/s

  /// The point s further along the link, given the cosine, the sine and the rate (rad/s) of its absolute angle.
  PointInPlane along(const Real& s, const Real& cosine, const Real& sine, const Real& rate) const {
    return {x + s * cosine, y + s * sine, vx - s * rate * sine, vy + s * rate * cosine};
  }
};

}  // namespace odeval::reference
