#pragma once
// Kinematics of a planar chain in the report's relative coordinates, seen from its first link.
//
// Velocities: d(point)/dt = sum_i qd_i J_i with J_i = n x (point - hinge_i), n the hinges' axis, for each joint i
// before the point; d(angle)/dt = sum_i qd_i. Products of columns do not change when the whole chain turns, so q1 plays
// no part.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "odeval/scenario.hpp"

namespace odeval {

class PlanarChain {
 public:
  using Point = std::array<double, 2>;  // along the first link, and across it

  explicit PlanarChain(const std::vector<Link>& links)
      : links_(links), hinges_(links.size() + 1), centres_(links.size()) {}

  /// Takes the relative angles of row k; q[i] is the column of joint i.
  void pose(const std::vector<std::vector<double>>& q, std::size_t k) {
    double angle = 0;
    Point direction{1, 0};
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (i > 0) {
        angle += q[i][k];
        direction = {std::cos(angle), std::sin(angle)};
      }
      const double length = links_[i].length_m;
      centres_[i] = moved(hinges_[i], links_[i].centre_m(), direction);
      hinges_[i + 1] = moved(hinges_[i], length, direction);
    }
  }

  std::size_t size() const { return links_.size(); }

  /// (J^T J)_ij of the end of the chain with its geometric Jacobian J, 6 x n: linear rows in m, angular ones in rad.
  double jacobian_product(std::size_t i, std::size_t j) const {
    return dot(arm(hinges_.back(), i), arm(hinges_.back(), j)) + 1;
  }

  /// M_ij of the mass matrix, kg m²: sum over the links k that both joints move of m_k J_ki . J_kj + I_k.
  double mass(std::size_t i, std::size_t j) const {
    double sum = 0;
    for (std::size_t k = std::max(i, j); k < links_.size(); ++k) {
      sum += links_[k].mass_kg * dot(arm(centres_[k], i), arm(centres_[k], j)) + links_[k].inertia_kgm2();
    }
    return sum;
  }

 private:
  static Point moved(const Point& from, double distance, const Point& along) {
    return {from[0] + distance * along[0], from[1] + distance * along[1]};
  }
  static double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1]; }
  // A quarter turn away from the column of the Jacobian, which products of columns do not see.
  Point arm(const Point& point, std::size_t joint) const {
    return {point[0] - hinges_[joint][0], point[1] - hinges_[joint][1]};
  }

  const std::vector<Link>& links_;
  std::vector<Point> hinges_;  // n + 1: the last is the end of the chain
  std::vector<Point> centres_;
};

}  // namespace odeval
