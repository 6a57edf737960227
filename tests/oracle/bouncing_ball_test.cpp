// The bouncing ball: the closed form against impacts walked through one by one, and ODE against both the law of its own
// step and the closed form.
#include <cmath>

#include "catalogue/paths.hpp"
#include "measure/metrics.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "reference/closed_form/body_motion.hpp"
#include "tests/check.hpp"
#include "tests/oracle/body_reference.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using catalogue::Evaluation;
using catalogue::Evaluator;
using catalogue::find_method;

constexpr double radius = 0.1;

Scenario ball(double height, double rate, double restitution) {
  Scenario scenario;
  scenario.duration_s = 3;
  scenario.ode.cfm = 1e-10;
  Description description;
  description.problem = &test::problem("bouncing_ball");
  description.ground = GroundTable{0, restitution};
  description.bodies = {BodyTable{.shape = BodyShape::sphere,
                                  .mass_kg = 1,
                                  .size_m = {2 * radius, 2 * radius, 2 * radius},
                                  .position_m = {0, 0, radius + height},
                                  .velocity_m_s = {0.3, 0, rate}}};
  put_bodies(scenario, description);
  return scenario;
}

BodyState state_at(const reference::BodyMotion& motion, double t) {
  std::vector<BodyState> states(1);
  motion.at(t, states, {});
  return states[0];
}

struct Walk {
  long double height;
  long double rate;
};

// One impact after the other, in extended precision; nothing of the geometric series.
Walk walked(long double height, long double rate, long double gravity, long double e, long double t) {
  for (int impact = 0; impact < 100000; ++impact) {
    const long double speed = std::sqrt(rate * rate + 2 * gravity * height);
    const long double falls = (rate + speed) / gravity;
    if (t < falls) return {height + t * (rate - gravity * t / 2), rate - gravity * t};
    t -= falls;
    height = 0;
    rate = e * speed;
    if (rate < 1e-12L) return {0, 0};
  }
  return {NAN, NAN};
}

void closed_form() {
  test::Coverage coverage("balls");
  for (const double e : {0.0, 0.3, 0.7, 0.99, 0.999999, 1.0}) {
    for (const auto& [height, rate] : {std::pair{1.0, 0.0}, std::pair{0.5, 2.0}, std::pair{2.0, -3.0}}) {
      const Scenario scenario = ball(height, rate, e);
      const auto motion = reference::make_body_motion(scenario);
      for (double t = 0.0137; t < 20; t += 0.37) {
        const Walk wanted = walked(height, rate, 9.81L, e, t);
        const BodyState state = state_at(*motion, t);
        test::add_position(coverage, scenario, t, 0, {0.3L * t, 0, radius + wanted.height});
        // Where the bounces gather, the walk ends at a rate of 1e-12; before, rates change by g times the time's error.
        CHECK_NEAR(state.velocity[2], static_cast<double>(wanted.rate), 1e-11);
        CHECK(motion->uncertainty(t).position_m < 1e-11);
      }
    }
  }
  coverage.check(0.022);
}

// Without friction no impact changes the spin.
void attitude() {
  test::Coverage coverage("attitudes of balls");
  for (const Vec3& spin : {Vec3{}, Vec3{0.3, -0.2, 0.1}, Vec3{3, -20, 7}}) {
    for (double angle = 0.1; angle < 3; angle += 0.4) {
      Scenario scenario = ball(1, 0, 0.7);
      scenario.mechanism.bodies[0].attitude = Vec3{angle / 3, -angle, angle / 2};
      scenario.mechanism.bodies[0].spin_rad_s = spin;
      for (double t = 0.0137; t < 20; t += 0.37) test::add_turn(coverage, scenario, t, 0);
    }
  }
  coverage.check(0.65);
}

