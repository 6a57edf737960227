#include "reference/maximal/fixed_step.hpp"

#include <fmt/format.h>
#include <boost/numeric/odeint/stepper/euler.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>

#include <cmath>

#include "reference/maximal/planar_chain.hpp"

namespace odeval::reference {
namespace {

using namespace maximal;
namespace odeint = boost::numeric::odeint;

template <class State>
struct Euler : odeint::euler<State> {
  static constexpr long evaluations = 1;
};

template <class State>
struct Rk4 : odeint::runge_kutta4<State> {
  static constexpr long evaluations = 4;
};

template <int N, template <class> class Stepper>
class FixedStep final : public Simulation {
 public:
  using Chain = PlanarChain<N>;
  using State = typename Chain::State;

  FixedStep(const Scenario& scenario, const SampleGrid& grid)
      : grid_(grid), plane_(scenario.planar->frame), chain_(scenario), y_(Chain::start(*scenario.planar)) {}

  SampleShape shape() const override { return {.bodies = N, .joints = N}; }

  Outcome run(Recorder recorder) override {
    Outcome outcome;
    Stepper<State> stepper;
    const auto equations = [this](const State& y, State& dydt, double) { chain_(y, dydt); };
    record(recorder);
    for (long row = 1; row < grid_.rows && !outcome.diverged; ++row) {
      for (long k = 0; k < grid_.stride; ++k) {
        stepper.do_step(equations, y_, 0.0, grid_.step_s);
        ++outcome.steps;
        if (finite()) continue;
        outcome.diverged = true;
        outcome.reason = fmt::format("a place or a velocity left the finite numbers in the step from t = {:g} s",
                                     static_cast<double>(outcome.steps - 1) * grid_.step_s);
        break;
      }
      if (!outcome.diverged) record(recorder);
    }
    outcome.evaluations = outcome.steps * Stepper<State>::evaluations;
    return outcome;
  }

 private:
  // Their squares must stay finite as well: energies hold them.
  bool finite() const {
    double sum = 0;
    for (const double value : y_) sum += value * value;
    return sum < 1e290;
  }

  void record(Recorder recorder) const {
    if (!recorder) return;
    const Sample sample = recorder.next();
    const auto q = Chain::places_of(y_);
    const auto qd = Chain::rates_of(y_);
    const auto force = chain_.joint_forces(y_);
    for (int i = 0; i < N; ++i) {
      const double angle = q[3 * i + 2];
      const auto link = static_cast<std::size_t>(i);
      sample.bodies[link] =
          body_state(plane_.point(q[3 * i], q[3 * i + 1]), plane_.rotation(angle),
                     plane_.direction(qd[3 * i], qd[3 * i + 1]), qd[3 * i + 2] * plane_.axis(), angle);
      sample.joints[link].force = vec3(plane_.direction(force[2 * i], force[2 * i + 1]));
    }
  }

  SampleGrid grid_;
  PlaneInWorld plane_;
  Chain chain_;
  State y_;
};

// The one place that turns a number of links known at run time into a type.
template <template <class> class Stepper>
std::unique_ptr<Simulation> make(const Scenario& scenario, const SampleGrid& grid) {
  if (scenario.planar->links.size() == 1) return std::make_unique<FixedStep<1, Stepper>>(scenario, grid);
  return std::make_unique<FixedStep<2, Stepper>>(scenario, grid);
}

}  // namespace

std::unique_ptr<Simulation> make_maximal_euler(const Scenario& scenario, const SampleGrid& grid) {
  return make<Euler>(scenario, grid);
}

std::unique_ptr<Simulation> make_maximal_rk4(const Scenario& scenario, const SampleGrid& grid) {
  return make<Rk4>(scenario, grid);
}

}  // namespace odeval::reference
