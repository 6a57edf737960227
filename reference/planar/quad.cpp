#include "reference/planar/quad.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "odeval/error.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/extrapolation.hpp"
#include "reference/planar/generalized_state.hpp"

namespace odeval::reference {
namespace {

using QuadRows = std::vector<std::vector<Quad>>;

void refuse_wall(const Scenario& scenario) {
  if (!scenario.planar->wall) return;
  throw UserError("method lagrange-quad knows no walls, and '" + scenario.name +
                  "' has one; 'analytic' holds its closed form");
}

/// The fastest any link can turn, rad/s, if all the energy above the lowest state went into its turning.
template <std::size_t N>
double fastest_rate(const Scenario& scenario, const ChainEquations<double, N>& equations) {
  using State = typename ChainEquations<double, N>::State;
  const PlanarView& view = *scenario.planar;
  const auto start = start_state<State>(view);
  State lowest{};
  lowest[0] = -std::acos(0.0);
  const double energy = equations.kinetic(start) + equations.potential(start) - equations.potential(lowest);
  double inertia = view.links[0].inertia_kgm2();
  for (const Link& link : view.links) inertia = std::min(inertia, link.inertia_kgm2());
  return std::sqrt(2 * std::max(energy, 0.0) / inertia);
}

/// Steps between samples of the first, coarsest run.
long first_substeps(const Scenario& scenario, const SampleGrid& grid) {
  // Measured for the report's pendulum: at order 14 and a step of 0.1 / fastest rate (4 ms), halving once or twice
  // reaches the target.
  const double rate =
      with_equations(scenario, [&](const auto& equations) { return fastest_rate(scenario, equations); });
  const double spacing = grid.step_s * static_cast<double>(grid.stride);
  return std::max(1L, std::lround(std::ceil(spacing * rate / 0.1)));
}

double largest_angle_difference(const std::vector<Quad>& a, const std::vector<Quad>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size() / 2; ++i) {
    const double difference = std::fabs(static_cast<double>(a[i] - b[i]));
    if (!(difference <= largest)) largest = difference;  // a NaN stays
  }
  return largest;
}

Column differences(const QuadRows& a, const QuadRows& b) {
  Column column(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) column[k] = largest_angle_difference(a[k], b[k]);
  return column;
}

class QuadSimulation final : public Simulation {
 public:
  QuadSimulation(const Scenario& scenario, const SampleGrid& grid) : scenario_(scenario), grid_(grid) {}

  SampleShape shape() const override { return {.coordinates = scenario_.planar->links.size()}; }

  Outcome run(Recorder recorder) override {
    const QuadRun solved = solve_quad(scenario_, grid_);
    Outcome outcome;
    outcome.steps = solved.steps;
    outcome.evaluations = solved.evaluations;
    outcome.self_difference = solved.largest_difference;
    for (const std::vector<Quad>& row : solved.rows) {
      const auto finite = [](const Quad& value) { return boost::multiprecision::isfinite(value); };
      if (!std::all_of(row.begin(), row.end(), finite)) {
        outcome.diverged = true;
        outcome.reason = "a value left the finite numbers";
        break;
      }
      record(recorder, row);
    }
    return outcome;
  }

 private:
  Scenario scenario_;
  SampleGrid grid_;
};

}  // namespace

QuadRows extrapolate_quad(const Scenario& scenario, const SampleGrid& grid, int order, long substeps) {
  return with_equations<Quad>(scenario, [&]<std::size_t N>(const ChainEquations<Quad, N>& equations) {
    Extrapolation<Quad, 2 * N> extrapolation(order);
    auto y = start_state<typename ChainEquations<Quad, N>::State>(*scenario.planar);
    QuadRows rows{{y.begin(), y.end()}};
    for (long row = 1; row < grid.rows; ++row) {
      // The grid's times are doubles, and the states belong to exactly those.
      const Quad step = (Quad(grid.time(row)) - Quad(grid.time(row - 1))) / substeps;
      for (long k = 0; k < substeps; ++k) extrapolation.advance(equations, y, step);
      rows.emplace_back(y.begin(), y.end());
    }
    return rows;
  });
}

QuadRun solve_quad(const Scenario& scenario, const SampleGrid& grid) {
  refuse_wall(scenario);
  const long a_step = Extrapolation<Quad, 1>(quad_order).evaluations();
  const long gaps = grid.rows - 1;
  long substeps = first_substeps(scenario, grid);
  QuadRun run;
  QuadRows coarse = extrapolate_quad(scenario, grid, quad_order, substeps);
  run.evaluations = a_step * gaps * substeps;
  double worst_before = std::numeric_limits<double>::infinity();
  std::ptrdiff_t good_before = 0;
  while (true) {
    substeps *= 2;
    run.rows = extrapolate_quad(scenario, grid, quad_order, substeps);
    run.evaluations += a_step * gaps * substeps;
    run.difference = differences(coarse, run.rows);
    run.largest_difference = *std::max_element(run.difference.begin(), run.difference.end());
    if (run.largest_difference <= quad_target_rad) break;
    // Halving helps while it divides the difference (by 2^14, once the order shows) or, where the runs part altogether,
    // puts off their parting. Rounding in quad precision ends both.
    const auto beyond = [](double difference) { return !(difference <= quad_target_rad); };
    const std::ptrdiff_t good =
        std::find_if(run.difference.begin(), run.difference.end(), beyond) - run.difference.begin();
    if (!(run.largest_difference < worst_before / 16) && good <= good_before + gaps / 50) break;
    worst_before = run.largest_difference;
    good_before = good;
    coarse = std::move(run.rows);
  }
  run.step_s = grid.step_s * static_cast<double>(grid.stride) / static_cast<double>(substeps);
  run.steps = gaps * substeps;
  return run;
}

std::unique_ptr<Simulation> make_quad(const Scenario& scenario, const SampleGrid& grid) {
  refuse_wall(scenario);
  return std::make_unique<QuadSimulation>(scenario, grid);
}

}  // namespace odeval::reference
