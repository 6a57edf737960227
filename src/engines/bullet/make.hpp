#pragma once
// The methods of Bullet in double precision, which is loaded when one is wanted.
#include "odeval/engine.hpp"

namespace odeval::engine_bullet {

#ifdef ODEVAL_HAVE_BULLET
std::unique_ptr<Simulation> make_hinge(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_multibody(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_multibody_rk4(const Scenario& scenario, const SampleGrid& grid);
#else
inline constexpr MakeSimulation make_hinge = nullptr;
inline constexpr MakeSimulation make_multibody = nullptr;
inline constexpr MakeSimulation make_multibody_rk4 = nullptr;
#endif

}  // namespace odeval::engine_bullet
