#include "engines/dart/make.hpp"

#include "engines/tree/open.hpp"

namespace odeval::engine_dart {
namespace {

std::unique_ptr<Simulation> open(const char* method, const Scenario& scenario, const SampleGrid& grid) {
  return engine_tree::open(ODEVAL_INSTALLED_MODULE, ODEVAL_BUILT_MODULE, method, scenario, grid);
}

}  // namespace

std::unique_ptr<Simulation> make_step(const Scenario& scenario, const SampleGrid& grid) {
  return open("dart-step", scenario, grid);
}

}  // namespace odeval::engine_dart
