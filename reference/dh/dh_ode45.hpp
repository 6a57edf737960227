#pragma once
// Method dh-ode45: recursive Newton-Euler from Denavit-Hartenberg parameters, integrated as lagrange-ode45 is.
#include <array>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include "odeval/engine.hpp"
#include "reference/dh/dh_chain.hpp"

namespace odeval::reference {

/// The chain as equations of motion for Ode45 (ode45_simulation.hpp); it has N joints, or with N = 0 any number.
template <std::size_t N>
class DhEquations {
 public:
  static constexpr std::size_t dof = N;
  using State = std::conditional_t<N == 0, std::vector<double>, std::array<double, 2 * N>>;

  explicit DhEquations(DhChain chain) : chain_(std::move(chain)) {}

  void operator()(const State& y, State& dydt) {
    const std::size_t n = chain_.joints();
    for (std::size_t i = 0; i < n; ++i) dydt[i] = y[n + i];
    chain_.accelerations(y.data(), y.data() + n, dydt.data() + n);
  }

 private:
  DhChain chain_;
};

/// In joint coordinates. Standard convention, as the report's D.4; no wall.
std::unique_ptr<Simulation> make_dh_ode45(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
