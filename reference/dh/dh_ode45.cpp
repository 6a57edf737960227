#include "reference/dh/dh_ode45.hpp"

#include "reference/planar/ode45.hpp"
#include "reference/planar/ode45_simulation.hpp"

namespace odeval::reference {
namespace {

template <std::size_t N>
std::unique_ptr<Simulation> simulation_of(const Scenario& scenario, const SampleGrid& grid) {
  constexpr auto standard = DhConvention::standard;
  DhChain chain(standard, pendulum_links(*scenario.planar, standard), pendulum_gravity(scenario));
  return std::make_unique<Ode45<DhEquations<N>>>(
      DhEquations<N>(std::move(chain)), grid, start_state<typename DhEquations<N>::State>(*scenario.planar),
      scenario.rtol.value_or(ode45_rtol), scenario.atol.value_or(ode45_atol));
}

}  // namespace

std::unique_ptr<Simulation> make_dh_ode45(const Scenario& scenario, const SampleGrid& grid) {
  const std::size_t links = scenario.planar->links.size();
  if (links == 1) return simulation_of<1>(scenario, grid);
  if (links == 2) return simulation_of<2>(scenario, grid);
  return simulation_of<0>(scenario, grid);
}

}  // namespace odeval::reference
