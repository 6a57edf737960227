#pragma once
// A world as it is now, for a record.
#include <vector>

#include "audit/preload/record_format.hpp"
#include "audit/preload/worlds.hpp"

namespace odeval::audit {

/// Kinetic, and of gravity, of all bodies, J.
struct Energy {
  double kinetic = 0;
  double potential = 0;

  double sum() const { return kinetic + potential; }
};
Energy energy_of(const World& world);
Energy energy_of(const World& world, const Body& body);

/// A frame with what goes with it, as bytes, until the next call.
class Sampler {
 public:
  Sampler(bool motions, bool account) : motions_(motions), account_(account) {}

  struct Step {
    double h = 0;
    bool quick = false;
    std::uint32_t messages = 0;
    double ode_s = 0;
  };
  const std::vector<char>& take(World& world, const Step& step);

 private:
  bool motions_;
  bool account_;
  std::vector<char> bytes_;
};

}  // namespace odeval::audit
