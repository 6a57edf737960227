// The accurate step for a program under audit, in a library that is loaded when it is asked for: its worlds have no
// spaces, since what they touch is the program's to say.
#include <ode/ode.h>

#include <cstdio>
#include <exception>
#include <map>

#include "engines/ode_rk4/accurate_step.hpp"

namespace {

struct Stepped {
  std::vector<dBodyID> bodies;
  odeval::AccurateStep step;
};

std::map<dWorldID, Stepped>& worlds() {
  static auto* const all = new std::map<dWorldID, Stepped>;  // outlives the program's own destructors
  return *all;
}

}  // namespace

/// One step of a world with these bodies. Returns 1; or 0, and `why` holds why it can not, in a line.
extern "C" __attribute__((visibility("default"))) int odeval_accurate_step_of(dWorldID world, const dBodyID* bodies,
                                                                              std::size_t count, double h, char* why,
                                                                              std::size_t size) {
  try {
    const std::vector<dBodyID> now(bodies, bodies + count);
    auto found = worlds().find(world);
    if (found == worlds().end() || found->second.bodies != now) {
      odeval::AccurateStepOptions options;
      options.bodies = now;
      worlds().erase(world);
      found = worlds().emplace(world, Stepped{now, odeval::AccurateStep(world, nullptr, std::move(options))}).first;
    }
    found->second.step(h);
    return 1;
  } catch (const std::exception& error) {
    std::snprintf(why, size, "%s", error.what());
    return 0;
  }
}
