#include "reference/planar/ode45.hpp"

#include <cstddef>
#include <optional>

#include "reference/planar/equations.hpp"
#include "reference/planar/ode45_simulation.hpp"

namespace odeval::reference {

std::unique_ptr<Simulation> make_ode45(const Scenario& scenario, const SampleGrid& grid) {
  return with_any_equations(scenario, [&]<class Equations>(const Equations& equations) -> std::unique_ptr<Simulation> {
    std::optional<WallBounce> wall;
    if (scenario.planar->wall) wall.emplace(scenario);
    return std::make_unique<Ode45<Equations>>(equations, grid, start_state<typename Equations::State>(*scenario.planar),
                                              scenario.rtol.value_or(ode45_rtol), scenario.atol.value_or(ode45_atol),
                                              wall);
  });
}

}  // namespace odeval::reference
