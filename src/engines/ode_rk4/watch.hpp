#pragma once
// Has the user changed bodies, joints or geoms since the mechanism was read?
#include <array>
#include <cstdint>
#include <vector>

#include "engines/ode_rk4/mechanism.hpp"

namespace odeval::engine_rk4 {

/// Sees bodies, joints and geoms that came or went, what bodies are and weigh, motors, stops, anchors and axes.
class Watch {
 public:
  Watch(dSpaceID space, const Mechanism& mechanism);

  bool changed(dSpaceID space, const Mechanism& mechanism) const;

 private:
  struct Place {
    std::size_t joint, kind;
    std::array<double, 6> where;  // anchor and axis, in the frame of the joint's body
  };

  std::uint64_t geoms_;
  std::vector<std::uint64_t> seen_;
  std::vector<Place> places_;
};

}  // namespace odeval::engine_rk4
