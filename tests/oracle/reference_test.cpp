// The reference where no certified file exists: chains nobody listed, against quad precision; impacts, against an
// energy integral; every way a link and a wall can come to terms.
#include "reference/reference_solution.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "odeval/error.hpp"
#include "reference/analytic.hpp"
#include "reference/cvode.hpp"
#include "reference/quad.hpp"
#include "reference/wall_contact.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using std::numbers::pi;

bool all_finite(const Column& column) {
  return std::all_of(column.begin(), column.end(), [](double value) { return std::isfinite(value); });
}

// --- chains ---

Scenario random_chain(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Scenario scenario;
  scenario.name = "random";
  const std::size_t links = random() % 4 == 0 ? 1 : 2;
  scenario.problem = &problems[links - 1];
  scenario.duration_s = 5;
  scenario.gravity = between(1, 15);
  for (std::size_t i = 0; i < links; ++i) {
    scenario.links.push_back({between(0.3, 3), between(0.4, 2), between(0.02, 0.4), 0.1});
    scenario.q0.push_back(between(-3, 3));
    scenario.qd0.push_back(between(-3, 3));
  }
  return scenario;
}

void check_chains() {
  std::mt19937 random(20);
  constexpr SampleGrid grid{0.05, 1, 101};
  for (int chain = 0; chain < 10; ++chain) {
    const Scenario scenario = random_chain(random);
    const QuadRun truth = solve_quad(scenario, grid);
    CHECK_BETWEEN(truth.largest_difference, 0.0, quad_target_rad);
    const Reference reference = solve_reference(scenario, grid);
    int uncovered = 0;
    double largest = 0;
    for (std::size_t k = 0; k < truth.rows.size(); ++k) {
      for (std::size_t i = 0; i < scenario.links.size(); ++i) {
        const double off = std::fabs(static_cast<double>(truth.rows[k][i] - reference.trace.q[i][k]));
        largest = std::max(largest, off);
        if (!(off <= reference.uncertainty_q[k])) ++uncovered;
      }
    }
    CHECK_EQUAL(uncovered, 0);
    // Promised for parameters nobody listed. Measured on 60 chains: 6e-9 at most, 1e-10 usually.
    CHECK_BETWEEN(largest, 0.0, 1e-7);
    // At most 5300 times too wide (one of 60 chains whose first second looks wilder than its rest); not without
    // meaning.
    CHECK_BETWEEN(reference.uncertainty_q.back(), largest, 1e5 * largest + 1e-12);
  }
}

// --- joint forces ---

// Force of a joint = rate of change of the momentum of all links from it on, plus their weight. Momentum from q and qd;
// its central difference is off by h^2/6 times its third derivative: measured 0.12 mN at 0.2 ms, of forces of 15 to 60
// N.
void check_forces() {
  Scenario scenario;
  scenario.name = "forces";
  scenario.problem = &problems[1];
  scenario.duration_s = 2;
  scenario.links = {{1.0, 1.0, 0.1, 0.1}, {0.5, 0.8, 0.2, 0.1}};
  scenario.q0 = {0.7, -0.8};
  scenario.qd0 = {0.3, 1.0};
  const Reference reference = solve_reference(scenario, {0.0002, 1, 10001});
  const PlanarFrame& frame = scenario.problem->frame;
  const auto momentum = [&](std::size_t k, std::size_t first, const Vec3& along) {
    double angle = 0, rate = 0, near = 0, sum = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      angle += reference.trace.q[i][k];
      rate += reference.trace.qd[i][k];
      const Vec3 normal = cross(frame.axis(), {frame.horizontal[0] * std::cos(angle) + frame.up[0] * std::sin(angle),
                                               frame.horizontal[1] * std::cos(angle) + frame.up[1] * std::sin(angle),
                                               frame.horizontal[2] * std::cos(angle) + frame.up[2] * std::sin(angle)});
      const double speed = scenario.links[i].length_m * rate * dot(normal, along);
      if (i >= first) sum += scenario.links[i].mass_kg * (near + speed / 2);
      near += speed;
    }
    return sum;
  };
  double largest = 0;
  for (std::size_t k = 1; k + 1 < reference.trace.rows(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      double weight = 0;
      for (std::size_t j = i; j < 2; ++j) weight += scenario.links[j].mass_kg * scenario.gravity;
      for (const auto& [along, held] : {std::pair{frame.horizontal, 0.0}, std::pair{frame.up, weight}}) {
        const double wanted = (momentum(k + 1, i, along) - momentum(k - 1, i, along)) / 0.0004 + held;
        double force = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) force += along[axis] * reference.joint_force[i][axis][k];
        largest = std::max(largest, std::fabs(force - wanted));
      }
      CHECK_NEAR(reference.joint_force[i][0][k], 0.0, 1e-12);  // nothing across the plane (x in this problem)
    }
  }
  CHECK_BETWEEN(largest, 0.0, 5e-4);
}

