#pragma once
// The methods of engines that are loaded when one is wanted: what a table of methods has of them.
#include <algorithm>
#include <memory>
#include <string>

#include "odeval/engine.hpp"
#include "odeval/part.hpp"

namespace odeval::engine_tree {

/// The one door of a module: `method` is the name of one of the engine's methods. Throws as MakeSimulation does.
using Make = Simulation* (*)(const char* method, const Scenario*, const SampleGrid*);

/// A text that is known when the program is built.
template <std::size_t N>
struct Word {
  char letters[N]{};
  constexpr Word(const char (&text)[N]) { std::copy_n(text, N, letters); }
};

/// Loads the engine's module, which takes longer than a short run and brings whatever its libraries are linked to.
template <Word engine, Word method>
std::unique_ptr<Simulation> make_of(const Scenario& scenario, const SampleGrid& grid) {
  const std::string file = "/libodeval_engine_" + std::string(engine.letters) + ".so";
  const std::string installed = ODEVAL_INSTALLED_MODULES + file;
  const std::string built = ODEVAL_BUILT_MODULES + file;
  const auto door = part_function<Make>(part_file(installed.c_str(), built.c_str()), "odeval_make", method.letters);
  return std::unique_ptr<Simulation>(door(method.letters, &scenario, &grid));
}

/// A method; null where the build has no such engine.
template <bool here, Word engine, Word method>
constexpr MakeSimulation made_by = nullptr;
template <Word engine, Word method>
constexpr MakeSimulation made_by<true, engine, method> = &make_of<engine, method>;

}  // namespace odeval::engine_tree
