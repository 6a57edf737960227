#pragma once
// Method lagrange-quad: extrapolation in quad precision at two step sizes. Slow, and right to 20 digits where the
// motion lets it be.
#include <boost/multiprecision/float128.hpp>
#include <memory>
#include <vector>

#include "odeval/engine.hpp"
#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval::reference {

using Quad = boost::multiprecision::float128;

/// Order of the extrapolation. Near it the cost of 20 digits is least, at any usual spacing of rows.
inline constexpr int quad_order = 14;

/// The difference between step sizes that a run refines its steps for, rad.
inline constexpr double quad_target_rad = 1e-20;

/// The finer of two runs, and how far the coarser is from it.
struct QuadRun {
  std::vector<std::vector<Quad>> rows;  // per sample q1..qn, qd1..qdn
  Column difference;                    // per sample, rad, largest over the angles; the coarser run has twice the step
  double largest_difference = 0;        // rad
  double step_s = 0;                    // largest step of the finer run
  long steps = 0;                       // of the finer run
  long evaluations = 0;                 // of all runs made
};

/// Halves the step until two runs agree within `quad_target_rad`, or until halving no longer helps because the motion
/// amplifies rounding beyond it. Every sample is hit by a step; nothing is interpolated. Throws UserError for a
/// scenario with a wall.
QuadRun solve_quad(const Scenario& scenario, const SampleGrid& grid);

/// One run with `substeps` steps of the given order between samples.
std::vector<std::vector<Quad>> extrapolate_quad(const Scenario& scenario, const SampleGrid& grid, int order,
                                                long substeps);

/// In joint coordinates, rounded to double; Outcome::self_difference is QuadRun::largest_difference.
std::unique_ptr<Simulation> make_quad(const Scenario& scenario, const SampleGrid& grid);

}  // namespace odeval::reference
