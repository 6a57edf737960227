#include "engines/bullet/make.hpp"

#include "engines/tree/open.hpp"

namespace odeval::engine_bullet {
namespace {

std::unique_ptr<Simulation> open(const char* method, const Scenario& scenario, const SampleGrid& grid) {
  return engine_tree::open(ODEVAL_INSTALLED_MODULE, ODEVAL_BUILT_MODULE, method, scenario, grid);
}

}  // namespace

std::unique_ptr<Simulation> make_hinge(const Scenario& scenario, const SampleGrid& grid) {
  return open("bullet-hinge-double", scenario, grid);
}
std::unique_ptr<Simulation> make_multibody(const Scenario& scenario, const SampleGrid& grid) {
  return open("bullet-multibody-double", scenario, grid);
}
std::unique_ptr<Simulation> make_multibody_rk4(const Scenario& scenario, const SampleGrid& grid) {
  return open("bullet-multibody-rk4-double", scenario, grid);
}

}  // namespace odeval::engine_bullet
