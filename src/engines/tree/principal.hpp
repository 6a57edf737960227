#pragma once
// Principal axes of inertia, for engines whose bodies stand along them.
#include <array>

#include "odeval/geometry.hpp"

namespace odeval::engine_tree {

/// Moments, and the axes that they are about.
struct Principal {
  Vec3 moments_kgm2{};
  Rotation axes{};  // by columns, right-handed, in the body
};

/// Of a symmetric tensor by rows, to its own rounding. A diagonal one stays as it is.
Principal principal_of(const std::array<double, 9>& tensor_kgm2);

}  // namespace odeval::engine_tree
