#pragma once
// The methods of DART, which is loaded when one is wanted.
#include "odeval/engine.hpp"

namespace odeval::engine_dart {

#ifdef ODEVAL_HAVE_DART
std::unique_ptr<Simulation> make_step(const Scenario& scenario, const SampleGrid& grid);
#else
inline constexpr MakeSimulation make_step = nullptr;
#endif

}  // namespace odeval::engine_dart
