#include "reference/planar/long_chain_reference.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "reference/planar/long_chain_motion.hpp"

namespace odeval::reference {
namespace {

constexpr double uncertainty = 10;
constexpr double least_rad = 1e-15;

/// The largest difference of an angle.
double apart(const LongChainMotion::State& a, const LongChainMotion::State& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size() / 2; ++i) largest = std::fmax(largest, std::fabs(a[i] - b[i]));
  return largest;
}

Reference sized_reference(std::size_t n, std::size_t rows) {
  Reference reference;
  Trace& trace = reference.trace;
  for (Column* column : {&trace.t, &trace.kinetic, &trace.potential, &trace.gap, &trace.out_of_plane, &trace.contacts,
                         &reference.uncertainty_q}) {
    column->assign(rows, 0.0);
  }
  trace.q.assign(n, Column(rows));
  trace.qd.assign(n, Column(rows));
  reference.joint_force.assign(n, {Column(rows), Column(rows), Column(rows)});
  return reference;
}

}  // namespace

Reference solve_long_chain(const Scenario& scenario, const SampleGrid& grid, Tolerances tight_run,
                           Tolerances loose_run) {
  const std::size_t n = scenario.planar->links.size();
  const auto rows = static_cast<std::size_t>(grid.rows);
  const PlanarFrame& frame = scenario.planar->frame;
  Reference reference = sized_reference(n, rows);
  Trace& trace = reference.trace;
  LongChainMotion tight(scenario, tight_run);
  LongChainMotion loose(scenario, loose_run);
  double difference = 0;
  const auto compare_at = [&](double t, const LongChainMotion::State& y) {
    while (loose.end() < t) loose.advance();
    difference = std::max(difference, apart(y, loose.at(t)));
  };
  for (std::size_t k = 0; k < rows; ++k) {
    const double t = grid.time(static_cast<long>(k));
    while (tight.end() < t) {
      tight.advance();
      // The loose run must still reach the row, which may lie before the end of this step.
      if (tight.end() < t) compare_at(tight.end(), tight.at(tight.end()));
    }
    const auto y = tight.at(t);
    compare_at(t, y);
    trace.t[k] = t;
    for (std::size_t i = 0; i < n; ++i) {
      trace.q[i][k] = y[i];
      trace.qd[i][k] = y[n + i];
    }
    trace.kinetic[k] = tight.equations().kinetic(y);
    trace.potential[k] = tight.equations().potential(y);
    reference.uncertainty_q[k] = k == 0 ? 0 : uncertainty * difference + least_rad;
    const auto forces = tight.equations().forces(y);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t d = 0; d < 3; ++d) {
        reference.joint_force[i][d][k] = forces[i][0] * frame.horizontal[d] + forces[i][1] * frame.up[d];
      }
    }
  }
  return reference;
}

}  // namespace odeval::reference
