#pragma once
// Engines' motions beside a reference of bodies.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engines/ode/module.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"
#include "tests/recorded.hpp"

namespace odeval::test {

template <std::size_t N>
std::array<double, N> row(const std::array<Column, N>& columns, std::size_t k) {
  std::array<double, N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = columns[i][k];
  return values;
}

/// The largest entry of the difference of two rotations: the angle between them, or up to a third less.
inline double apart(const Rotation& a, const Rotation& b) {
  double most = 0;
  for (std::size_t i = 0; i < 9; ++i) most = std::fmax(most, std::fabs(a[i] - b[i]));
  return most;
}

inline constexpr double row_spacing_s = 0.05;

inline SampleGrid rows_of(double h) { return {h, std::lround(row_spacing_s / h), 11}; }

/// Of bodies' places and attitudes over the run, m or rad.
inline double error(MakeSimulation make, Scenario scenario, const Reference& reference, double h) {
  scenario.step_s = h;
  const test::Recorded run = recorded(make, scenario, rows_of(h));
  double most = 0;
  for (std::size_t k = 0; k < run.motion.size(); ++k) {
    const ConstSample sample = run.motion[k];
    for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
      const BodyColumns& wanted = reference.trace.bodies[i];
      most = std::max({most, distance(sample.bodies[i].position, row(wanted.position, k)),
                       apart(sample.bodies[i].rotation, row(wanted.rotation, k))});
    }
  }
  return run.motion.size() == 11 ? most : std::numeric_limits<double>::quiet_NaN();
}

inline double observed_order(double coarse, double fine) { return std::log2(coarse / fine); }

inline MakeSimulation world_step() { return engine_ode::odeval_ode_double().make_step; }

inline constexpr double rk4_step_s = 5e-4;

}  // namespace odeval::test
