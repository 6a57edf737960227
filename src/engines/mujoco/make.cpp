#include "engines/mujoco/make.hpp"

#include "engines/tree/open.hpp"

namespace odeval::engine_mujoco {
namespace {

std::unique_ptr<Simulation> open(const char* method, const Scenario& scenario, const SampleGrid& grid) {
  return engine_tree::open(ODEVAL_INSTALLED_MODULE, ODEVAL_BUILT_MODULE, method, scenario, grid);
}

}  // namespace

std::unique_ptr<Simulation> make_euler(const Scenario& scenario, const SampleGrid& grid) {
  return open("mujoco-euler", scenario, grid);
}
std::unique_ptr<Simulation> make_implicit(const Scenario& scenario, const SampleGrid& grid) {
  return open("mujoco-implicit", scenario, grid);
}
std::unique_ptr<Simulation> make_rk4(const Scenario& scenario, const SampleGrid& grid) {
  return open("mujoco-rk4", scenario, grid);
}

}  // namespace odeval::engine_mujoco
