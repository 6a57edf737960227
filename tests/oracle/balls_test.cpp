// Balls on rods: impacts of two balls with a wall, the sphere that stands for a point, and what breaks the tolerances
// of the scenarios chain, iftomm_pendulum and potra_pendulum.
#include <cmath>
#include <functional>

#include "catalogue/paths.hpp"
#include "measure/metrics.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "reference/planar/ball_wall.hpp"
#include "reference/planar/reference_solution.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using catalogue::Evaluator;
using reference::BallWall;

constexpr double half_turn = 3.14159265358979323846;

Scenario shipped(const std::string& name) {
  Names names;
  names.methods = catalogue::method_names();
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names);
}

double energy(const BallWall& wall, const BallWall::State& y) {
  return wall.equations().kinetic(y) + wall.equations().potential(y);
}

void set_restitution(Scenario& scenario, double restitution) {
  change_planar(scenario, [&](PlanarView& view) { view.wall->restitution = restitution; });
}

// One ball at the wall leaves it with e times its speed; the rates change along M^-1 J' alone, so that a push on the
// ball is all there was: what is lost is (1 - e^2) u^2 / (2 J M^-1 J').
void check_single_impacts() {
  Scenario scenario = test::report_scenario("potra_pendulum", 1, 1e-3);
  set_restitution(scenario, 0.3);
  const BallWall wall(scenario);
  for (const BallWall::State& y : {BallWall::State{-1.2, 0.4, -1.1, 0.3}, BallWall::State{-0.4, -1.9, -2.0, 0.5}}) {
    for (const std::size_t ball : {0U, 1U}) {
      const double u = wall.speed(ball, y);
      if (u >= 0) continue;
      std::array<bool, 2> at_wall{};
      at_wall[ball] = true;
      const BallWall::State after = wall.struck(y, at_wall);
      CHECK_NEAR(wall.speed(ball, after), -0.3 * u, 1e-13);
      CHECK_EQUAL(after[0], y[0]);
      CHECK_EQUAL(after[1], y[1]);
      // J M^-1 J' from the change itself: the impulse is (u+ - u) over it, and changes the energy by p (u + u+) / 2.
      const auto response = [&] {
        Scenario elastic = scenario;
        set_restitution(elastic, 1);
        const BallWall::State back = BallWall(elastic).struck(y, at_wall);
        CHECK_NEAR(energy(wall, back), energy(wall, y), 1e-13 * std::fabs(energy(wall, y)) + 1e-13);
        return back;
      }();
      // Between no change and the elastic one the change of the rates is linear in 1 + e.
      for (std::size_t i = 2; i < 4; ++i) CHECK_NEAR(after[i] - y[i], (response[i] - y[i]) * 1.3 / 2, 1e-12);
      CHECK(energy(wall, after) < energy(wall, y));
    }
  }
}

// Both at once, hanging along the wall: both leave at e times their speeds, or one that the other's impulse takes off
// the wall leaves faster, and energy never grows.
void check_double_impacts() {
  Scenario scenario = test::report_scenario("potra_pendulum", 1, 1e-3);
  const BallWall wall(scenario);
  int shared = 0;
  for (const double rate1 : {-1.0, -0.3, 0.0}) {
    for (const double rate2 : {-2.0, -0.5, 0.5}) {
      const BallWall::State y{-half_turn / 2, 0, rate1, rate2};
      const double u0 = wall.speed(0, y);
      const double u1 = wall.speed(1, y);
      if (u0 >= 0 && u1 >= 0) continue;
      const BallWall::State after = wall.struck(y, {true, true});
      CHECK(wall.speed(0, after) >= -0.1 * std::fmin(u0, 0.0) - 1e-12);
      CHECK(wall.speed(1, after) >= -0.1 * std::fmin(u1, 0.0) - 1e-12);
      CHECK(energy(wall, after) <= energy(wall, y) + 1e-12);
      shared +=
          std::fabs(wall.speed(0, after) + 0.1 * u0) < 1e-12 && std::fabs(wall.speed(1, after) + 0.1 * u1) < 1e-12;
    }
  }
  CHECK(shared > 0);
}

