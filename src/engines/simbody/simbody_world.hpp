#pragma once
// A mechanism in Simbody. Its headers are C++17 (in C++20 they are ambiguous); what stands here is what the rest sees.
#include <memory>

#include "engines/tree/world.hpp"
#include "odeval/mechanism.hpp"

namespace odeval::engine_simbody {

/// What the world is made of that no mechanism says.
struct Stepping {
  bool merson = false;  // Kutta-Merson with steps of its own, else semi-explicit Euler
  double gravity = 0;   // m/s²
  double step_s = 0;    // of the latter
  double rtol = 0;      // of the former: Simbody's accuracy
};

std::unique_ptr<engine_tree::World> make_world(const Mechanism& mechanism, const Stepping& stepping);

}  // namespace odeval::engine_simbody
