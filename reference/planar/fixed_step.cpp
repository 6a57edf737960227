#include "reference/planar/fixed_step.hpp"

#include <boost/numeric/odeint/stepper/euler.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <optional>

#include "reference/planar/equations.hpp"
#include "reference/planar/generalized_state.hpp"
#include "reference/planar/wall_bounce.hpp"

namespace odeval::reference {
namespace {

namespace odeint = boost::numeric::odeint;

template <class Equations>
struct Rk4 {
  static constexpr long evaluations = 4;
  using State = typename Equations::State;
  odeint::runge_kutta4<State> stepper;

  void operator()(const Equations& equations, State& y, double h) {
    stepper.do_step([&](const State& at, State& rate, double) { equations(at, rate); }, y, 0.0, h);
  }
};

template <class Equations>
struct Euler {
  static constexpr long evaluations = 1;
  using State = typename Equations::State;
  odeint::euler<State> stepper;

  void operator()(const Equations& equations, State& y, double h) {
    stepper.do_step([&](const State& at, State& rate, double) { equations(at, rate); }, y, 0.0, h);
  }
};

template <class Equations>
struct SymplecticEuler {
  static constexpr long evaluations = 1;
  using State = typename Equations::State;
  State rate;

  void operator()(const Equations& equations, State& y, double h) {
    const std::size_t n = y.size() / 2;
    resize(rate, y.size());
    equations(y, rate);
    for (std::size_t i = 0; i < n; ++i) {
      y[n + i] += h * rate[n + i];
      y[i] += h * y[n + i];
    }
  }
};

// The loop around every stepper. `advance(y, outcome)` moves y by one step of the grid;
// false: the motion ends here, at rest or given up.
template <class State, class Advance>
Outcome march(State y, const SampleGrid& grid, Recorder recorder, Advance&& advance) {
  Outcome outcome;
  record(recorder, y);
  bool moving = true;
  for (long row = 1; row < grid.rows; ++row) {
    for (long k = 0; k < grid.stride && moving; ++k) {
      moving = advance(y, outcome);
      ++outcome.steps;
      if (!finite(y)) {
        set_not_finite(outcome, y, static_cast<double>(outcome.steps) * grid.step_s);
        return outcome;
      }
    }
    if (outcome.diverged) return outcome;
    record(recorder, y);
  }
  return outcome;
}

template <class Equations, class Step>
class FixedStep final : public Simulation {
 public:
  using State = typename Equations::State;

  FixedStep(const Scenario& scenario, const SampleGrid& grid, const Equations& equations)
      : equations_(equations), grid_(grid), start_(start_state<State>(*scenario.planar)) {
    if constexpr (Equations::dof == 1) {
      if (scenario.planar->wall) wall_.emplace(scenario);
    }
  }

  SampleShape shape() const override { return {.coordinates = start_.size() / 2}; }

  Outcome run(Recorder recorder) override {
    if constexpr (Equations::dof == 1) {
      if (wall_) return run_with_wall(*wall_, recorder);
    }
    Step step;
    Outcome outcome = march(start_, grid_, recorder, [&](State& y, Outcome&) {
      step(equations_, y, grid_.step_s);
      return true;
    });
    outcome.evaluations = outcome.steps * Step::evaluations;
    return outcome;
  }

 private:
  Outcome run_with_wall(const WallBounce& wall, Recorder recorder) {
    Step step;
    long steps_tried = 0;
    const auto stepped = [&](State y, double h) {
      step(equations_, y, h);
      ++steps_tried;
      return y;
    };
    Outcome outcome = march(start_, grid_, recorder, [&](State& y, Outcome& so_far) {
      if (so_far.steps == 0 && wall.rests(y)) {
        so_far.at_rest_from = 0;
        return false;
      }
      double left = grid_.step_s;
      for (;;) {
        const auto after = [&](double h) { return stepped(y, h); };
        const State end = after(left);
        const auto touch = wall.first_touch(y, end, left, after);
        if (!touch) {
          y = end;
          return true;
        }
        left -= touch->after_s;
        y = after(touch->after_s);
        const double t = static_cast<double>(so_far.steps + 1) * grid_.step_s - left;
        if (!wall.bounce(t, *touch, y, so_far)) return false;
      }
    });
    outcome.evaluations = steps_tried * Step::evaluations;
    return outcome;
  }

  Equations equations_;
  SampleGrid grid_;
  State start_;
  std::optional<WallBounce> wall_;
};

template <template <class> class Step>
std::unique_ptr<Simulation> make(const Scenario& scenario, const SampleGrid& grid) {
  return with_any_equations(scenario, [&]<class Equations>(const Equations& equations) -> std::unique_ptr<Simulation> {
    return std::make_unique<FixedStep<Equations, Step<Equations>>>(scenario, grid, equations);
  });
}

}  // namespace

std::unique_ptr<Simulation> make_rk4(const Scenario& scenario, const SampleGrid& grid) {
  return make<Rk4>(scenario, grid);
}
std::unique_ptr<Simulation> make_euler(const Scenario& scenario, const SampleGrid& grid) {
  return make<Euler>(scenario, grid);
}
std::unique_ptr<Simulation> make_symplectic_euler(const Scenario& scenario, const SampleGrid& grid) {
  return make<SymplecticEuler>(scenario, grid);
}

}  // namespace odeval::reference
