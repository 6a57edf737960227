#include "engines/tree/principal.hpp"

#include <cmath>

namespace odeval::engine_tree {
namespace {

double& at(std::array<double, 9>& matrix, std::size_t row, std::size_t column) { return matrix[3 * row + column]; }

/// Jacobi: turns the axes p and q until the tensor has nothing at (p, q).
void turn(std::array<double, 9>& tensor, Rotation& axes, std::size_t p, std::size_t q) {
  const double off = at(tensor, p, q);
  if (off == 0) return;
  const double slope = (at(tensor, q, q) - at(tensor, p, p)) / (2 * off);
  const double tangent = std::copysign(1, slope) / (std::fabs(slope) + std::hypot(slope, 1));
  const double cosine = 1 / std::hypot(tangent, 1);
  const double sine = tangent * cosine;
  const auto mix = [&](double& a, double& b) {
    const double old = a;
    a = cosine * old - sine * b;
    b = sine * old + cosine * b;
  };
  for (std::size_t k = 0; k < 3; ++k) mix(at(tensor, k, p), at(tensor, k, q));
  for (std::size_t k = 0; k < 3; ++k) mix(at(tensor, p, k), at(tensor, q, k));
  for (std::size_t k = 0; k < 3; ++k) mix(at(axes, k, p), at(axes, k, q));
  at(tensor, p, q) = 0;
  at(tensor, q, p) = 0;
}

}  // namespace

Principal principal_of(const std::array<double, 9>& tensor_kgm2) {
  std::array<double, 9> tensor = tensor_kgm2;
  Principal found{{}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  // What is left shrinks by its own square in each sweep: six reach any rounding.
  for (int sweep = 0; sweep < 6; ++sweep) {
    turn(tensor, found.axes, 0, 1);
    turn(tensor, found.axes, 0, 2);
    turn(tensor, found.axes, 1, 2);
  }
  found.moments_kgm2 = {tensor[0], tensor[4], tensor[8]};
  return found;
}

}  // namespace odeval::engine_tree
