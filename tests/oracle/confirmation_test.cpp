// The reference of mechanisms held to a second formulation, and runs and motions that blow up.
#include "catalogue/confirmation.hpp"

#include <algorithm>
#include <string>

#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

/// Two links on hinges that swing in different planes, the outer one thrown.
Scenario arm(double step_s) {
  Scenario scenario;
  scenario.name = scenario.file = "arm";
  scenario.duration_s = 1;
  scenario.step_s = step_s;
  Mechanism& mechanism = scenario.mechanism;
  mechanism.bodies = {
      Body{.shape = Box{{1, 0.1, 0.1}}, .mass_kg = 2, .position_m = {0.5, 0, 0}},
      Body{.shape = Box{{0.8, 0.1, 0.1}},
           .mass_kg = 1,
           .position_m = {1.4, 0, 0},
           .velocity_m_s = {0, 0.8, 0},
           .spin_rad_s = {0, 0, 2}},
  };
  mechanism.joints = {Joint{.kind = HingeJoint{{0, 0, 0}, {0, 1, 0}}, .second = {}, .name = "shoulder"},
                      Joint{.kind = HingeJoint{{1, 0, 0}, {0, 0, 1}}, .first = 1, .second = 0, .name = "elbow"}};
  return scenario;
}

Reference solved(const Scenario& scenario) {
  return reference::provider_for(scenario).solve(scenario, sample_grid(scenario));
}

bool says(const Reference& reference, const char* what) { return reference.origin.find(what) != std::string::npos; }

// What agrees is left as it is, at a step of 5 ms as well, which the order needs to be extrapolated over.
void what_agrees() {
  for (const double step_s : {1e-3, 5e-3}) {
    Scenario scenario = arm(step_s);
    // Looked at once a step of the scenario, whatever the accurate step's own steps are.
    scenario.mechanism.joints[1].controllers = {{.kp = 5, .kd = 0.2, .target = {.constant = 0.5}, .sampled = true}};
    const Reference alone = solved(scenario);
    Reference reference = alone;
    catalogue::confirm(reference, scenario, sample_grid(scenario));
    std::printf("%s\n", reference.origin.c_str());
    CHECK(says(reference, "; confirmed by a second formulation"));
    CHECK(reference.uncertainty_position == alone.uncertainty_position);
    CHECK(reference.uncertainty_turn == alone.uncertainty_turn);
    // The evaluator hands out the confirmed one.
    CHECK_EQUAL(catalogue::Evaluator(scenario).reference().origin, reference.origin);
  }
}

// A reference that is wrong by more than it states has the difference as its uncertainty, where it is wrong.
void what_differs() {
  const Scenario scenario = arm(1e-3);
  Reference reference = solved(scenario);
  const double stated = reference.uncertainty_position[900];
  constexpr double wrong_m = 1e-7;
  for (std::size_t k = 500; k < reference.trace.rows(); ++k) reference.trace.bodies[1].position[2][k] += wrong_m;
  const Reference before = reference;
  catalogue::confirm(reference, scenario, sample_grid(scenario));
  CHECK(says(reference, "; differs from a second formulation"));
  CHECK(stated < wrong_m / 10);
  CHECK_NEAR(reference.uncertainty_position[900], wrong_m, 2 * stated);
  CHECK_EQUAL(reference.uncertainty_position[400], before.uncertainty_position[400]);
  CHECK(reference.uncertainty_turn == before.uncertainty_turn);
}

void what_cannot_be_confirmed() {
  Scenario scenario = arm(1e-3);
  Reference reference = solved(scenario);
  const Reference before = reference;
  const auto unchanged = [&](const char* why) {
    CHECK(says(reference, why));
    CHECK(reference.uncertainty_position == before.uncertainty_position);
    reference = before;
  };
  scenario.mechanism.joints[0].opening_m = {1e-3, 0, 0};
  catalogue::confirm(reference, scenario, sample_grid(scenario));
  unchanged("; not confirmed by a second formulation: the accurate step can not do joints that start open");
  scenario = arm(1e-3);
  scenario.duration_s = 400;  // two runs of two bodies: 2.4e6 steps of one
  catalogue::confirm(reference, scenario, sample_grid(scenario));
  unchanged("; not confirmed by a second formulation: two runs of it take 2.4e+06 steps of a body, more than 2e+06");
}

// A spring on the shoulder that ODE's explicit push makes unstable: h^2 k / m is 7.5 where 4 is the limit. The bar
// itself swings on, and so does the reference; a run that has 1e3 times its energy or more is no run that is `ok`.
void a_run_that_explodes() {
  Scenario scenario = arm(1e-3);
  scenario.duration_s = 0.1;
  scenario.mechanism.bodies.resize(1);
  scenario.mechanism.joints.resize(1);
  JointSpring spring{.stiffness = 5e6, .rest = 0.1};
  const auto run = [&] {
    scenario.mechanism.joints[0].springs = {spring};
    return catalogue::Evaluator(scenario).evaluate(catalogue::find_method("ode-step-double")).outcome;
  };
  const Outcome exploded = run();
  CHECK(exploded.diverged);
  CHECK(exploded.reason.find("exploded: from t = 0.0") == 0);
  // Half of the limit: a wrong motion, of the true one's size.
  spring.stiffness = 1.3e6;
  CHECK(!run().diverged);
}

// What no method with that step could follow is told, and not followed for hours.
void a_motion_that_explodes() {
  Scenario scenario = arm(1e-3);
  scenario.mechanism.joints[1].springs = {{.stiffness = 1e10, .rest = 0.1}};
  CHECK_THROWS(solved(scenario), UserError, "arm: the motion is too fast for its step: the reference has taken 2");
  CHECK_THROWS(solved(scenario), UserError, "of joint 'elbow' are too stiff");
  scenario.mechanism.joints[1].springs.clear();
  scenario.mechanism.joints[0].controllers = {{.kp = 1e7, .kd = 1e4, .target = {.constant = 0.1}, .sampled = true}};
  CHECK_THROWS(solved(scenario), UserError, "of joint 'shoulder' are too stiff");
}

}  // namespace

int main() {
  what_agrees();
  what_differs();
  what_cannot_be_confirmed();
  a_run_that_explodes();
  a_motion_that_explodes();
  return test::verdict();
}
