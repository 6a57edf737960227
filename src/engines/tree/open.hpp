#pragma once
// Engines that are loaded when they are wanted: each is a module with one door.
#include <memory>
#include <string>

#include "odeval/engine.hpp"
#include "odeval/part.hpp"

namespace odeval::engine_tree {

/// The door: `method` is the name of one of the engine's methods. Throws as MakeSimulation does.
using Make = Simulation* (*)(const char* method, const Scenario*, const SampleGrid*);

/// Loads the module, which takes longer than a short run and brings whatever its libraries are linked to.
/// `installed`, `built`: as part_file has them.
inline std::unique_ptr<Simulation> open(const char* installed, const char* built, const char* method,
                                        const Scenario& scenario, const SampleGrid& grid) {
  const auto make = part_function<Make>(part_file(installed, built), "odeval_make", method);
  return std::unique_ptr<Simulation>(make(method, &scenario, &grid));
}

}  // namespace odeval::engine_tree
