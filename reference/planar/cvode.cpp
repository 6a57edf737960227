#include "reference/planar/cvode.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "reference/maximal/newton_euler.hpp"
#include "reference/planar/cvode_motion.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/long_chain_motion.hpp"

namespace odeval::reference {
namespace {

template <class Moved>
class CvodeSimulation final : public Simulation {
 public:
  CvodeSimulation(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid),
        coordinates_(scenario.planar->links.size()),
        motion_(scenario,
                {scenario.rtol.value_or(tight_tolerances.rtol), scenario.atol.value_or(tight_tolerances.atol), true}) {}

  SampleShape shape() const override { return {.coordinates = coordinates_}; }

  Outcome run(Recorder recorder) override {
    const double last = grid_.time(grid_.rows - 1);
    for (long row = 0; recorder && row < grid_.rows; ++row) {
      move_to(grid_.time(row));
      record(recorder, motion_.at(grid_.time(row)));
    }
    move_to(last);

    Outcome outcome;
    outcome.steps = motion_.steps();
    outcome.evaluations = motion_.evaluations();
    if (motion_.at_rest_from() <= last) outcome.at_rest_from = motion_.at_rest_from();
    const auto within = [last](const Impact& impact) { return impact.t <= last; };
    std::copy_if(motion_.impacts().begin(), motion_.impacts().end(), std::back_inserter(outcome.impacts), within);
    return outcome;
  }

 private:
  void move_to(double t) {
    while (motion_.end() < t) motion_.advance();
  }

  SampleGrid grid_;
  std::size_t coordinates_;
  Moved motion_;
};

}  // namespace

std::unique_ptr<Simulation> make_cvode(const Scenario& scenario, const SampleGrid& grid) {
  if (!scenario.planar) return make_free_cvode(scenario, grid);
  if (scenario.planar->links.size() > 2) return std::make_unique<CvodeSimulation<LongChainMotion>>(scenario, grid);
  return with_equations(scenario, [&]<std::size_t N>(const ChainEquations<double, N>&) -> std::unique_ptr<Simulation> {
    return std::make_unique<CvodeSimulation<CvodeMotion<N>>>(scenario, grid);
  });
}

}  // namespace odeval::reference
