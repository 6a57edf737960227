// What the module shows: one function.
#include <string_view>

#include "engines/bullet/hinge_world.hpp"
#include "engines/bullet/multibody_world.hpp"
#include "engines/tree/tree_simulation.hpp"

namespace odeval::engine_bullet {
namespace {

std::unique_ptr<engine_tree::World> world(std::string_view method, const Scenario& scenario, double step_s) {
  if (method.find("hinge") != method.npos) return std::make_unique<HingeWorld>(scenario, step_s);
  return std::make_unique<MultibodyWorld>(scenario, step_s, method.find("rk4") != method.npos);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) Simulation* odeval_make(const char* method, const Scenario* scenario,
                                                                          const SampleGrid* grid) {
  return new engine_tree::TreeSimulation(*scenario, *grid, world(method, *scenario, grid->step_s));
}

}  // namespace odeval::engine_bullet
