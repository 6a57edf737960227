// What the module shows: one function.
#include <algorithm>
#include <array>
#include <string_view>

#include "engines/mujoco/mujoco_world.hpp"
#include "engines/tree/tree_simulation.hpp"

namespace odeval::engine_mujoco {
namespace {

constexpr std::array integrators{Integrator{"mujoco-euler", "Euler", mjINT_EULER},
                                 Integrator{"mujoco-implicit", "implicit", mjINT_IMPLICIT},
                                 Integrator{"mujoco-rk4", "RK4", mjINT_RK4}};

}  // namespace

extern "C" __attribute__((visibility("default"))) Simulation* odeval_make(const char* method, const Scenario* scenario,
                                                                          const SampleGrid* grid) {
  const auto found = std::find_if(integrators.begin(), integrators.end(), [&](const Integrator& integrator) {
    return std::string_view(method) == integrator.method;
  });
  auto world = std::make_unique<MujocoWorld>(*scenario, grid->step_s, *found);
  return new engine_tree::TreeSimulation(*scenario, *grid, std::move(world));
}

}  // namespace odeval::engine_mujoco
