#include "measure/time_shift.hpp"

#include <algorithm>
#include <cmath>

namespace odeval {
namespace {

struct Point {
  double q;
  double qd;
};

/// A value over time and its rate.
struct Path {
  const Column* q;
  const Column* qd;
};

/// The angles, or without any the coordinates of the bodies' centres; none of a trace without rates.
std::vector<Path> paths_of(const Trace& trace) {
  std::vector<Path> paths;
  for (std::size_t i = 0; i < std::min(trace.q.size(), trace.qd.size()); ++i) {
    paths.push_back({&trace.q[i], &trace.qd[i]});
  }
  for (std::size_t i = 0; trace.q.empty() && i < trace.bodies.size(); ++i) {
    const BodyColumns& body = trace.bodies[i];
    for (std::size_t k = 0; k < 3; ++k) paths.push_back({&body.position[k], &body.velocity[k]});
  }
  const auto incomplete = [&](const Path& path) {
    return path.q->size() != trace.rows() || path.qd->size() != trace.rows();
  };
  if (std::ranges::any_of(paths, incomplete)) return {};
  return paths;
}

/// The last sample at or before t but the very last, looked for from a sample near it.
std::size_t sample_before(const Column& times, double t, std::size_t k) {
  k = std::min(k, times.size() - 2);
  while (k > 0 && times[k] > t) --k;
  while (k + 2 < times.size() && times[k + 1] <= t) ++k;
  return k;
}

/// Cubic through the values and slopes at the samples k and k + 1 around t.
Point hermite(const Column& times, const Path& path, std::size_t k, double t) {
  const Column& q = *path.q;
  const double h = times[k + 1] - times[k];
  const double x = (t - times[k]) / h;
  const double rise = q[k + 1] - q[k];
  const double start = h * (*path.qd)[k];
  const double end = h * (*path.qd)[k + 1];
  const double c2 = 3 * rise - 2 * start - end;
  const double c3 = start + end - 2 * rise;
  return {q[k] + x * (start + x * (c2 + x * c3)), (start + x * (2 * c2 + x * 3 * c3)) / h};
}

/// Sums over samples and paths at one shift.
struct Misfit {
  double along = 0;  // residual times rate
  double rates = 0;  // rate squared
  double squares = 0;
  double largest = 0;
  std::size_t count = 0;
};

Misfit misfit(const Trace& trace, const Trace& wanted, double until_s, double most_s, double shift_s) {
  const std::vector<Path> paths = paths_of(trace);
  const std::vector<Path> wanted_paths = paths_of(wanted);
  Misfit sums;
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    const double t = trace.t[k];
    if (t > until_s || t - most_s < wanted.t.front() || t + most_s > wanted.t.back()) continue;
    const std::size_t near = sample_before(wanted.t, t + shift_s, k);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const Point there = hermite(wanted.t, wanted_paths[i], near, t + shift_s);
      const double residual = (*paths[i].q)[k] - there.q;
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
std::optional<TimeShift> best_time_shift(const Trace& trace, const Trace& wanted, double until_s, double most_s) {
  if (wanted.rows() < 2 || paths_of(trace).size() != paths_of(wanted).size()) return std::nullopt;
  double shift_s = 0;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Misfit sums = misfit(trace, wanted, until_s, most_s, shift_s);
    if (sums.count == 0 || !(sums.rates > 0)) return std::nullopt;
    const double next = std::clamp(shift_s + sums.along / sums.rates, -most_s, most_s);
    const bool settled = std::fabs(next - shift_s) <= 1e-9 * most_s;
    shift_s = next;
    if (!settled) continue;
    const Misfit left = misfit(trace, wanted, until_s, most_s, shift_s);
    const auto count = static_cast<double>(left.count);
    return TimeShift{shift_s, std::sqrt(left.squares / count), left.largest, std::sqrt(left.rates / count)};
  }
  return std::nullopt;
}

}  // namespace odeval