// --- the wall ---

Scenario wall_pendulum(double face, double restitution, double q0 = 0, double qd0 = 0) {
  Scenario scenario;
  scenario.name = "wall_pendulum";
  scenario.problem = &problems[2];
  scenario.duration_s = 5;
  scenario.links = {{1, 1, 0.1, 0.1}};
  scenario.wall = Wall{face, restitution};
  scenario.q0 = {q0};
  scenario.qd0 = {qd0};
  return scenario;
}

constexpr SampleGrid five_seconds{0.001, 1, 5001};

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
      const Reference reference = solve_reference(scenario, five_seconds);
      const ClosedFormPendulum closed_form(scenario, 5);
      int uncovered = 0;
      for (std::size_t k = 0; k < reference.trace.rows(); ++k) {
        const double off = std::fabs(reference.trace.q[0][k] - closed_form.at(reference.trace.t[k])[0]);
        if (!(off <= reference.uncertainty_q[k] + 1e-13)) ++uncovered;
      }
      CHECK_EQUAL(uncovered, 0);
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
          const WallContact wall(scenario);
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
  Rows rows(2, 5001);
  const Outcome outcome = make_cvode(scenario, five_seconds)->run(&rows);
  CHECK_EQUAL(outcome.impacts.size(), reference.impacts.size());
  CHECK_EQUAL(outcome.impacts.at(3).t, reference.impacts.at(3).t);
  CHECK_EQUAL(rows.row(5000)[0], reference.trace.q[0][5000]);

  // A step of CVODE goes beyond the end of the grid; an impact there is not part of the run.
  const SampleGrid short_run{0.001, 1, 481};  // to 0.48 s, 13 ms before the first impact
  CHECK_EQUAL(make_cvode(scenario, short_run)->run(nullptr).impacts.size(), std::size_t{0});
  CHECK_EQUAL(solve_reference(scenario, short_run).impacts.size(), std::size_t{0});
}

void check_errors() {
  CHECK_THROWS(make_cvode(wall_pendulum(0.9, 1, -1.63), five_seconds), UserError, "inside the wall");
  Scenario impossible = wall_pendulum(0.9, 1);
  impossible.rtol = 1e-18;
  impossible.atol = 1e-30;
  CHECK_THROWS(make_cvode(impossible, five_seconds)->run(nullptr), MachineError,
               "reference for 'wall_pendulum' stopped at t = ");
  CHECK_THROWS(make_cvode(impossible, five_seconds)->run(nullptr), MachineError,
               " of 5 s: CVODE CV_TOO_MUCH_ACC (-2) at rtol 1e-18; try rtol 1e-17");
}

}  // namespace

int main() {
  check_chains();
  check_forces();
  check_elastic_impacts();
  check_through_impacts();
  check_cascade();
  check_rest();
  check_ends();
  check_method();
  check_errors();
  return odeval::test::verdict();
}
