// The reference where no certified file exists: chains nobody listed, against quad precision; impacts, against an
// energy integral; every way a link and a wall can come to terms.
#include "reference/planar/reference_solution.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "model/generate.hpp"
#include "odeval/error.hpp"
#include "reference/closed_form/analytic.hpp"
#include "reference/planar/cvode.hpp"
#include "reference/planar/quad.hpp"
#include "reference/planar/wall_contact.hpp"
#include "tests/check.hpp"
#include "tests/planar.hpp"
#include "tests/recorded.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using std::numbers::pi;

bool all_finite(const Column& column) {
  return std::all_of(column.begin(), column.end(), [](double value) { return std::isfinite(value); });
}

// Where truncation rules and rounding hides nothing.
constexpr Tolerances coarse{1e-9, 1e-10};
constexpr Tolerances coarser{3.3e-8, 3.3e-9};

/// How many samples' errors are beyond the bound; truth(k, i) is angle i of sample k, known to `slack`.
template <class Truth>
int uncovered(const Reference& reference, const Truth& truth, double slack = 0) {
  int count = 0;
  for (std::size_t k = 0; k < reference.trace.rows(); ++k) {
    for (std::size_t i = 0; i < reference.trace.q.size(); ++i) {
      const auto off = static_cast<double>(truth(k, i) - reference.trace.q[i][k]);
      if (!(std::fabs(off) <= reference.uncertainty_q[k] + slack)) ++count;
    }
  }
  return count;
}

template <class Truth>
double largest_error(const Reference& reference, const Truth& truth) {
  double largest = 0;
  for (std::size_t k = 0; k < reference.trace.rows(); ++k) {
    for (std::size_t i = 0; i < reference.trace.q.size(); ++i) {
      largest = std::max(largest, std::fabs(static_cast<double>(truth(k, i) - reference.trace.q[i][k])));
    }
  }
  return largest;
}

// --- chains ---

Scenario random_chain(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Scenario scenario;
  scenario.name = "random";
  const std::size_t links = random() % 4 == 0 ? 1 : 2;
  scenario.duration_s = 5;
  scenario.gravity = between(1, 15);
  PlanarView view{.frame = hanging_frame, .links = {}, .q0 = {}, .qd0 = {}, .wall = {}};
  for (std::size_t i = 0; i < links; ++i) {
    view.links.push_back({between(0.3, 3), between(0.4, 2), between(0.02, 0.4), 0.1});
    view.q0.push_back(between(-3, 3));
    view.qd0.push_back(between(-3, 3));
  }
  scenario.planar = std::make_shared<const PlanarView>(std::move(view));
  return scenario;
}

void check_chains() {
  std::mt19937 random(20);
  constexpr SampleGrid grid{0.05, 1, 101};
  for (int chain = 0; chain < 10; ++chain) {
    const Scenario scenario = random_chain(random);
    const QuadRun truth = solve_quad(scenario, grid);
    CHECK_BETWEEN(truth.largest_difference, 0.0, quad_target_rad);
    const auto exact = [&](std::size_t k, std::size_t i) { return truth.rows[k][i]; };
    const Reference reference = solve_reference(scenario, grid);
    CHECK_EQUAL(uncovered(reference, exact), 0);
    // Promised for parameters nobody listed. Measured: 7e-10 at most.
    const double largest = largest_error(reference, exact);
    CHECK_BETWEEN(largest, 0.0, 1e-7);
    // At most 1500 times too wide; not without meaning.
    CHECK_BETWEEN(reference.uncertainty_q.back(), largest, 1e5 * largest + 1e-12);

    const Reference rough = solve_reference(scenario, grid, coarse, coarser);
    CHECK_EQUAL(uncovered(rough, exact), 0);
    CHECK_BETWEEN(largest_error(rough, exact), 50 * largest,
                  0.1);  // truncation indeed
  }
}

