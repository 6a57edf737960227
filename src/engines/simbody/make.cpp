#include "engines/simbody/make.hpp"

#include "engines/tree/open.hpp"

namespace odeval::engine_simbody {
namespace {

std::unique_ptr<Simulation> open(const char* method, const Scenario& scenario, const SampleGrid& grid) {
  return engine_tree::open(ODEVAL_INSTALLED_MODULE, ODEVAL_BUILT_MODULE, method, scenario, grid);
}

}  // namespace

std::unique_ptr<Simulation> make_semi_explicit(const Scenario& scenario, const SampleGrid& grid) {
  return open("simbody-semi-explicit", scenario, grid);
}
std::unique_ptr<Simulation> make_merson(const Scenario& scenario, const SampleGrid& grid) {
  return open("simbody-merson", scenario, grid);
}

}  // namespace odeval::engine_simbody
