// The sliding box: the closed form against the equations integrated step by step, and ODE against both the law of its
// own step and the closed form.
#include <cmath>
#include <numbers>

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
using std::numbers::pi;

Names names() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return names;
}

Scenario slide(const std::vector<Override>& changes = {}) {
  return read_scenario(find_scenario("friction_slide", catalogue::scenario_folder()), changes, names());
}

Friction& friction_of(Scenario& scenario) { return scenario.mechanism.contacts[0].friction.value(); }

/// Along the ground: u downhill, w across.
struct Slide {
  long double x = 0, y = 0, u = 0, w = 0;
};

// Classical Runge-Kutta on u' = pull - hold u / v, w' = -hold w / v, which is smooth until it stops.
Slide integrated(Slide now, long double pull, long double hold, long double t, int steps) {
  const long double h = t / steps;
  const auto slope = [&](const Slide& s) {
    const long double v = std::hypot(s.u, s.w);
    return Slide{s.u, s.w, pull - hold * s.u / v, -hold * s.w / v};
  };
  const auto moved = [](const Slide& s, const Slide& d, long double f) {
    return Slide{s.x + f * d.x, s.y + f * d.y, s.u + f * d.u, s.w + f * d.w};
  };
  for (int i = 0; i < steps; ++i) {
    const Slide a = slope(now);
    const Slide b = slope(moved(now, a, h / 2));
    const Slide c = slope(moved(now, b, h / 2));
    const Slide d = slope(moved(now, c, h));
    now = moved(moved(moved(moved(now, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
  }
  return now;
}

void closed_form() {
  test::Coverage coverage("a sliding box");
  for (const double slope : {0.0, 0.2, -0.2, 0.5}) {
    for (const double friction : {0.0, 0.1, std::tan(0.2) / 2, std::tan(0.2), 0.3, 0.5}) {
      for (const double direction : {0.0, 0.4, pi / 2, 2.5, pi}) {
        Scenario scenario = slide({{"ground.slope", std::to_string(slope), ""}});
        friction_of(scenario).limit = friction;
        const Vec3 normal = sloping(slope).normal;
        const Vec3 downhill{normal[2], 0, -normal[0]};
        const double u = 2 * std::cos(direction);
        const double w = direction == pi ? 0 : 2 * std::sin(direction);
        scenario.mechanism.bodies[0].velocity_m_s = {u * downhill[0], w, u * downhill[2]};
        const auto motion = reference::make_body_motion(scenario);
        const long double angle = slope;
        const long double pull = scenario.gravity * std::sin(angle);
        const long double hold = friction * scenario.gravity * std::cos(angle);
        for (const double t : {0.05, 0.2, 0.4}) {
          const bool straight = w == 0 && std::fabs(u) < (hold - pull * std::copysign(1, u)) * t;
          if (straight || (motion->at_rest_from() >= 0 && t > 0.9 * motion->at_rest_from())) continue;
          const Slide wanted = integrated({0, 0, u, w}, pull, hold, t, 4000);
          std::vector<BodyState> states(1);
          motion->at(t, states, {});
          const BodyState& state = states[0];
          const double rate = dot(downhill, state.velocity);
          const Vec3& from = scenario.mechanism.bodies[0].position_m;
          test::add_position(coverage, scenario, t, 0,
                             {from[0] + wanted.x * std::cos(angle), wanted.y, from[2] - wanted.x * std::sin(angle)});
          CHECK_NEAR(rate, static_cast<double>(wanted.u), 1e-11);
          CHECK_NEAR(state.velocity[1], static_cast<double>(wanted.w), 1e-11);
        }
      }
    }
  }
  coverage.check(0.063);
}

// A box keeps the attitude that it was given.
void attitude() {
  test::Coverage coverage("attitudes of a sliding box");
  for (double angle = 0.1; angle < 3; angle += 0.1) {
    Scenario scenario = slide();
    scenario.mechanism.bodies[0].attitude = Vec3{0, 0, angle};
    for (const double t : {0.05, 2.0}) test::add_turn(coverage, scenario, t, 0);
  }
  coverage.check(0.5);
}

void stopping() {
  const auto level = reference::make_body_motion(slide());
  CHECK_NEAR(level->at_rest_from(), 2 / (0.3 * 9.81), 1e-15);
  std::vector<BodyState> states(1);
  level->at(9, states, {});
  CHECK_NEAR(states[0].position[0], 4 / (2 * 0.3 * 9.81), 1e-15);
  // Obliquely over a slope that holds: time of the closed form, (A / (k - 1) + B / (k + 1)) / 2g, against its motion.
  Scenario oblique = slide({{"ground.slope", "0.2", ""}, {"bodies.0.velocity", "[1.0, 1.0, 0.0]", ""}});
  const auto motion = reference::make_body_motion(oblique);
  motion->at(motion->at_rest_from() * (1 - 1e-9), states, {});
  CHECK_BETWEEN(length(states[0].velocity), 0, 1e-7);
  CHECK(length(states[0].velocity) > 0);
}

// A force that does not depend on the weight stops a light box sooner: v m / F.
void constant_force() {
  for (const double mass : {2.0, 5.0}) {
    Scenario scenario = slide({{"ground.friction_model", "\"constant\"", ""}});
    friction_of(scenario).limit = 12;
    scenario.mechanism.bodies[0].mass_kg = mass;
    CHECK_NEAR(reference::make_body_motion(scenario)->at_rest_from(), 2 * mass / 12, 1e-15);
  }
}

void refusals() {
  CHECK_THROWS(slide({{"ground.friction", "-0.1", ""}}), UserError, "ground.friction must be a number from 0 to");
  const auto refused = [](const std::vector<Override>& changes, const char* why) {
    CHECK_THROWS(reference::make_body_motion(slide(changes)), UserError, why);
  };
  refused({{"bodies.0.velocity", "[1.0, 0.0, 0.1]", ""}}, "bodies.0.velocity must lie in the ground");
  refused({{"bodies.0.spin", "[0.0, 0.0, 1.0]", ""}}, "bodies.0.spin must be 0");
  refused({{"bodies.0.turn", "[0.1, 0.0, 0.0]", ""}}, "bodies.0.turn must lay the box flat");
  refused({{"bodies.0.position", "[0.0, 0.0, 0.06]", ""}}, "bodies.0.position must have the centre 0.05 m above");
  refused({{"bodies.0.size", "[0.02, 0.4, 0.1]", ""}}, "could tip the box; this one stays flat up to 0.2");
}

struct Stop {
  double way = 0;     // m, as the crow flies
  double time = 0;    // s
  double turned = 0;  // rad, of the way against the start's direction
};

Stop stop(Scenario scenario, double direction, std::string_view method) {
  scenario.mechanism.bodies[0].velocity_m_s = {2 * std::cos(direction), 2 * std::sin(direction), 0};
  Evaluator evaluator(scenario);
  const Evaluation run = evaluator.evaluate(find_method(method));
  const auto& position = run.trace.bodies[0].position;
  const double x = position[0].back() - position[0].front();
  const double y = position[1].back() - position[1].front();
  return {std::hypot(x, y), evaluator.measure(run, scenario.duration_s)[quantity::rest_time].value_or(NAN),
          std::atan2(y, x) - direction};
}

// A step takes mu g h from the speed, once the start has settled: normal forces of frictionless contacts add up to the
// weight, and the limits that they set stay (dWorldStep). Without the file's CFM of 1e-5, whose give leaves 9e-12.
void own_law() {
  for (const char* model : {"pyramid", "constant"}) {
    Scenario scenario = slide({{"ground.friction_model", std::string("\"") + model + "\"", ""}});
    Friction& friction = friction_of(scenario);
    if (friction.model == FrictionModel::constant) friction.limit = 0.3 * 2 * 9.81;
    scenario.duration_s = 0.5;
    scenario.ode.cfm = 1e-10;
    const Evaluation run = Evaluator(scenario).evaluate(find_method("ode-step-double"));
    const auto& rate = run.trace.bodies[0].velocity[0];
    double worst = 0;
    for (std::size_t k = 350; k + 1 < run.trace.rows(); ++k) {
      worst = std::fmax(worst, std::fabs((rate[k] - rate[k + 1]) / (0.3 * 9.81 * scenario.step_s) - 1));
    }
    std::printf("%s: deceleration off by %.3g\n", model, worst);
    CHECK_NEAR(worst, 0, 1e-12);
  }
}

void order() {
  const auto error = [](double step) {
    Scenario scenario = slide();
    scenario.step_s = step;
    Evaluator evaluator(scenario);
    const Evaluation run = evaluator.evaluate(find_method("ode-step-double"));
    return evaluator.measure(run, scenario.duration_s)[quantity::max_error_position].value_or(NAN);
  };
  const double coarse = error(2e-3);
  const double fine = error(2.5e-4);
  std::printf("stopping way: %.6g m at 2 ms, %.6g m at 0.25 ms\n", coarse, fine);
  CHECK_BETWEEN(std::log2(coarse / fine) / 3, 0.9, 1.1);
}

// Held on a slope just below the angle of friction, sliding just above.
void threshold() {
  for (const char* method : {"ode-step-double", "ode-quickstep-double", "ode-step-single", "ode-quickstep-single"}) {
    if (!test::in_this_build(method)) continue;
    const auto way = [&](double part) {
      Scenario scenario = slide(
          {{"ground.slope", std::to_string(std::atan(0.3 * part)), ""}, {"bodies.0.velocity", "[0.0, 0.0, 0.0]", ""}});
      Evaluator evaluator(scenario);
      const Evaluation run = evaluator.evaluate(find_method(method));
      const auto& p = run.trace.bodies[0].position;
      return std::hypot(p[0].back() - p[0].front(), p[2].back() - p[2].front());
    };
    const double held = way(0.99);
    const double slides = way(1.01);
    std::printf("%s: %.3g m held, %.3g m sliding\n", method, held, slides);
    CHECK(held < 2e-3);
    // pull - hold is 1 % of the friction: 9.81 0.003 cos a t^2 / 2 = 0.0317 m in 1.5 s
    CHECK_BETWEEN(slides, 0.029, 0.035);
  }
}

// Two rows that are both at their limit: square root of two along the diagonal; turned into the slide, one.
void pyramid() {
  for (const char* method : {"ode-step-double", "ode-quickstep-double"}) {
    Scenario scenario = slide();
    const Stop straight = stop(scenario, 0, method);
    const Stop diagonal = stop(scenario, pi / 4, method);
    const Stop between = stop(scenario, pi / 8, method);
    scenario.ode.friction_axes = FrictionAxes::sliding;
    const Stop mended = stop(scenario, pi / 4, method);
    std::printf("%s: way %.6g straight, %.6g diagonal, %.6g with axes along the slide; turned %.3g at 22.5 degrees\n",
                method, straight.way, diagonal.way, mended.way, between.turned);
    CHECK_NEAR(straight.way / diagonal.way, std::sqrt(2), 2e-3);
    CHECK_NEAR(mended.way / straight.way, 1, 1e-3);
    CHECK_BETWEEN(std::fabs(between.turned), 0.05, 0.3);
  }
}

// The file's tolerances know 1 % of friction, a g of 9.8 and, where friction is a force, 1 % of mass.
void breaks() {
  const Scenario whole = slide();
  Evaluator truth(whole);
  const auto failed = [&](const Scenario& broken) {
    int count = 0;
    const Evaluation run = Evaluator(broken, truth.reference()).evaluate(find_method("ode-step-double"));
    for (const Tolerance& tolerance : whole.tolerances) {
      if (tolerance.method != "ode-step-double") continue;
      if (judge(tolerance, truth.measure(run, tolerance.until_s)) != Judgement::kept) ++count;
    }
    return count;
  };
  CHECK_EQUAL(failed(whole), 0);
  Scenario broken = whole;
  friction_of(broken).limit *= 1.01;
  CHECK(failed(broken) > 0);
  broken = whole;
  broken.gravity = 9.8;
  CHECK(failed(broken) > 0);
  broken = whole;
  friction_of(broken) = {0.3 * 2 * 9.81, FrictionModel::constant};
  CHECK_EQUAL(failed(broken), 0);
  broken.mechanism.bodies[0].mass_kg *= 1.01;
  CHECK(failed(broken) > 0);
}

// What friction holds creeps: the row of a contact is J v + CFM f = 0, and four contacts share m g sin(slope). So it
// goes downhill at CFM m g sin(slope) / 4, whatever the step; after 1.5 s nothing is left of how it settled.
void creep() {
  for (const char* cfm : {"1e-5", "1e-4"}) {
    const Scenario scenario =
        slide({{"ground.slope", "0.2", ""}, {"bodies.0.velocity", "[0.0, 0.0, 0.0]", ""}, {"ode.cfm", cfm, ""}});
    const Trace trace = Evaluator(scenario).evaluate(find_method("ode-step-double")).trace;
    const double rate = std::hypot(trace.bodies[0].velocity[0].back(), trace.bodies[0].velocity[2].back());
    const double law = scenario.ode.cfm * scenario.mechanism.bodies[0].mass_kg * scenario.gravity * std::sin(0.2) / 4;
    CHECK_NEAR(rate / law, 1, 1e-6);
  }
}

}  // namespace

int main() {
  closed_form();
  attitude();
  stopping();
  constant_force();
  refusals();
  own_law();
  order();
  threshold();
  creep();
  pyramid();
  breaks();
  return test::verdict();
}
