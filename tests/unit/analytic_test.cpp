// The closed form of one link: it solves the equation, keeps the energy, and agrees with 60 digits.
#include "reference/closed_form/analytic.hpp"

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/ellint_1.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/generate.hpp"
#include "odeval/error.hpp"
#include "reference/planar/wall_bounce.hpp"
#include "reference/planar/wall_contact.hpp"
#include "tests/check.hpp"
#include "tests/planar.hpp"

namespace {

using namespace odeval;
using reference::ClosedFormPendulum;
using reference::FreePendulum;
using State = FreePendulum::State;
using std::numbers::pi;

Scenario pendulum(double gravity = 9.81) {
  Scenario scenario;
  scenario.name = "single_pendulum";
  scenario.gravity = gravity;
  scenario.planar = test::make_planar(hanging_frame, {Link{1, 1, 0.1, 0.1}}, {0}, {0});
  return scenario;
}

Scenario wall_pendulum(double face, double q0 = 0, double qd0 = 0) {
  Scenario scenario = pendulum();
  scenario.name = "wall_pendulum";
  scenario.planar = test::make_planar(lying_frame, {Link{1, 1, 0.1, 0.1}}, {q0}, {qd0}, Wall{face, 1});
  return scenario;
}

// Report D.5: q'' = -(981/200) cos(q) / (401/1200), for gravity 9.81.
constexpr double omega_squared = 981.0 / 200 / (401.0 / 1200);
const double omega = std::sqrt(omega_squared);

const std::vector<State> starts{{0, 0},       {-pi / 2 + 0.01, 0}, {-1.5, 0.3},   {1.4, -0.2},  {1.5, 1.6},
                                {0.3, -9.5},  {-40.2, 12},         {7.9, -30},    {-pi / 2, 0}, {pi / 2, 0},
                                {-pi / 2, 0}, {2.0, -1e-3},        {pi / 2, 1e-9}};

void solves_the_equation() {
  for (const State& start : starts) {
    const FreePendulum motion(pendulum(), start);
    const State first = motion.at(0);
    CHECK_NEAR(first[0], start[0], 1e-15 * (1 + std::fabs(start[0])));
    CHECK_NEAR(first[1], start[1], 1e-15 * (1 + std::fabs(start[1])));
    const double energy = start[1] * start[1] / 2 + omega_squared * std::sin(start[0]);
    for (const double t : {0.1, 0.77, 1.9, 4.3}) {
      // Central difference of sixth order: its own error is d^6/140 of the seventh derivative, which the start at
      // 30 rad/s makes largest (2e-11); 7e-11 is the largest residual measured, the rest being rounding / d.
      const double d = 1e-3;
      const auto slope = [&](std::size_t i) {
        const auto pair = [&](double s) { return motion.at(t + s)[i] - motion.at(t - s)[i]; };
        return (45 * pair(d) - 9 * pair(2 * d) + pair(3 * d)) / (60 * d);
      };
      const State y = motion.at(t);
      CHECK_NEAR(slope(0), y[1], 3e-10);
      CHECK_NEAR(slope(1), -omega_squared * std::cos(y[0]), 3e-10);
      // Rounding of q and qd, 2e-16 each, of a sum of terms up to qd^2.
      CHECK_NEAR(y[1] * y[1] / 2 + omega_squared * std::sin(y[0]), energy, 1e-14 * (20 + start[1] * start[1]));
    }
  }
}

// Values by mpmath 1.3 with 60 digits from the same doubles: q0, qd0, t, q, qd.
void agrees_with_60_digits() {
  struct Row {
    double q0, qd0, t, q, qd, tolerance;
  };
  const Row rows[] = {
      // 1000 s: the phase omega t = 4e3 has one rounding of omega, 1e-16 relative, in it: 4e-13 times phi' / omega.
      {0.0, 0.0, 1000.0, -2.8906194490593584318, 2.7001147266090808377, 4e-12},
      {-1.0, 9.0, 1000.0, 7075.1893993722974621, 6.8546511428416955805, 1e-11},
      {0.3, -2.5, 100.0, -2.8295770376873131374, -4.8925750759174770468, 1e-12},
      {1.5, 0.01, 10.0, 1.4931012225102229719, -0.12297459624647683738, 1e-12},
      // Upright to the last bit: it leaves the equilibrium by 6e-17 rad and has fallen within 10 s. The start is a
      // double without error, so is the closed form's result.
      {1.5707963267948966, 0.0, 10.0, 0.28428643449883951988, -4.5959639055059695817, 1e-12},
      // Past the separatrix by 1e-8 either way and by 1e-12: rounding of qd0 to 1e-16 is amplified by up to
      // 1e-16 / 1e-8 = 1e-8 of the time spent upright; that of gravity likewise.
      {-1.5707963267948966, 7.66245494494693, 6.0, -4.3805964048347945542, -1.2653496171823398447, 3e-7},
      {-1.5707963267948966, 7.6624550981960295, 6.0, 7.5221892493058672818, 1.2653498239287050657, 3e-7},
      {-1.5707963267948966, 7.662455021579143, 6.0, 1.575608212932977006, 0.018435415950459364862, 3e-5},
  };
  for (const Row& row : rows) {
    const State y = FreePendulum(pendulum(), {row.q0, row.qd0}).at(row.t);
    CHECK_NEAR(y[0], row.q, row.tolerance);
    CHECK_NEAR(y[1], row.qd, row.tolerance * omega);
  }
}

void limits() {
  // Small swings: phi = a cos(omega t); the period is off by a^2/16 = 6e-14 relative, 2e-18 rad after 1 s.
  const double a = 1e-6;
  const FreePendulum small(pendulum(), {-pi / 2 + a, 0});
  for (const double t : {0.2, 0.6, 1.0}) CHECK_NEAR(small.at(t)[0] + pi / 2, a * std::cos(omega * t), 1e-15);

  // The separatrix from the bottom: phi = 2 atan(sinh(omega t)). 2 omega is known to 1e-16 relative, which
  // e^(omega t) = 4e3 at 2.2 s makes 1e-12; the last bit of qd0 decides between libration and rotation.
  for (const double turn : {1.0, -1.0}) {
    const FreePendulum upward(pendulum(), {-pi / 2, turn * 2 * omega});
    for (const double t : {0.1, 0.5, 1.0, 2.2}) {
      CHECK_NEAR(upward.at(t)[0], -pi / 2 + turn * 2 * std::atan(std::sinh(omega * t)), 1e-11);
    }
  }

  // Rest at the bottom for ever, and at the top as long as the distance of the double from pi/2, 6.1e-17 rad, grown
  // by cosh(omega t), stays invisible: 1.2e-9 at 4.6 s.
  CHECK_NEAR(FreePendulum(pendulum(), {-pi / 2, 0}).at(1e3)[0], -pi / 2, 1e-15);
  const FreePendulum upright(pendulum(), {pi / 2, 0});
  CHECK_NEAR(pi / 2 - upright.at(4.6)[0], 6.123233995736766e-17 * std::cosh(omega * 4.6), 1e-15);

  // No gravity: a uniform turn, and rest.
  const FreePendulum free(pendulum(0), {0.3, -2});
  CHECK_NEAR(free.at(100)[0], 0.3 - 200, 2e-13);  // 200 rad to 1e-15 relative
  CHECK_EQUAL(free.at(100)[1], -2.0);
  CHECK_EQUAL(FreePendulum(pendulum(0), {0.3, 0}).at(100)[0], 0.3);

  // Gravity upwards is the mirror image.
  const FreePendulum down(pendulum(9.81), {0.4, 5});
  const FreePendulum up(pendulum(-9.81), {-0.4, -5});
  for (const double t : {0.3, 2.0}) CHECK_NEAR(up.at(t)[0], -down.at(t)[0], 1e-14);
}

void time_runs_backwards() {
  for (const State& start : {State{0.2, 1}, State{1.3, -0.5}, State{0.3, -9.5}, State{-1.5, 20}}) {
    const State there = FreePendulum(pendulum(), start).at(3);
    const State back = FreePendulum(pendulum(), {there[0], -there[1]}).at(3);
    // Rounding of the state at 3 s, 1e-15 in q of up to 60 rad, grows at most by (phi'/omega) omega t = 60.
    CHECK_NEAR(back[0], start[0], 5e-13);
    CHECK_NEAR(back[1], -start[1], 5e-13 * omega);
  }
}

void period_is_the_elliptic_integral() {
  for (const double amplitude : {0.05, 1.0, 2.5, 3.1}) {
    const double period = 4 * boost::math::ellint_1(std::sin(amplitude / 2)) / omega;
    const FreePendulum motion(pendulum(), {-pi / 2 + amplitude, 0});
    // ellint_1 takes k with its rounding, worth 1e-16 / (1 - k^2) of a period: 2e-13 at 3.1 rad, and at the end of the
    // swing the angle moves with the square of an error in time.
    CHECK_NEAR(motion.at(period)[0], -pi / 2 + amplitude, 1e-14);
    CHECK_NEAR(motion.at(period / 2)[0], -pi / 2 - amplitude, 1e-14);
    CHECK_NEAR(motion.at(period / 4)[0], -pi / 2, 3e-12);
    CHECK_NEAR(motion.at(period)[1], 0, 3e-12);
  }
  const double qd0 = 9;  // at the bottom: k = 2 omega / qd0, a turn takes 2 k K(k) / omega
  const double k = 2 * omega / qd0;
  const FreePendulum turning(pendulum(), {-pi / 2, qd0});
  const double turn = 2 * k * boost::math::ellint_1(k) / omega;
  for (const int turns : {1, 2, 50}) {
    CHECK_NEAR(turning.at(turns * turn)[0], -pi / 2 + 2 * pi * turns, 1e-14 * turns * 2 * pi);
  }
}

// The angle at which the far corner of the hanging link reaches a face at 1 - c: sin x + 0.05 cos x = c with
// x = -pi/2 - q. In u = tan(x/2) that is a quadratic, (c + 0.05) u^2 - 2 u + (c - 0.05) = 0.
double touch_angle(double c) {
  const double u = (c - 0.05) / (1 + std::sqrt(1 - (c + 0.05) * (c - 0.05)));
  return -pi / 2 - 2 * std::atan(u);
}

void touches_the_wall_where_the_corner_is() {
  // 25 digits by mpmath; three roundings of about 2e-16.
  const reference::FreeArc arc = reference::free_arc(wall_pendulum(0.9));
  CHECK_NEAR(arc.low, -1.620879958363487340883557, 1e-15);
  CHECK_NEAR(arc.high, 1.620879958363487340883557, 1e-15);
  for (const double face : {0.95, 0.9, 0.7, 0.4}) {
    CHECK_NEAR(reference::free_arc(wall_pendulum(face)).low, touch_angle(1 - face), 2e-15);
  }
  // Other corners, faces to the right of the hinge, starts on other turns: the nearest corner is on the wall and
  // inside it just beyond. Distances of up to 1 m have 4e-16 of rounding.
  for (const double face : {-0.02, 0.0, 0.3, 0.949, 0.951, 0.97, 0.9999, 1.3, 1.8}) {
    for (const double q0 : {0.0, 2 * pi, -6 * pi}) {
      const Scenario scenario = wall_pendulum(face, q0);
      if (reference::WallContact(*scenario.planar).nearest_distance(q0) < 0) {
        CHECK_THROWS(reference::free_arc(scenario), UserError, "inside the wall");
        continue;
      }
      const reference::WallContact contact(*scenario.planar);
      const reference::FreeArc free = reference::free_arc(scenario);
      if (std::isinf(free.low)) {
        CHECK(face < -0.001);
        continue;
      }
      for (const double end : {free.low, free.high}) {
        CHECK_NEAR(contact.nearest_distance(end), 0, 1e-14);
        const double outwards = end > q0 ? 1e-3 : -1e-3;
        CHECK(contact.nearest_distance(end + outwards) < 0);
        CHECK(contact.nearest_distance(end - outwards) > 0);
      }
      CHECK(free.low < q0 && q0 < free.high && free.high - free.low < 2 * pi);
    }
  }
}

void first_impact_is_a_quadrature() {
  boost::math::quadrature::tanh_sinh<double> integrate;
  struct Row {
    double face, gravity, about;
  };
  // 0.4842 s is the reference of claims.md, for the 9.8 of the report's ODE program (its C.5).
  const Row rows[] = {{0.95, 9.8, 0.4842}, {0.95, 9.81, 0.4839}, {0.9, 9.81, 0.4932}, {0.7, 9.81, 0.5311}};
  for (const Row& row : rows) {
    Scenario scenario = wall_pendulum(row.face);
    scenario.gravity = row.gravity;
    const double angle = touch_angle(1 - row.face);
    const double twice = 2 * omega_squared * row.gravity / 9.81;
    // dt = dq / qd with qd^2 = 2 omega^2 sin(-q), from the horizontal.
    const double expected =
        integrate.integrate([&](double x) { return 1 / std::sqrt(twice * std::sin(x)); }, 0, -angle);
    const ClosedFormPendulum motion(scenario, 2);
    const Impact& impact = motion.outcome().impacts.at(0);
    CHECK_NEAR(impact.t, row.about, 6e-5);  // the digits quoted
    CHECK_NEAR(impact.t, expected, 1e-14);  // tanh-sinh stops at 1e-15 relative
    CHECK_NEAR(impact.q1, angle, 2e-15);    // as above
    CHECK_NEAR(impact.qd_before, -std::sqrt(twice * std::sin(-angle)), 1e-14);
    CHECK_EQUAL(impact.qd_after, -impact.qd_before);
    // Before and after: the motion is symmetric about an impact without loss.
    for (const double s : {1e-3, 0.3}) {
      CHECK_NEAR(motion.at(impact.t - s)[0], motion.at(impact.t + s)[0], 1e-14);
    }
    CHECK_NEAR(motion.outcome().impacts.at(1).t, 3 * expected, 5e-14);
  }
  // The same by mpmath from the elliptic integrals, 20 digits.
  CHECK_NEAR(ClosedFormPendulum(wall_pendulum(0.9), 1).outcome().impacts.at(0).t, 0.49318307343008495886, 2e-15);
  CHECK_NEAR(ClosedFormPendulum(wall_pendulum(0.7), 1).outcome().impacts.at(0).t, 0.53113583832230436861, 2e-15);
}

void turns_into_the_wall() {
  // Swung upwards fast enough to go over the top: it comes onto the wall from above, at the arc's high end.
  Scenario scenario = wall_pendulum(0.7, 0, 9);
  const ClosedFormPendulum over(scenario, 1);
  const Impact& impact = over.outcome().impacts.at(0);
  CHECK_NEAR(impact.q1, -touch_angle(0.3), 2e-15);
  CHECK_NEAR(over.at(impact.t)[0], impact.q1, 2e-15);
  CHECK_NEAR(impact.qd_before * impact.qd_before, 81 - 2 * omega_squared * std::sin(impact.q1), 1e-13);

  // Without gravity the touches are evenly spaced.
  scenario.gravity = 0;
  const ClosedFormPendulum even(scenario, 2);
  const double width = -2 * touch_angle(0.3);
  CHECK_NEAR(even.outcome().impacts.at(0).t, width / 2 / 9, 2e-15);
  CHECK_NEAR(even.outcome().impacts.at(3).t, 3.5 * width / 9, 5e-15);
}

void says_what_it_cannot() {
  Scenario scenario = pendulum();
  CHECK(reference::has_closed_form(*scenario.planar));
  scenario.planar = test::make_planar(hanging_frame, {2, scenario.planar->links[0]}, {0, 0}, {0, 0});
  CHECK(!reference::has_closed_form(*scenario.planar));
  CHECK_THROWS(reference::make_analytic(scenario, {1e-3, 1, 11}), UserError,
               "method 'analytic' has no closed form for 2 links; it does one link");
}

}  // namespace

int main() {
  solves_the_equation();
  agrees_with_60_digits();
  limits();
  time_runs_backwards();
  period_is_the_elliptic_integral();
  touches_the_wall_where_the_corner_is();
  first_impact_is_a_quadrature();
  turns_into_the_wall();
  says_what_it_cannot();
  return odeval::test::verdict();
}
