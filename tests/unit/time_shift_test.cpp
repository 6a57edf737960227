// The best time shift, on motions whose shift is known.
#include "measure/time_shift.hpp"

#include <cmath>
#include <functional>

#include "tests/check.hpp"

using namespace odeval;

namespace {

constexpr double step_s = 1e-3;

/// Two angles of unlike speed, ahead in time by `lead_s`, off by `bias`.
Trace two_angles(double until_s, double lead_s, double bias = 0) {
  Trace trace;
  trace.q.resize(2);
  trace.qd.resize(2);
  for (long k = 0; static_cast<double>(k) * step_s < until_s; ++k) {
    const double t = static_cast<double>(k) * step_s;
    trace.t.push_back(t);
    trace.q[0].push_back(std::sin(3 * (t + lead_s)) + bias);
    trace.qd[0].push_back(3 * std::cos(3 * (t + lead_s)));
    trace.q[1].push_back(2 * std::cos(5 * (t + lead_s)));
    trace.qd[1].push_back(-10 * std::sin(5 * (t + lead_s)));
  }
  return trace;
}

void check_known_shifts() {
  const Trace wanted = two_angles(1.2, 0);
  for (const double lead : {0.5 * step_s, -0.5 * step_s, 0.37 * step_s, 1.9 * step_s, 0.0}) {
    const TimeShift found = best_time_shift(two_angles(1.1, lead), wanted, 1.0, 2 * step_s).value();
    // Hermite between samples is off by h^4/384 * |q''''| = 1e-12/384 * 1250 = 3e-12 rad, at rates of order 5 rad/s.
    CHECK_NEAR(found.shift_s, lead, 3e-12);
    CHECK_BETWEEN(found.rms_left, 0, 3.3e-12);
    CHECK_BETWEEN(found.max_left, 0, 3.3e-12);
    // sqrt((9/2 + 100/2) / 2) = 5.22 over whole periods; until 1 s is less than one.
    CHECK_BETWEEN(found.sensitivity, 4.5, 6);
  }
}

// What is no shift stays as what is left: the best shift takes from a bias b on one of two angles only the part along
// the motion, which is small, so that b / sqrt(2) remains.
void check_rest_stays() {
  const double bias = 1e-4;
  const TimeShift found =
      best_time_shift(two_angles(1.1, step_s / 2, bias), two_angles(1.2, 0), 1.0, 2 * step_s).value();
  CHECK_NEAR(found.shift_s, step_s / 2, 2e-6);  // b <qd1> / <qd1^2 + qd2^2> = 1e-4 * 0.05 / 55 and a margin
  CHECK_NEAR(found.rms_left, bias / std::sqrt(2.0), 1e-3 * bias);
}

void check_limits() {
  const Trace wanted = two_angles(1.2, 0);
  // A shift beyond what may be looked for ends at that, and says by its rest that it explains nothing.
  const TimeShift found = best_time_shift(two_angles(1.1, 5 * step_s), wanted, 1.0, 2 * step_s).value();
  CHECK_NEAR(found.shift_s, 2 * step_s, 1e-15);
  CHECK_BETWEEN(found.rms_left, 1e-2, 2e-2);  // 3 ms at 5.2 rad/s

  Trace still = two_angles(1.1, 0);
  for (Column& rates : still.qd) rates.assign(still.rows(), 0.0);
  for (Column& angles : still.q) angles.assign(still.rows(), 1.0);
  CHECK(!best_time_shift(still, still, 1.0, step_s));
  CHECK(!best_time_shift(wanted, wanted, -1.0, step_s));
}

}  // namespace

int main() {
  check_known_shifts();
  check_rest_stays();
  check_limits();
  return odeval::test::verdict();
}