void rest() {
  Scenario scenario = ball(1, 0, 0.7);
  scenario.mechanism.bodies[0].velocity_m_s = {};
  const auto motion = reference::make_body_motion(scenario);
  const double first = std::sqrt(2 / 9.81);
  CHECK_NEAR(motion->at_rest_from(), first * (1 + 2 * 0.7 / 0.3), 1e-14);
  CHECK_EQUAL(state_at(*motion, motion->at_rest_from()).velocity[2], 0.0);
  CHECK_EQUAL(state_at(*motion, 100).position[2], radius);
  const auto impacts = motion->impacts(1.2);
  CHECK_EQUAL(impacts.size(), std::size_t{2});
  CHECK_NEAR(impacts[1].t, first * 2.4, 1e-14);
  CHECK_NEAR(impacts[1].qd_after, 0.49 * 9.81 * first, 1e-14);
  // On a slope it slides on without friction, and never rests.
  Scenario slope = scenario;
  slope.mechanism.obstacles[0].shape = sloping(0.3);
  slope.mechanism.bodies[0].position_m = {0.2 * std::sin(0.3), 0, 0.2 * std::cos(0.3)};
  const auto sliding = reference::make_body_motion(slope);
  CHECK(sliding->at_rest_from() < 0);
  const BodyState late = state_at(*sliding, 10);
  CHECK_NEAR(length(late.velocity), 9.81 * std::sin(0.3) * 10, 1e-12);
}

void refusals() {
  Scenario scenario = ball(-0.01, 0, 0.5);
  CHECK_THROWS(reference::make_body_motion(scenario), UserError, "must be at least 0.1 m above the ground");
  scenario = ball(1, 0, 0.5);
  std::vector<Body>& bodies = scenario.mechanism.bodies;
  bodies.push_back(bodies[0]);
  bodies[1].position_m = {1, 0, 3};
  bodies[1].velocity_m_s = {-0.1, 0, 0};
  CHECK_THROWS(reference::make_body_motion(scenario), UserError, "lets the ball meet that of bodies.0");
  bodies[0].shape = Box{{0.2, 0.2, 0.2}};
  CHECK_THROWS(reference::make_body_motion(scenario), UserError, "must be sphere");
}

// One step of dWorldStep for a ball above level ground: the row v+ + cfm F = c of the contact, F >= 0, with
// c = max(erp depth / h, e |v|) for a ball that approaches (ode-0.16 contact.cpp, step.cpp).
void own_law(std::string_view method, double tolerance) {
  for (const double cfm : {0.0, 1e-10, 1e-5, 1e-3}) {
    for (const double e : {0.0, 0.1, 0.7, 1.0}) {
      Scenario scenario = ball(1, 0, e);
      scenario.ode.cfm = cfm;
      scenario.step_s = 1e-3;
      const double h = scenario.step_s;
      Evaluator evaluator(scenario);
      const Evaluation run = evaluator.evaluate(find_method(method));
      const auto& height = run.trace.bodies[0].position[2];
      const auto& rate = run.trace.bodies[0].velocity[2];
      double worst = 0;
      int touches = 0;
      for (std::size_t k = 0; k + 1 < run.trace.rows(); ++k) {
        const double depth = radius - height[k];
        double after = rate[k] - scenario.gravity * h;
        if (depth >= 0) {
          ++touches;
          double wanted = scenario.ode.erp * depth / h;
          if (-rate[k] > 0) wanted = std::fmax(wanted, -e * rate[k]);
          const double force = std::fmax(0, (wanted - after) / (h / scenario.mechanism.bodies[0].mass_kg + cfm));
          after += h * force / scenario.mechanism.bodies[0].mass_kg;
        }
        worst = std::fmax(worst, std::fabs(after - rate[k + 1]));
        worst = std::fmax(worst, std::fabs(height[k] + h * after - height[k + 1]));
      }
      CHECK(touches >= 3);
      CHECK_NEAR(worst, 0, tolerance);
    }
  }
}

// With no CFM the step after the touch mends ERP of the overlap. The rate that takes stays, less g h a step: a contact
// does not pull, and so throws out what it frees.
void recovery() {
  Scenario scenario = ball(0.0001, -5, 0);  // one free step, then 4.9 mm deep
  scenario.ode.cfm = 0;
  scenario.duration_s = 0.004;
  const double h = scenario.step_s;
  const Evaluation run = Evaluator(scenario).evaluate(find_method("ode-step-double"));
  const auto& height = run.trace.bodies[0].position[2];
  const auto& rate = run.trace.bodies[0].velocity[2];
  CHECK(run.trace.penetration[1] > 0.0049);
  CHECK_NEAR((radius - height[2]) / (radius - height[1]), 1 - scenario.ode.erp, 1e-12);
  CHECK_NEAR(rate[2], scenario.ode.erp * (radius - height[1]) / h, 1e-12);
  CHECK_NEAR(rate[3], rate[2] - scenario.gravity * h, 1e-12);
}