Scenario pendulum(double gravity, double length, double q0, double qd0) {
  Scenario scenario;
  scenario.name = "pendulum";
  scenario.duration_s = 10;
  scenario.gravity = gravity;
  scenario.planar = test::make_planar(hanging_frame, {{1, length, 0.1, 0.1}}, {q0}, {qd0});
  return scenario;
}

// Each of the bound's two terms is needed.
void check_terms() {
  // Slow swings: steps err by more than their tolerance. Without the second run the bound is 2 to 3 times too small.
  constexpr SampleGrid grid{0.02, 1, 501};
  for (const Scenario& scenario : {pendulum(0.176, 0.449, -0.062, 0), pendulum(0.13, 0.835, -0.096, 0),
                                   pendulum(0.163, 1.2, -0.0137, 0.0073), pendulum(0.237, 1.94, 0.0009, 0)}) {
    const ClosedFormPendulum truth(scenario, 10);
    const auto exact = [&](std::size_t k, std::size_t) { return truth.at(grid.time(static_cast<long>(k)))[0]; };
    CHECK_EQUAL(uncovered(solve_reference(scenario, grid, {1e-8, 1e-9}, {3.3e-7, 3.3e-8}), exact, 1e-14), 0);
  }
  // Rounding drifts in both runs alike over 100 s. Without the aligned errors the bound is 1.7 times too small.
  constexpr SampleGrid longer{0.2, 1, 501};
  std::mt19937 random(20);
  for (int chain = 0; chain < 8; ++chain) random_chain(random);
  const Scenario drifting = random_chain(random);  // a single pendulum
  const QuadRun truth = solve_quad(drifting, longer);
  const auto exact = [&](std::size_t k, std::size_t i) { return truth.rows[k][i]; };
  CHECK_EQUAL(uncovered(solve_reference(drifting, longer), exact), 0);
}

// --- joint forces ---

// Force of a joint = rate of change of the momentum of all links from it on, plus their weight. Momentum from q and qd;
// its central difference is off by h^2/6 times its third derivative: measured 0.12 mN at 0.2 ms, of forces of 15 to 60
// N.
void check_forces() {
  Scenario scenario;
  scenario.name = "forces";
  scenario.duration_s = 2;
  const std::vector<Link> links{{1.0, 1.0, 0.1, 0.1}, {0.5, 0.8, 0.2, 0.1}};
  const PlanarFrame& frame = hanging_frame;
  scenario.planar = test::make_planar(frame, links, {0.7, -0.8}, {0.3, 1.0});
  const Reference reference = solve_reference(scenario, {0.0002, 1, 10001});
  const auto momentum = [&](std::size_t k, std::size_t first, const Vec3& along) {
    double angle = 0, rate = 0, near = 0, sum = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      angle += reference.trace.q[i][k];
      rate += reference.trace.qd[i][k];
      const Vec3 normal = cross(frame.axis(), std::cos(angle) * frame.horizontal + std::sin(angle) * frame.up);
      const double speed = links[i].length_m * rate * dot(normal, along);
      if (i >= first) sum += links[i].mass_kg * (near + speed / 2);
      near += speed;
    }
    return sum;
  };
  double largest = 0;
  for (std::size_t k = 1; k + 1 < reference.trace.rows(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      double weight = 0;
      for (std::size_t j = i; j < 2; ++j) weight += links[j].mass_kg * scenario.gravity;
      for (const auto& [along, held] : {std::pair{frame.horizontal, 0.0}, std::pair{frame.up, weight}}) {
        const double wanted = (momentum(k + 1, i, along) - momentum(k - 1, i, along)) / 0.0004 + held;
        double force = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) force += along[axis] * reference.joint_force[i][axis][k];
        largest = std::max(largest, std::fabs(force - wanted));
      }
      CHECK_NEAR(reference.joint_force[i][0][k], 0.0, 1e-12);  // nothing across the plane, along x
    }
  }
  CHECK_BETWEEN(largest, 0.0, 5e-4);
}

