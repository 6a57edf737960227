#include "reference/planar/generalized_trace.hpp"

#include <algorithm>

#include "reference/planar/equations.hpp"
#include "reference/planar/generalized_state.hpp"

namespace odeval::reference {
namespace {

template <class Equations>
Trace trace_of(const Equations& equations, const SampleGrid& grid, const Motion& motion) {
  const std::size_t n = motion.shape().coordinates;
  const std::size_t count = motion.size();
  Trace trace;
  trace.t.reserve(count);
  trace.q.assign(n, Column(count));
  trace.qd.assign(n, Column(count));
  trace.kinetic.reserve(count);
  trace.potential.reserve(count);
  trace.gap.assign(count, 0.0);
  trace.out_of_plane.assign(count, 0.0);
  trace.contacts.assign(count, 0.0);
  typename Equations::State y;
  resize(y, 2 * n);
  for (std::size_t k = 0; k < count; ++k) {
    std::ranges::copy(motion[k].qd, std::ranges::copy(motion[k].q, y.begin()).out);
    trace.t.push_back(grid.time(static_cast<long>(k)));
    for (std::size_t i = 0; i < n; ++i) {
      trace.q[i][k] = y[i];
      trace.qd[i][k] = y[n + i];
    }
    trace.kinetic.push_back(equations.kinetic(y));
    trace.potential.push_back(equations.potential(y));
  }
  return trace;
}

}  // namespace

Trace generalized_trace(const Scenario& scenario, const SampleGrid& grid, const Motion& motion) {
  return with_any_equations(scenario, [&](const auto& equations) { return trace_of(equations, grid, motion); });
}

std::vector<double> joint_accelerations(const Scenario& scenario, const std::vector<double>& q,
                                        const std::vector<double>& qd) {
  return with_any_equations(scenario, [&]<class Equations>(const Equations& equations) {
    typename Equations::State y{};
    typename Equations::State rate{};
    resize(y, 2 * q.size());
    resize(rate, 2 * q.size());
    const auto n = static_cast<std::ptrdiff_t>(y.size() / 2);
    std::copy_n(q.begin(), n, y.begin());
    std::copy_n(qd.begin(), n, y.begin() + n);
    equations(y, rate);
    return std::vector<double>(rate.begin() + n, rate.end());
  });
}

}  // namespace odeval::reference