// A surface layer is a depth that no contact mends; a limit of the correcting speed is the rate that takes the rest
// away.
void layer_and_limit() {
  Scenario scenario = ball(0.0001, -5, 0);
  scenario.ode.cfm = 0;
  scenario.duration_s = 0.004;
  scenario.ode.surface_layer = 1e-3;
  const Trace layered = Evaluator(scenario).evaluate(find_method("ode-step-double")).trace;
  const double depth = radius - layered.bodies[0].position[2][1];
  CHECK_NEAR(layered.bodies[0].velocity[2][2],
             scenario.ode.erp * (depth - scenario.ode.surface_layer) / scenario.step_s, 1e-12);
  scenario.ode.max_correcting_vel = 0.1;
  const Trace limited = Evaluator(scenario).evaluate(find_method("ode-step-double")).trace;
  CHECK_NEAR(limited.bodies[0].velocity[2][2], 0.1, 1e-12);
}

// A ball bounces when it comes faster than bounce_vel. At 1 % to either side of the speed of the touch, which is that
// of the step before and known to rounding, it does and does not: without, it leaves at most with ERP of the overlap a
// step, 0.2 of its speed, where it bounces with 0.7.
void least_speed(std::string_view method) {
  Scenario scenario = ball(0.0001, -5, 0.7);
  scenario.duration_s = 0.004;
  const double speed = 5 + scenario.gravity * scenario.step_s;
  const auto leaves = [&](double part) {
    scenario.ode.bounce_vel = part * speed;
    return Evaluator(scenario).evaluate(find_method(method)).trace.bodies[0].velocity[2][2];
  };
  CHECK_NEAR(leaves(0.99), 0.7 * speed, 1e-5);  // CFM, 1e-10 of 1e-3 s/kg, takes 1e-7 of 8.6 m/s
  CHECK(leaves(1.01) < 0.2 * speed);
}

double error(Scenario scenario, double step, std::string_view method, double until) {
  scenario.step_s = step;
  Evaluator evaluator(scenario);
  const Evaluation run = evaluator.evaluate(find_method(method));
  return evaluator.measure(run, until)[quantity::max_error_position].value_or(NAN);
}

// Over an impact the error is of first order, with a part that depends on where in a step the impact falls: the mean
// slope over four doublings tells.
void order() {
  Scenario scenario = ball(1, 0, 0.7);
  scenario.duration_s = 1;
  const double slope =
      std::log2(error(scenario, 4e-3, "ode-step-double", 1) / error(scenario, 2.5e-4, "ode-step-double", 1)) / 4;
  std::printf("order of dWorldStep through an impact: %.3f\n", slope);
  CHECK_BETWEEN(slope, 0.85, 1.15);
  const double accurate = error(scenario, 1e-3, "ode-rk4-double", 1);
  std::printf("accurate step: %.3g m\n", accurate);
  CHECK(accurate < 1e-10);
}

// The file's tolerances know a restitution that is off by 1 %, and a g of 9.8.
void breaks() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  const Scenario whole = read_scenario(find_scenario("bouncing_ball", catalogue::scenario_folder()), {}, names);
  const auto failed = [&](const Scenario& broken) {
    int count = 0;
    Evaluator truth(whole);
    const Evaluation run = Evaluator(broken, truth.reference()).evaluate(find_method("ode-step-double"));
    for (const Tolerance& tolerance : whole.tolerances) {
      if (tolerance.method != "ode-step-double") continue;
      if (judge(tolerance, truth.measure(run, tolerance.until_s)) != Judgement::kept) ++count;
    }
    return count;
  };
  CHECK_EQUAL(failed(whole), 0);
  Scenario broken = whole;
  broken.ode.bounce = 0.707;
  CHECK(failed(broken) > 0);
  broken = whole;
  broken.gravity = 9.8;
  CHECK(failed(broken) > 0);
}

}  // namespace

int main() {
  closed_form();
  attitude();
  rest();
  refusals();
  own_law("ode-step-double", 1e-12);
  own_law("ode-quickstep-double", 1e-9);  // 20 iterations leave 0.3^20 = 3e-11 of an impulse
  recovery();
  layer_and_limit();
  least_speed("ode-step-double");
  least_speed("ode-quickstep-double");
  order();
  breaks();
  return test::verdict();
}