// --- the wall ---

Scenario wall_pendulum(double face, double restitution, double q0 = 0, double qd0 = 0) {
  Scenario scenario;
  scenario.name = "wall_pendulum";
  scenario.duration_s = 5;
  scenario.planar = test::make_planar(lying_frame, {{1, 1, 0.1, 0.1}}, {q0}, {qd0}, Wall{face, restitution});
  return scenario;
}

constexpr SampleGrid five_seconds{0.001, 1, 5001};
constexpr SampleGrid five_seconds_coarsely{0.005, 1, 1001};  // of the same motion, where many are tried

/// qdd = -k cos q: k = m g c / I for this link, from the report's formulas.
constexpr double stiffness = 9.81 * 0.5 / ((1 + 0.01) / 12 + 0.25);

/// The lower angle of touch, where the near corner (0, -w/2) or the far one (l, -w/2) reaches the face first:
/// 1 - face + s cos q + w/2 sin q = 0.
double touch_angle(double face) {
  const double near_sine = (face - 1) / 0.05;
  if (near_sine > -1 + 1e-9) return std::asin(near_sine);
  return std::atan2(0.05, 1.0) - std::acos((face - 1) / std::hypot(1.0, 0.05));
}

/// Time from rest at angle `from` down to angle `to`, by energy: qd^2 = 2 k (sin from - sin q). With q = from - s^2 the
/// integrand is smooth, and 61 points leave rounding.
double fall_time(double from, double to) {
  const auto integrand = [from](double s) {
    // sin a - sin b = 2 cos((a + b) / 2) sin((a - b) / 2), which keeps its digits for a small s.
    const double drop = s == 0 ? std::cos(from) : 2 * std::cos(from - s * s / 2) * std::sin(s * s / 2) / (s * s);
    return 2 / std::sqrt(2 * stiffness * drop);
  };
  return boost::math::quadrature::gauss_kronrod<double, 61>::integrate(integrand, 0.0, std::sqrt(from - to), 10, 1e-15);
}

double touch_speed(double from, double to) { return std::sqrt(2 * stiffness * (std::sin(from) - std::sin(to))); }

// Without loss the link comes back to the horizontal: impacts at t1, 3 t1, 5 t1 ...
void check_elastic_impacts() {
  for (const double face : {0.95, 0.9, 0.7, 0.97, 0.5}) {
    const double stop = touch_angle(face);
    const double first = fall_time(0, stop);
    const Reference reference = solve_reference(wall_pendulum(face, 1), five_seconds);
    const auto expected = static_cast<std::size_t>((5 / first + 1) / 2);
    CHECK_EQUAL(reference.impacts.size(), expected);
    CHECK_EQUAL(reference.impact_uncertainty_s.size(), expected);
    CHECK_EQUAL(reference.at_rest_from, -1.0);
    for (std::size_t k = 0; k < reference.impacts.size(); ++k) {
      const Impact& impact = reference.impacts[k];
      const double t = first * static_cast<double>(2 * k + 1);
      CHECK_NEAR(impact.t, t, reference.impact_uncertainty_s[k] + 1e-14);  // the closed form rounds as well
      CHECK_NEAR(impact.t, t, 1e-9);                                       // promised; measured 2e-12
      CHECK_NEAR(impact.q1, stop, 1e-14);
      CHECK_NEAR(impact.qd_before, -touch_speed(0, stop), 1e-10);
      CHECK_EQUAL(impact.qd_after, -impact.qd_before);
      CHECK_EQUAL(impact.depth, 0.0);
      CHECK_BETWEEN(reference.impact_uncertainty_s[k], 0.0, 1e-10);
    }
  }
}

