// What the module shows: one function.
#include <algorithm>
#include <array>
#include <string_view>

#include "engines/mujoco/mujoco_world.hpp"
#include "engines/tree/tree_simulation.hpp"

namespace odeval::engine_mujoco {
namespace {

struct Integrator {
  std::string_view method;
  int number;  // MuJoCo's
};
constexpr std::array integrators{Integrator{"mujoco-euler", mjINT_EULER}, Integrator{"mujoco-implicit", mjINT_IMPLICIT},
                                 Integrator{"mujoco-rk4", mjINT_RK4}};

}  // namespace

extern "C" __attribute__((visibility("default"))) Simulation* odeval_make(const char* method, const Scenario* scenario,
                                                                          const SampleGrid* grid) {
  const auto found = std::find_if(integrators.begin(), integrators.end(),
                                  [&](const Integrator& integrator) { return integrator.method == method; });
  auto world = std::make_unique<MujocoWorld>(*scenario, grid->step_s, found->number);
  return new engine_tree::TreeSimulation(*scenario, *grid, std::move(world));
}

}  // namespace odeval::engine_mujoco
