#pragma once
// A world as it is now, for a record.
#include <vector>

#include "audit/preload/record_format.hpp"
#include "audit/preload/worlds.hpp"

namespace odeval::audit {

/// A frame with its bodies, as bytes, until the next call.
class Sampler {
 public:
  struct Step {
    double h = 0;
    bool quick = false;
    std::uint32_t messages = 0;
    double ode_s = 0;
  };
  const std::vector<char>& take(World& world, const Step& step);

 private:
  std::vector<char> bytes_;
};

}  // namespace odeval::audit