// Through impacts of any restitution the bound covers the distance to the closed form (elliptic functions), whose own
// error is 1e-13 rad here.
void check_through_impacts() {
  for (const double face : {0.95, 0.9, 0.7, 0.97, 0.955, 0.0}) {
    for (const double restitution : {1.0, 0.9, 0.5, 0.1, 0.0}) {
      const Scenario scenario = wall_pendulum(face, restitution);
      const Reference reference = solve_reference(scenario, five_seconds_coarsely);
      const ClosedFormPendulum closed_form(scenario, 5);
      const auto exact = [&](std::size_t k, std::size_t) { return closed_form.at(reference.trace.t[k])[0]; };
      CHECK_EQUAL(uncovered(reference, exact, 1e-13), 0);
      if (face != 0.97 || restitution != 1) {  // for ever at the wall, where coarse runs lose sight of it
        CHECK_EQUAL(uncovered(solve_reference(scenario, five_seconds_coarsely, coarse, coarser), exact, 1e-14), 0);
      }
      const std::vector<Impact>& impacts = closed_form.outcome().impacts;
      CHECK_EQUAL(reference.impacts.size(), impacts.size());
      for (std::size_t k = 0; k < std::min(impacts.size(), reference.impacts.size()); ++k) {
        CHECK_NEAR(reference.impacts[k].t, impacts[k].t, reference.impact_uncertainty_s[k] + 1e-13);
        CHECK_NEAR(reference.impacts[k].qd_after, impacts[k].qd_after, 1e-9);
      }
      CHECK_NEAR(reference.at_rest_from, closed_form.outcome().at_rest_from, 1e-9);
    }
  }
}

// Released a hair above the mirror image of the angle of touch, the link touches the wall at 1e-7 to 1e-3 rad/s or only
// grazes it, and the reference may not know which. Its bound holds for both: without the uncertainty it is 1e5 times
// too small.
void check_grazes() {
  for (const double face : {0.93, 0.9, 0.7}) {
    for (const double restitution : {1.0, 0.5, 0.0}) {
      for (const double hair : {-1e-12, 0.0, 1e-14, 1e-13, 5e-13, 1e-12, 2e-12, 1e-10, 1e-8}) {
        const Scenario scenario = wall_pendulum(face, restitution, -pi - touch_angle(face) + hair);
        const ClosedFormPendulum closed_form(scenario, 5);
        const auto exact = [&](std::size_t k, std::size_t) {
          return closed_form.at(five_seconds_coarsely.time(static_cast<long>(k)))[0];
        };
        const Reference reference = solve_reference(scenario, five_seconds_coarsely);
        CHECK_EQUAL(uncovered(reference, exact, 1e-14), 0);
        CHECK_EQUAL(uncovered(solve_reference(scenario, five_seconds_coarsely, coarse, coarser), exact, 1e-14), 0);
        // A slow impact shears errors. If that is left out, what the runs differ by makes the bound 1e5 times too wide.
        if (hair == 1e-8 && restitution == 1) {
          CHECK_BETWEEN(reference.uncertainty_q.back(), 0.0, 1e4 * largest_error(reference, exact));
        }
      }
    }
  }
}