// Through five impacts the bound of a run at loose tolerances covers its distance from the tight one, and so does that
// of each impact's time. Samples between an impact of one run and of the other are of neither motion.
void check_bound_through_impacts() {
  Scenario scenario = shipped("potra_pendulum");
  const SampleGrid grid = sample_grid(scenario);
  const Reference tight = reference::solve_reference(scenario, grid);
  const Reference loose = reference::solve_reference(scenario, grid, {1e-10, 1e-11}, {3.3e-9, 3.3e-10});
  CHECK_EQUAL(tight.impacts.size(), std::size_t{5});
  CHECK_EQUAL(loose.impacts.size(), std::size_t{5});
  double worst = 0;
  for (std::size_t k = 1; k < tight.trace.rows(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double off = std::fabs(loose.trace.q[i][k] - tight.trace.q[i][k]);
      worst = std::max(worst, off / (loose.uncertainty_q[k] + tight.uncertainty_q[k]));
    }
  }
  std::printf("potra: error over bound %.2g, bound at the end %.2g and %.2g rad\n", worst, loose.uncertainty_q.back(),
              tight.uncertainty_q.back());
  CHECK(worst < 1);
  CHECK(worst > 1e-3);
  CHECK(tight.uncertainty_q.back() < 1e-9);
  for (std::size_t i = 0; i < std::min(tight.impacts.size(), loose.impacts.size()); ++i) {
    CHECK_EQUAL(*loose.impacts[i].link, *tight.impacts[i].link);
    CHECK_NEAR(loose.impacts[i].t, tight.impacts[i].t, loose.impact_uncertainty_s[i] + tight.impact_uncertainty_s[i]);
    CHECK_NEAR(tight.impacts[i].qd_after, -0.1 * tight.impacts[i].qd_before, 1e-12);
  }
}

// The accurate step has the same impacts from Cartesian bodies, joints and contacts: nothing in common with the
// reference but the scenario. Fourth order: 5e-11 s at 1 ms. A restitution of 1: the energy stays.
void check_against_accurate_step() {
  Evaluator evaluator(shipped("potra_pendulum"));
  const auto run = evaluator.evaluate(catalogue::find_method("ode-rk4-double"));
  const auto& wanted = evaluator.reference().impacts;
  CHECK_EQUAL(run.outcome.impacts.size(), wanted.size());
  for (std::size_t i = 0; i < std::min(wanted.size(), run.outcome.impacts.size()); ++i) {
    CHECK_NEAR(run.outcome.impacts[i].t, wanted[i].t, 5e-10);
    CHECK_NEAR(run.outcome.impacts[i].qd_before, wanted[i].qd_before, 1e-8);
    CHECK_NEAR(run.outcome.impacts[i].qd_after, wanted[i].qd_after, 1e-8);
    CHECK_EQUAL(*run.outcome.impacts[i].link, *wanted[i].link);
  }
  Scenario elastic = shipped("potra_pendulum");
  set_restitution(elastic, 1);
  const Reference reference = reference::solve_reference(elastic, sample_grid(elastic));
  CHECK(reference.impacts.size() > 3);
  for (std::size_t k = 0; k < reference.trace.rows(); ++k) {
    CHECK_NEAR(reference.trace.kinetic[k] + reference.trace.potential[k],
               reference.trace.kinetic[0] + reference.trace.potential[0], 1e-10);
  }
}

// dWorldStep sees an impact in the first step that overlaps: by no more than the ball moved in the step before.
void check_depths() {
  Evaluator evaluator(shipped("potra_pendulum"));
  const auto run = evaluator.evaluate(catalogue::find_method("ode-step-double"));
  CHECK_EQUAL(run.outcome.impacts.size(), evaluator.reference().impacts.size());
  for (const Impact& impact : run.outcome.impacts) {
    CHECK_BETWEEN(impact.depth, 0, -impact.qd_before * evaluator.grid().step_s);
  }
}

// A wall that a ball's weight presses it against: it comes to rest, which the reference does not follow and says so.
void check_rest_is_refused() {
  Scenario scenario = test::report_scenario("potra_pendulum", 3, 1e-3);
  change_planar(scenario, [](PlanarView& view) { view.wall = Wall{0.4, 0}; });
  CHECK_THROWS(reference::solve_reference(scenario, sample_grid(scenario)), MachineError,
               "comes to rest on the wall, which is not followed");
}

