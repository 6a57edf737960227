// What the module shows: one function.
#include "engines/dart/dart_world.hpp"
#include "engines/tree/tree_simulation.hpp"

namespace odeval::engine_dart {

extern "C" __attribute__((visibility("default"))) Simulation* odeval_make(const char*, const Scenario* scenario,
                                                                          const SampleGrid* grid) {
  return new engine_tree::TreeSimulation(*scenario, *grid, std::make_unique<DartWorld>(*scenario, grid->step_s));
}

}  // namespace odeval::engine_dart