// Weight against the wall and half the speed lost each time: flight k takes twice the fall from where its speed carries
// it.
void check_cascade() {
  const double stop = touch_angle(0.97);
  double speed = touch_speed(0, stop);
  double t = fall_time(0, stop);
  std::vector<double> times{t};
  while (speed / 2 >= rest_speed_rad_s) {
    speed /= 2;
    // speed^2 = 2 k (sin top - sin stop); the difference of the angles keeps its digits, that of the sines would not.
    const double rise = speed * speed / (2 * stiffness);
    const double flight =
        rise > 1e-6 ? 2 * fall_time(std::asin(std::sin(stop) + rise), stop) : 2 * speed / (stiffness * std::cos(stop));
    times.push_back(t += flight);
  }
  const Reference reference = solve_reference(wall_pendulum(0.97, 0.5), five_seconds);
  CHECK_EQUAL(reference.impacts.size(), times.size());
  for (std::size_t k = 0; k < std::min(times.size(), reference.impacts.size()); ++k) {
    // The closed form's flights are good to 1e-6 of 2e-4 s where it changes over to parabolas.
    CHECK_NEAR(reference.impacts[k].t, times[k], 1e-9);
  }
  CHECK_NEAR(reference.at_rest_from, times.back(), 1e-9);
  for (std::size_t k = 1000; k < reference.trace.rows(); ++k) {
    CHECK_NEAR(reference.trace.q[0][k], stop, reference.uncertainty_q[k]);
    CHECK_EQUAL(reference.trace.qd[0][k], 0.0);
    CHECK_EQUAL(reference.trace.contacts[k], 1.0);
    CHECK_BETWEEN(reference.uncertainty_q[k], 0.0, 1e-13);
    CHECK_NEAR(reference.joint_force[0][2][k], 9.81, 1e-12);  // at rest joint and wall carry the weight
  }
}

void check_rest() {
  // Hanging at rest with the wall at its face; released in contact with the weight against the wall.
  for (const double restitution : {1.0, 0.5, 0.0}) {
    for (const auto& [face, q0] : {std::pair{0.95, -pi / 2}, std::pair{0.97, touch_angle(0.97)}}) {
      const Reference reference = solve_reference(wall_pendulum(face, restitution, q0), five_seconds);
      CHECK_EQUAL(reference.at_rest_from, 0.0);
      CHECK_EQUAL(reference.impacts.size(), std::size_t{0});
      CHECK_NEAR(reference.trace.q[0].back(), q0, 1e-12);
    }
  }
  // All speed lost against a wall the weight pulls away from: one touch, then a swing that only grazes the wall.
  for (const double face : {0.9, 0.7, 0.5, 0.0}) {
    const Reference reference = solve_reference(wall_pendulum(face, 0), five_seconds);
    CHECK_EQUAL(reference.impacts.size(), std::size_t{1});
    CHECK_EQUAL(reference.impacts.at(0).qd_after, 0.0);
    CHECK_EQUAL(reference.at_rest_from, -1.0);
    const double deepest = *std::min_element(reference.trace.q[0].begin(), reference.trace.q[0].end());
    CHECK_NEAR(deepest, touch_angle(face), 1e-5);  // a sample lies within 0.5 ms of the turn: 15 / 2 * 0.0005^2 rad
    CHECK(deepest > touch_angle(face) - 1e-12);
  }
  // Without weight a slow link leaves the wall and comes to the other side: 1.62 rad below and above, at 3 and 1.5
  // rad/s.
  Scenario weightless = wall_pendulum(0.9, 0.5, 0, -3);
  weightless.gravity = 0;
  const Reference drifting = solve_reference(weightless, five_seconds);
  CHECK_EQUAL(drifting.impacts.size(), std::size_t{2});
  CHECK_NEAR(drifting.impacts.at(0).t, -touch_angle(0.9) / 3, 1e-12);
  CHECK_NEAR(drifting.impacts.at(1).t, -touch_angle(0.9) * (1 / 3.0 + 2 / 1.5), 1e-12);
  CHECK_EQUAL(drifting.at_rest_from, -1.0);
  CHECK(all_finite(drifting.uncertainty_q));
  // All speed lost against a wall the weight pulls into.
  const Reference stopped = solve_reference(wall_pendulum(0.97, 0), five_seconds);
  CHECK_EQUAL(stopped.impacts.size(), std::size_t{1});
  CHECK_EQUAL(stopped.at_rest_from, stopped.impacts.at(0).t);
}