// The sphere of iftomm_pendulum has the point's equation of motion, q'' = -g cos q.
void check_point() {
  const Scenario scenario = shipped("iftomm_pendulum");
  const reference::ChainEquations<double, 1> equations(scenario);
  for (const double q : {0.0, -0.7, -1.5, 2.0}) {
    std::array<double, 2> slope;
    equations({q, 1.3}, slope);
    CHECK_NEAR(slope[1], -9.81 * std::cos(q), 1e-14);
    CHECK_NEAR(equations.kinetic({q, 1.3}), 1.3 * 1.3 / 2, 1e-15);
    CHECK_NEAR(equations.potential({q, 0}), 9.81 * std::sin(q), 1e-14);
  }
}

/// Tolerances of the file that an engine with a change does not keep, beside the reference of the file.
int broken(const std::string& name, const std::function<void(Scenario&)>& change) {
  Evaluator whole(shipped(name));
  Scenario changed = whole.scenario();
  change(changed);
  Evaluator evaluator(changed, whole.reference());
  int failed = 0;
  for (const char* method : {"ode-step-double", "ode-rk4-double"}) {
    const auto run = evaluator.evaluate(catalogue::find_method(method));
    for (const Tolerance& tolerance : whole.scenario().tolerances) {
      if (tolerance.method != method) continue;
      failed += judge(tolerance, evaluator.measure(run, tolerance.until_s)) != Judgement::kept;
    }
  }
  return failed;
}

// What an adapter could get wrong by a little: each is seen by a tolerance, and the unbroken engine by none.
void check_tolerances_can_fail() {
  const auto nothing = [](Scenario&) {};
  const auto gravity = [](Scenario& s) { s.gravity = 9.8; };
  const auto in_view = [](auto change) { return [change](Scenario& s) { change_planar(s, change); }; };
  const auto anchor = in_view([](PlanarView& view) { view.links[0].length_m += 1e-3; });
  const auto inertia = in_view([](PlanarView& view) { view.links[1].width_m *= 1.5; });  // 1.2 % of a box's inertia
  const auto ball = in_view([](PlanarView& view) { view.links[0].width_m *= 1.01; });
  const auto restitution = in_view([](PlanarView& view) { view.wall->restitution *= 1.01; });
  for (const char* name : {"chain", "potra_pendulum"}) {
    CHECK_EQUAL(broken(name, nothing), 0);
    for (const auto& [what, change] : {std::pair{"g 9.8", std::function<void(Scenario&)>(gravity)},
                                       std::pair{"1 mm of an anchor", std::function<void(Scenario&)>(anchor)}}) {
      const int failed = broken(name, change);
      std::printf("%s, %s: %d tolerances fail\n", name, what, failed);
      CHECK(failed > 0);
    }
  }
  const int failed_inertia = broken("chain", inertia);
  const int failed_restitution = broken("potra_pendulum", restitution);
  const int failed_ball = broken("iftomm_pendulum", ball);
  std::printf("1 %% of an inertia: %d, 1 %% of the restitution: %d, 1 %% of a ball's radius: %d\n", failed_inertia,
              failed_restitution, failed_ball);
  CHECK(failed_inertia > 0);
  CHECK(failed_restitution > 0);
  CHECK(failed_ball > 0);
}

}  // namespace

// The acceleration of a ball away from the wall is what its speed changes by along the motion.
void check_pull() {
  const BallWall wall(test::report_scenario("potra_pendulum", 1, 1e-3));
  for (const BallWall::State& y : {BallWall::State{-1.2, 0.4, -1.1, 0.3}, BallWall::State{0.7, -1.9, 2.0, -3.5}}) {
    BallWall::State rate;
    wall.equations()(y, rate);
    for (const std::size_t ball : {0U, 1U}) {
      const auto speed_after = [&](double t) {
        BallWall::State moved = y;
        for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += t * rate[i];
        return wall.speed(ball, moved);
      };
      constexpr double t = 1e-5;  // rounding 1e-16 / t, the cubic term t^2: both about 1e-10
      CHECK_NEAR(wall.pull(ball, y), (speed_after(t) - speed_after(-t)) / (2 * t), 1e-8);
    }
  }
}

int main() {
  check_pull();
  check_single_impacts();
  check_double_impacts();
  check_bound_through_impacts();
  check_against_accurate_step();
  check_depths();
  check_rest_is_refused();
  check_point();
  check_tolerances_can_fail();
  return test::verdict();
}
