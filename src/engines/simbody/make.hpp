#pragma once
// The methods of Simbody, which is loaded when one is wanted.
#include "odeval/engine.hpp"

namespace odeval::engine_simbody {

/// Simbody's own accuracy where nothing is asked.
inline constexpr double default_accuracy = 1e-3;

#ifdef ODEVAL_HAVE_SIMBODY
std::unique_ptr<Simulation> make_semi_explicit(const Scenario& scenario, const SampleGrid& grid);
std::unique_ptr<Simulation> make_merson(const Scenario& scenario, const SampleGrid& grid);
#else
inline constexpr MakeSimulation make_semi_explicit = nullptr;
inline constexpr MakeSimulation make_merson = nullptr;
#endif

}  // namespace odeval::engine_simbody