// Every one of these once was, or might have been, a hang: they must end, with finite values, outside the wall.
void check_ends() {
  constexpr SampleGrid grid{0.01, 1, 501};
  for (const double face : {0.95, 0.9, 0.7, 0.97, 0.955, 0.0, -0.1}) {
    for (const double restitution : {1.0, 0.99, 0.5, 0.1, 0.0}) {
      const double stop = face > -0.01 ? touch_angle(face) : -1.0;
      for (const double q0 : {0.0, stop, stop + 1e-13, stop + 1e-6}) {
        for (const double qd0 : {0.0, -1.0, 1e-3, -1e-6, 1e-7}) {
          const Scenario scenario = wall_pendulum(face, restitution, q0, qd0);
          const bool swarm = restitution == 1 && face > 0.95 && (q0 != 0) && std::fabs(qd0) < 0.01;
          const SampleGrid some = swarm ? SampleGrid{0.001, 1, 11} : grid;  // up to 1e6 hops a second
          const Reference reference = solve_reference(scenario, some);
          CHECK(all_finite(reference.trace.q[0]) && all_finite(reference.trace.qd[0]));
          CHECK(all_finite(reference.uncertainty_q));
          CHECK_EQUAL(reference.impacts.size(), reference.impact_uncertainty_s.size());
          const WallContact wall(*scenario.planar);
          double nearest = 1;
          for (const double q : reference.trace.q[0]) nearest = std::min(nearest, wall.nearest_distance(q));
          CHECK_BETWEEN(nearest, -1e-12, 2.0);  // a graze may go v^2 / 2a in: 1e-13 rad at 1e-6 rad/s
          for (const Impact& impact : reference.impacts) {
            CHECK(std::fabs(impact.qd_after + restitution * impact.qd_before) == 0);
            CHECK(impact.t <= some.time(some.rows - 1));
          }
        }
      }
    }
  }
}

// The method and the reference are the same run where the scenario gives no tolerances.
void check_method() {
  const Scenario scenario = wall_pendulum(0.9, 0.5);
  const Reference reference = solve_reference(scenario, five_seconds);
  const auto [outcome, motion] = test::recorded(make_cvode, scenario, five_seconds);
  CHECK_EQUAL(outcome.impacts.size(), reference.impacts.size());
  CHECK_EQUAL(outcome.impacts.at(3).t, reference.impacts.at(3).t);
  CHECK_EQUAL(motion[5000].q[0], reference.trace.q[0][5000]);

  // A step of CVODE goes beyond the end of the grid; an impact there is not part of the run.
  const SampleGrid short_run{0.001, 1, 481};  // to 0.48 s, 13 ms before the first impact
  CHECK_EQUAL(make_cvode(scenario, short_run)->run({}).impacts.size(), std::size_t{0});
  CHECK_EQUAL(solve_reference(scenario, short_run).impacts.size(), std::size_t{0});
}

void check_errors() {
  CHECK_THROWS(make_cvode(wall_pendulum(0.9, 1, -1.63), five_seconds), UserError, "inside the wall");
  Scenario impossible = wall_pendulum(0.9, 1);
  impossible.rtol = 1e-18;
  impossible.atol = 1e-30;
  CHECK_THROWS(make_cvode(impossible, five_seconds)->run({}), MachineError,
               "CVODE for 'wall_pendulum' stopped at t = ");
  CHECK_THROWS(make_cvode(impossible, five_seconds)->run({}), MachineError,
               " of 5 s: CV_TOO_MUCH_ACC (-2) at rtol 1e-18; try rtol 1e-17");
  // The reference's tolerances are not the user's to change: no advice.
  std::string said;
  try {
    solve_reference(impossible, five_seconds, {1e-18, 1e-30}, coarse);
  } catch (const MachineError& error) {
    said = error.what();
  }
  CHECK(said.ends_with(" s: CV_TOO_MUCH_ACC (-2) at rtol 1e-18"));
}

}  // namespace

int main() {
  check_chains();
  check_terms();
  check_forces();
  check_elastic_impacts();
  check_through_impacts();
  check_grazes();
  check_cascade();
  check_rest();
  check_ends();
  check_method();
  check_errors();
  return odeval::test::verdict();
}
