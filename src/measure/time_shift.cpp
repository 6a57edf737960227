#include "measure/time_shift.hpp"

#include <algorithm>
#include <cmath>

#include "odeval/error.hpp"

namespace odeval {
namespace {

struct Point {
  double q;
  double qd;
};

/// Cubic through the values and slopes at the samples around t, which lies within the column.
Point hermite(const Column& times, const Column& q, const Column& qd, double t) {
  const auto after = std::upper_bound(times.begin() + 1, times.end() - 1, t);
  const auto k = static_cast<std::size_t>(after - times.begin()) - 1;
  const double h = times[k + 1] - times[k];
  const double x = (t - times[k]) / h;
  const double rise = q[k + 1] - q[k];
  const double start = h * qd[k];
  const double end = h * qd[k + 1];
  const double c2 = 3 * rise - 2 * start - end;
  const double c3 = start + end - 2 * rise;
  return {q[k] + x * (start + x * (c2 + x * c3)), (start + x * (2 * c2 + x * 3 * c3)) / h};
}

/// Sums over samples and angles at one shift.
struct Misfit {
  double along = 0;  // residual times rate
  double rates = 0;  // rate squared
  double squares = 0;
  double largest = 0;
  std::size_t count = 0;
};

Misfit misfit(const Trace& trace, const Trace& wanted, double until_s, double most_s, double shift_s) {
  Misfit sums;
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    const double t = trace.t[k];
    if (t > until_s || t - most_s < wanted.t.front() || t + most_s > wanted.t.back()) continue;
    for (std::size_t i = 0; i < trace.q.size(); ++i) {
      const Point there = hermite(wanted.t, wanted.q[i], wanted.qd[i], t + shift_s);
      const double residual = trace.q[i][k] - there.q;
      sums.along += residual * there.qd;
      sums.rates += there.qd * there.qd;
      sums.squares += residual * residual;
      sums.largest = std::max(sums.largest, std::fabs(residual));
      ++sums.count;
    }
  }
  return sums;
}

}  // namespace

// Gauss-Newton in one unknown.
TimeShift best_time_shift(const Trace& trace, const Trace& wanted, double until_s, double most_s) {
  if (wanted.rows() < 2) throw MachineError("best_time_shift: nothing to interpolate");
  double shift_s = 0;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Misfit sums = misfit(trace, wanted, until_s, most_s, shift_s);
    if (sums.count == 0 || !(sums.rates > 0)) throw MachineError("best_time_shift: no motion to compare");
    const double next = std::clamp(shift_s + sums.along / sums.rates, -most_s, most_s);
    const bool settled = std::fabs(next - shift_s) <= 1e-9 * most_s;
    shift_s = next;
    if (!settled) continue;
    const Misfit left = misfit(trace, wanted, until_s, most_s, shift_s);
    const auto count = static_cast<double>(left.count);
    return {shift_s, std::sqrt(left.squares / count), left.largest, std::sqrt(left.rates / count)};
  }
  throw MachineError("best_time_shift: the search did not settle");
}

}  // namespace odeval
