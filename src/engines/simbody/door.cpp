// What the module shows: one function.
#include <string_view>

#include "engines/simbody/accuracy.hpp"
#include "engines/simbody/simbody_world.hpp"
#include "engines/tree/tree_simulation.hpp"

namespace odeval::engine_simbody {

extern "C" __attribute__((visibility("default"))) Simulation* odeval_make(const char* method, const Scenario* scenario,
                                                                          const SampleGrid* grid) {
  const bool merson = std::string_view(method) == "simbody-merson";
  auto world = make_world(scenario->mechanism,
                          {merson, scenario->gravity, grid->step_s, scenario->rtol.value_or(default_accuracy)});
  return new engine_tree::TreeSimulation(*scenario, *grid, std::move(world));
}

}  // namespace odeval::engine_simbody
