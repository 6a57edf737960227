#pragma once
// A planar view alone, for tests of what reads nothing else.
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "odeval/planar_view.hpp"

namespace odeval::test {

/// A view without its mechanism: for references that are called directly, not for engines.
inline std::shared_ptr<const PlanarView> make_planar(const PlanarFrame& frame, std::vector<Link> links,
                                                     std::vector<double> q0, std::vector<double> qd0,
                                                     std::optional<Wall> wall = {}) {
  return std::make_shared<const PlanarView>(
      PlanarView{frame, std::move(links), std::move(q0), std::move(qd0), std::move(wall)});
}

}  // namespace odeval::test
