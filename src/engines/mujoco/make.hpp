#pragma once
// The methods of MuJoCo, which is loaded when one is wanted.
#include "odeval/engine.hpp"

namespace odeval::engine_mujoco {

#ifdef ODEVAL_HAVE_MUJOCO
std::unique_ptr<Simulation> make_euler(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_implicit(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_rk4(const Scenario& scenario, const SampleGrid& grid);
#else
inline constexpr MakeSimulation make_euler = nullptr;
inline constexpr MakeSimulation make_implicit = nullptr;
inline constexpr MakeSimulation make_rk4 = nullptr;
#endif

}  // namespace odeval::engine_mujoco
