// Impacts of the stepping methods against the closed form: times, speeds, cascades, rest, and the odd starts.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "model/generate.hpp"
#include "odeval/error.hpp"
#include "reference/closed_form/analytic.hpp"
#include "reference/planar/equations.hpp"
#include "reference/planar/fixed_step.hpp"
#include "reference/planar/ode45.hpp"
#include "reference/planar/wall_bounce.hpp"
#include "reference/planar/wall_contact.hpp"
#include "tests/check.hpp"
#include "tests/planar.hpp"
#include "tests/recorded.hpp"

namespace {

using namespace odeval;
using reference::ClosedFormPendulum;
using std::numbers::pi;

constexpr double duration = 5;
constexpr double h = 1e-3;
constexpr SampleGrid grid{h, 10, 501};
constexpr MakeSimulation every_method[] = {reference::make_analytic, reference::make_rk4, reference::make_euler,
                                           reference::make_symplectic_euler, reference::make_ode45};

Scenario wall_pendulum(double face, double restitution, double q0 = 0, double qd0 = 0) {
  Scenario scenario;
  scenario.name = "wall_pendulum";
  scenario.planar = test::make_planar(lying_frame, {Link{1, 1, 0.1, 0.1}}, {q0}, {qd0}, Wall{face, restitution});
  return scenario;
}

using test::Recorded;

Recorded run(MakeSimulation make, const Scenario& scenario) {
  Recorded result = test::recorded(make, scenario, grid);
  CHECK(!result.outcome.diverged);
  CHECK_EQUAL(result.motion.size(), std::size_t{501});
  return result;
}

double acceleration_at(const Scenario& scenario, double q) {
  std::array<double, 2> rate;
  reference::ChainEquations<double, 1>{scenario}({q, 0}, rate);
  return rate[1];
}

// Every impact and every sample against the closed form.
void check_against_closed_form(MakeSimulation make, const Scenario& scenario, double within) {
  const Recorded tested = run(make, scenario);
  const ClosedFormPendulum truth(scenario, duration);
  const std::vector<Impact>& expected = truth.outcome().impacts;
  const std::vector<Impact>& impacts = tested.outcome.impacts;
  CHECK_EQUAL(impacts.size(), expected.size());
  for (std::size_t k = 0; k < std::min(impacts.size(), expected.size()); ++k) {
    CHECK_NEAR(impacts[k].t, expected[k].t, within);
    CHECK_NEAR(impacts[k].qd_before, expected[k].qd_before, 10 * within);  // the acceleration is up to 15 rad/s^2
    CHECK_EQUAL(impacts[k].q1, expected[k].q1);
    CHECK_EQUAL(impacts[k].qd_after, -scenario.planar->wall->restitution * impacts[k].qd_before);
    CHECK_EQUAL(impacts[k].depth, 0.0);
  }
  for (std::size_t k = 0; k < tested.motion.size(); ++k) {
    CHECK_NEAR(tested.motion[k].q[0], truth.at(grid.time(static_cast<long>(k)))[0], 10 * within);
  }
}

void impacts_are_where_the_closed_form_has_them() {
  for (const double face : {0.95, 0.9, 0.7, 0.05}) {
    for (const double restitution : {1.0, 0.5, 0.0}) {
      const Scenario scenario = wall_pendulum(face, restitution);
      // Largest error in a touch 7.5e-12 s measured at 1 ms, fourth order; an inertia or gravity off by 1e-9 is seen.
      check_against_closed_form(reference::make_rk4, scenario, 2e-11);
      Scenario tight = scenario;
      tight.rtol = 1e-12;
      tight.atol = 1e-14;
      check_against_closed_form(reference::make_ode45, tight, 2e-11);  // measured 3.7e-12
    }
  }
  for (const double restitution : {1.0, 0.5}) {
    // ode45 at MATLAB's tolerance: measured 5.2e-3 s, and 0.028 rad, after five impacts.
    check_against_closed_form(reference::make_ode45, wall_pendulum(0.9, restitution), 1e-2);
  }
}

void no_loss_keeps_the_energy() {
  for (const double face : {0.9, 0.97}) {
    const Recorded rk4 = run(reference::make_rk4, wall_pendulum(face, 1));
    CHECK(rk4.outcome.impacts.size() >= 5);
    // Each impact has the speed of the first: what the method's own dissipation takes in 5 s, 5e-13 measured.
    for (const Impact& impact : rk4.outcome.impacts) {
      CHECK_NEAR(impact.qd_before, rk4.outcome.impacts.front().qd_before, 5e-12);
    }
  }
}

void a_cascade_comes_to_rest() {
  // The face at 0.97 stops the link at q = -0.6435, where its weight leans on the wall.
  const Scenario scenario = wall_pendulum(0.97, 0.5);
  const double angle = reference::free_arc(scenario).low;
  const double weight = -acceleration_at(scenario, angle);
  const ClosedFormPendulum truth(scenario, duration);
  const Outcome& exact = truth.outcome();
  // 4.2 rad/s halved at each impact falls below 1e-7 rad/s at the 26th.
  CHECK_EQUAL(exact.impacts.size(), std::size_t{26});
  CHECK(std::fabs(exact.impacts.back().qd_after) < reference::rest_speed_rad_s);
  CHECK_EQUAL(exact.at_rest_from, exact.impacts.back().t);
  // Small bounces are parabolas: from the 16th on, at v = 6.4e-5 rad/s, the rest takes 2 v / a (1 + e + e^2 + ..) =
  // 2 v / (a (1 - e)) less the same sum for the last bounce, left out. The weight's lever changes by 1e-10 over them.
  const Impact& late = exact.impacts.at(15);
  const double rest = 2 / (weight * (1 - 0.5)) * (late.qd_after - exact.impacts.back().qd_after);
  CHECK_NEAR(exact.at_rest_from - late.t, rest, 1e-14);

  for (const MakeSimulation make : {reference::make_rk4, reference::make_ode45}) {
    Scenario tight = scenario;
    tight.rtol = 1e-12;
    tight.atol = 1e-14;
    const Recorded tested = run(make, tight);
    // The last bounces are 1e-15 rad high, a few bits of q: 6e-10 s measured, of 4e-8 s that they last.
    CHECK_NEAR(tested.outcome.at_rest_from, exact.at_rest_from, 5e-9);
    CHECK_BETWEEN(static_cast<double>(tested.outcome.impacts.size()), 25, 27);
    CHECK_EQUAL(tested.motion[500].q[0], angle);
    CHECK_EQUAL(tested.motion[500].qd[0], 0.0);
    CHECK_EQUAL(tested.motion[99].q[0], angle);  // 0.99 s, rest from 0.982 s
  }
  CHECK_EQUAL(truth.at(duration)[0], angle);
  CHECK_EQUAL(truth.at(duration)[1], 0.0);

  // What fixed_step.hpp says of the two Euler methods. Explicit: for ever within a few a h^2 of the wall, each bounce
  // as fast as a step makes it. Symplectic: at rest up to 0.1 s early, having lost the bounces shorter than a step.
  const Recorded euler = run(reference::make_euler, scenario);
  CHECK(euler.outcome.at_rest_from < 0);
  CHECK_NEAR(euler.motion[500].q[0], angle, 5 * weight * h * h);
  const Recorded symplectic = run(reference::make_symplectic_euler, scenario);
  CHECK_BETWEEN(symplectic.outcome.at_rest_from, exact.at_rest_from - 0.1, exact.at_rest_from);
}

void an_impact_without_rebound() {
  for (const MakeSimulation make : every_method) {
    // Leaning on the wall: one impact, then rest.
    const Scenario leaning = wall_pendulum(0.97, 0);
    const Recorded stopped = run(make, leaning);
    CHECK_EQUAL(stopped.outcome.impacts.size(), std::size_t{1});
    CHECK_EQUAL(stopped.outcome.at_rest_from, stopped.outcome.impacts.at(0).t);
    CHECK_EQUAL(stopped.motion[500].q[0], reference::free_arc(leaning).low);
    // With the weight pulling it off: it swings away as if released there.
    const Scenario pulled = wall_pendulum(0.7, 0);
    const Recorded released = run(make, pulled);
    const Impact& impact = released.outcome.impacts.at(0);
    CHECK_EQUAL(impact.qd_after, 0.0);
    CHECK(released.outcome.at_rest_from < 0);
    const reference::FreePendulum free(pulled, {impact.q1, 0});
    // Until it comes back 1.64 s later: 2e-3 is the error of Euler at 1 ms.
    for (const std::size_t k : {60u, 100u, 150u, 200u}) {
      CHECK_NEAR(released.motion[k].q[0], free.at(grid.time(static_cast<long>(k)) - impact.t)[0], 2e-2);
    }
  }
}

void starts_in_contact() {
  const double leaning = reference::free_arc(wall_pendulum(0.97, 0.5)).low;
  const double pulled = reference::free_arc(wall_pendulum(0.7, 0.5)).low;
  for (const MakeSimulation make : every_method) {
    const Recorded rests = run(make, wall_pendulum(0.97, 0.5, leaning));
    CHECK_EQUAL(rests.outcome.at_rest_from, 0.0);
    CHECK(rests.outcome.impacts.empty());
    CHECK_EQUAL(rests.motion[500].q[0], leaning);

    const Recorded hits = run(make, wall_pendulum(0.7, 0.5, pulled, -2));
    CHECK_EQUAL(hits.outcome.impacts.at(0).t, 0.0);
    CHECK_EQUAL(hits.outcome.impacts.at(0).qd_before, -2.0);
    CHECK_EQUAL(hits.outcome.impacts.at(0).qd_after, 1.0);

    const Recorded leaves = run(make, wall_pendulum(0.7, 0.5, pulled, 2));
    CHECK(leaves.outcome.impacts.empty() || leaves.outcome.impacts.at(0).t > 0.8);  // half a period and more
    const reference::FreePendulum free(wall_pendulum(0.7, 0.5), {pulled, 2});
    CHECK_NEAR(leaves.motion[50].q[0], free.at(0.5)[0], 2e-2);  // as above
  }
  CHECK_THROWS(reference::make_rk4(wall_pendulum(0.9, 1, -2), grid), UserError, "starts inside the wall");
}

void grazing_is_no_impact_to_speak_of() {
  // Released at the mirror image of the angle of touch, the link arrives there with no speed.
  const double touch = reference::free_arc(wall_pendulum(0.7, 1)).low;
  for (const double restitution : {1.0, 0.0}) {
    const Scenario scenario = wall_pendulum(0.7, restitution, -pi - touch);
    const reference::FreePendulum free(scenario, {-pi - touch, 0});
    CHECK(run(reference::make_analytic, scenario).outcome.impacts.empty());
    const Recorded rk4 = run(reference::make_rk4, scenario);
    // A touch that rounding or truncation, 1e-12 rad, makes has a speed of sqrt(2 a 1e-12) = 3e-6 rad/s.
    for (const Impact& impact : rk4.outcome.impacts) CHECK_NEAR(impact.qd_before, 0, 3e-5);
    CHECK_NEAR(rk4.motion[500].q[0], free.at(duration)[0], 1e-5);
    for (const MakeSimulation make : every_method) run(make, scenario);  // ends
  }
}

void bounces_without_end_are_given_up() {
  // 1e-13 rad above the wall without loss: a bounce takes 3e-7 s, so the run would hold 2e7 of them.
  const Scenario scenario = wall_pendulum(0.97, 1, reference::free_arc(wall_pendulum(0.97, 1)).low + 1e-13);
  for (const MakeSimulation make : {reference::make_analytic, reference::make_rk4}) {
    const Outcome outcome = make(scenario, grid)->run({});
    CHECK(outcome.diverged);
    CHECK(outcome.reason.find("gave up after 1000000 impacts") != std::string::npos);
  }
}

}  // namespace

int main() {
  impacts_are_where_the_closed_form_has_them();
  no_loss_keeps_the_energy();
  a_cascade_comes_to_rest();
  an_impact_without_rebound();
  starts_in_contact();
  grazing_is_no_impact_to_speak_of();
  bounces_without_end_are_given_up();
  return odeval::test::verdict();
}
