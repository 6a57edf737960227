#include "reference/planar/sensitivity.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "odeval/error.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/error_spread.hpp"
#include "reference/planar/generalized_state.hpp"

namespace odeval::reference {
namespace {

template <std::size_t Size>
double largest_singular_value(const std::vector<double>& matrix) {
  using Square = Eigen::Matrix<double, static_cast<int>(Size), static_cast<int>(Size), Eigen::RowMajor>;
  return Eigen::JacobiSVD<Square>(Eigen::Map<const Square>(matrix.data())).singularValues()[0];
}

template <class Equations>
Sensitivity solve(const Scenario& scenario, const SampleGrid& grid, const Equations& equations, Tolerances tolerances) {
  constexpr std::size_t dof = Equations::dof;
  constexpr std::size_t size = 2 * dof;
  const FreeMotion<dof> motion(scenario);
  CvodeSolver solver(
      size,
      [&](double, const double* y, double* dydt) {
        typename Equations::State state, slope;
        std::copy_n(y, size, state.begin());
        equations(state, slope);
        std::copy_n(slope.begin(), size, dydt);
      },
      tolerances, scenario.name, scenario.duration_s);
  solver.follow_sensitivities([&](const double* y, double* jacobian) {
    Vector<size> state;
    std::copy_n(y, size, state.begin());
    for (const auto& row : motion.jacobian(state)) jacobian = std::copy_n(row.begin(), size, jacobian);
  });
  auto y = start_state<typename Equations::State>(*scenario.planar);
  solver.start(0, y.data());

  Sensitivity result;
  result.q.resize(dof);
  std::vector<double> transition(size * size, 0.0);
  for (std::size_t i = 0; i < size; ++i) transition[i * size + i] = 1;
  for (long row = 0; row < grid.rows; ++row) {
    const double t = grid.time(row);
    while (solver.end() < t) solver.step();
    if (row > 0) {
      solver.interpolate(t, y.data());
      solver.interpolate_sensitivities(t, transition.data());
    }
    result.t.push_back(t);
    for (std::size_t i = 0; i < dof; ++i) result.q[i].push_back(y[i]);
    result.transition.push_back(transition);
    result.growth.push_back(largest_singular_value<size>(transition));
    result.exponent.push_back(row > 0 ? std::log(result.growth.back()) / t : 0);
  }
  return result;
}

}  // namespace

Sensitivity solve_sensitivity(const Scenario& scenario, const SampleGrid& grid, Tolerances tolerances) {
  if (scenario.planar->wall) {
    throw UserError("scenario '" + scenario.name + "': sensitivities are for motions without a wall");
  }
  return with_equations(scenario, [&](const auto& equations) { return solve(scenario, grid, equations, tolerances); });
}

}  // namespace odeval::reference
