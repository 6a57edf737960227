// Bodies pulled out of a joint: ODE against the law of its step, to rounding, and against the damped oscillator that
// the law leads to, to first order.
#include <cmath>
#include <complex>
#include <numbers>

#include "measure/order.hpp"
#include "odeval/error.hpp"
#include "reference/closed_form/damped_oscillator.hpp"
#include "tests/check.hpp"
#include "tests/oracle/body_reference.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using reference::DampedOscillator;
using reference::Deflection;
using reference::StepLaw;

const JointKind ball = BallJoint{};
const JointKind hinge = HingeJoint{{}, {0.6, 0, 0.8}};

/// A cube whose centre is the joint's place, at the origin so that a gap keeps all its digits.
Scenario cube(const JointKind& kind, double gravity) {
  Scenario scenario;
  scenario.name = "cube";
  scenario.step_s = 1e-3;
  scenario.duration_s = 0.5;
  scenario.gravity = gravity;
  const Vec3 opening{0.05, -0.02, 0.03};
  scenario.mechanism.joints = {Joint{.kind = kind, .second = {}, .opening_m = opening}};
  scenario.mechanism.bodies = {
      Body{.shape = Box{{0.1, 0.2, 0.3}}, .mass_kg = 2, .position_m = opening, .velocity_m_s = {0.1, 0, -0.2}}};
  return scenario;
}

/// Two sticks end to end along z, pulled apart there: the report's Fig. 3.2.
Scenario sticks(double gravity) {
  Scenario scenario = cube(hinge, gravity);
  const Shape stick = Box{{0.1, 0.1, 1}};
  scenario.mechanism.joints = {Joint{.kind = HingeJoint{{}, {0, 1, 0}}, .second = 1, .opening_m = {0, 0, 0.02}}};
  scenario.mechanism.bodies = {Body{.shape = stick, .mass_kg = 1, .position_m = {0, 0, 0.52}},
                               Body{.shape = stick, .mass_kg = 3, .position_m = {0, 0, -0.5}}};
  return scenario;
}

catalogue::Evaluation run_of(const Scenario& scenario, const char* method = "ode-step-double") {
  return catalogue::Evaluator(scenario).evaluate(catalogue::find_method(method));
}

/// The largest difference of the first body from the law, m over the largest displacement.
double off_the_law(const Scenario& scenario, const catalogue::Evaluation& run) {
  const Softness softness = scenario.ode.softness(scenario.step_s);
  const Body& body = scenario.mechanism.bodies[0];
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const StepLaw law{body.mass_kg, softness.erp, softness.cfm, axis == 2 ? scenario.gravity : 0, scenario.step_s};
    Deflection now{body.position_m[axis], body.velocity_m_s[axis]};
    for (std::size_t k = 0; k < run.trace.rows(); ++k, now = law.next(now)) {
      largest = std::max(largest, std::fabs(run.trace.bodies[0].position[axis][k] - now.x));
    }
  }
  return largest / 0.05;
}

// Both kinds of joint, gravity off and on, any softness: the law, to 1e-12.
void discrete_law() {
  for (const JointKind& kind : {ball, hinge}) {
    for (const double gravity : {0.0, 9.81}) {
      Scenario scenario = cube(kind, gravity);
      for (const Softness softness : {Softness{0.2, 0}, Softness{0.8, 0}, Softness{1, 0}, Softness{0.2, 1e-5},
                                      Softness{0.2, 1e-2}, Softness{0.05, 0.3}}) {
        scenario.ode.erp = softness.erp;
        scenario.ode.cfm = softness.cfm;
        const auto run = run_of(scenario);
        CHECK_BETWEEN(off_the_law(scenario, run), 0, 1e-12);
        CHECK(std::fabs(run.trace.bodies[0].position[0].back() - 0.05) > 1e-3);  // something moved
        if (softness.cfm > 0) continue;
        // A step rounds what gravity adds and the joint takes away again: 1e-21 m, of a gap that must not be as small.
        for (std::size_t k = 1; k < run.trace.rows() && run.trace.gap[k - 1] > 1e-8; ++k) {
          CHECK_NEAR(run.trace.gap[k] / run.trace.gap[k - 1], 1 - softness.erp, 1e-12);
        }
      }
      scenario.ode.spring = Spring{150, 4};
      CHECK_BETWEEN(off_the_law(scenario, run_of(scenario)), 0, 1e-12);
    }
  }
}

// What the law says of itself. A spring's law is implicit Euler: x = c1 z1^n + c2 z2^n with z = 1 / (1 - h s), s the
// oscillator's own exponents.
void law_in_closed_form() {
  const double m = 2;
  const Spring spring{150, 4};
  const double h = 1e-3;
  const Softness softness = softness_of(spring, h);
  const StepLaw law{m, softness.erp, softness.cfm, 0, h};
  using Complex = std::complex<double>;
  const Complex root = std::sqrt(Complex(spring.kd_Ns_m * spring.kd_Ns_m - 4 * m * spring.kp_N_m));
  const Complex z1 = 1.0 / (1.0 - h * (-spring.kd_Ns_m + root) / (2 * m));
  const Complex z2 = 1.0 / (1.0 - h * (-spring.kd_Ns_m - root) / (2 * m));
  Deflection now{0.05, 0.1};
  const double before = now.x - h * now.v;  // where the velocity came from
  const Complex c1 = (now.x - before * z2) / (1.0 - z2 / z1);
  const Complex c2 = now.x - c1;
  for (int n = 0; n <= 1000; ++n, now = law.next(now)) {
    CHECK_NEAR((c1 * std::pow(z1, n) + c2 * std::pow(z2, n)).real(), now.x, 1e-13);
  }
}

void conversion() {
  for (const double h : {1e-4, 1e-3, 0.1}) {
    for (const Spring spring : {Spring{100, 2}, Spring{0, 2}, Spring{100, 0}, Spring{1e9, 1e-3}}) {
      const Softness softness = softness_of(spring, h);
      CHECK_NEAR(softness.erp * (h * spring.kp_N_m + spring.kd_Ns_m), h * spring.kp_N_m, 1e-15 * spring.kp_N_m * h);
      const Spring back = spring_of(softness, h);
      CHECK_NEAR(back.kp_N_m, spring.kp_N_m, 1e-14 * spring.kp_N_m);
      CHECK_NEAR(back.kd_Ns_m, spring.kd_Ns_m, 1e-14 * (h * spring.kp_N_m + spring.kd_Ns_m));
    }
  }
  // By hand: h kp = 0.1, kd = 0.3.
  CHECK_NEAR(softness_of({100, 0.3}, 1e-3).erp, 0.25, 1e-15);
  CHECK_NEAR(softness_of({100, 0.3}, 1e-3).cfm, 2.5, 1e-15);
}

struct LongDeflection {
  long double x;
  long double v;
};

/// A step of the oscillator's own equation in long double, by its Taylor series.
LongDeflection stepped(const DampedOscillator& oscillator, const LongDeflection& now, long double h) {
  const long double m = oscillator.mass_kg, kp = oscillator.kp_N_m, kd = oscillator.kd_Ns_m;
  // x^(j+2) = -(kp x^(j) + kd x^(j+1)) / m, the first with gravity on top.
  long double terms[30] = {now.x, now.v};
  terms[2] = -(kp * now.x + kd * now.v) / m - oscillator.gravity;
  for (int j = 1; j < 28; ++j) terms[j + 2] = -(kp * terms[j] + kd * terms[j + 1]) / m;
  LongDeflection next{0, 0};
  long double power = 1;
  for (int j = 0; j < 29; ++j) {
    next.x += terms[j] * power;
    next.v += terms[j + 1] * power;
    power *= h / (j + 1);
  }
  return next;
}

// The closed form against its own equation, within what it claims.
void closed_form() {
  const double m = 2;
  const double kp = 150;
  const double critical = 2 * std::sqrt(m * kp);
  for (const double damping : {0.0, 0.1, 0.999999, 1.0, 1.000001, 3.0, 100.0}) {
    const DampedOscillator oscillator{m, kp, damping * critical, 9.81};
    const Deflection start{0.05, -0.3};
    LongDeflection exact{start.x, start.v};
    const double h = 1.0 / 4096;  // exact in binary
    for (int n = 1; n <= 2 * 4096; ++n) {
      exact = stepped(oscillator, exact, h);
      if (n % 512 != 0) continue;
      const Deflection found = oscillator.at(n * h, start);
      CHECK_NEAR(found.x, static_cast<double>(exact.x), oscillator.uncertainty(n * h, start));
      CHECK_NEAR(found.v, static_cast<double>(exact.v), 1e-12 * (1 + damping));
    }
    // Back again in time, as the half-step start asks.
    CHECK_NEAR(oscillator.at(-1e-3, oscillator.at(1e-3, start)).x, start.x, 1e-14);
  }
  // Without a spring the mass sinks, at last with m g / kd.
  const DampedOscillator sinking{2, 0, 5, 9.81};
  CHECK_NEAR(sinking.at(100, {0, 0}).v, -2 * 9.81 / 5, 1e-12);
  CHECK_NEAR(sinking.at(1e-3, {0, 1}).x, 1e-3 - (9.81 + 2.5) * 5e-7 + 2.5 * (9.81 + 2.5) * 1e-9 / 6, 1e-11);
}

// What errors of bodies are measured against, within what it says of itself: a spring with one body on the world, and
// two bodies that a rigid joint pulls together while they fall.
void stated_uncertainty() {
  test::Coverage of_springs("bodies on springs");
  for (const double kd : {0.0, 4.0, 40.0, 4000.0}) {
    Scenario scenario = cube(ball, 9.81);
    scenario.ode.spring = Spring{150, kd};
    const Body& body = scenario.mechanism.bodies[0];
    std::array<LongDeflection, 3> exact;
    for (std::size_t k = 0; k < 3; ++k) exact[k] = {body.position_m[k], body.velocity_m_s[k]};
    const double h = 1.0 / 1024;
    for (int n = 1; n <= 8 * 1024; ++n) {
      for (std::size_t k = 0; k < 3; ++k) {
        exact[k] = stepped({body.mass_kg, 150, kd, k == 2 ? scenario.gravity : 0}, exact[k], h);
      }
      if (n % 512 == 0) test::add_position(of_springs, scenario, n * h, 0, {exact[0].x, exact[1].x, exact[2].x});
    }
  }
  of_springs.check(0.019);

  test::Coverage of_rigid("bodies in a rigid joint");
  Scenario scenario = sticks(9.81);
  scenario.ode.erp = 0.2;
  scenario.ode.cfm = 0;
  const long double h = scenario.step_s;
  for (int n = 1; n <= 1000; n += n < 20 ? 1 : 49) {
    const long double left = std::pow(1 - static_cast<long double>(0.2), n);
    const long double fallen = scenario.gravity * h * h * n * (n + 1) / 2;
    const long double closed = (1 - left) * 0.02;
    const double t = n * scenario.step_s;
    test::add_position(of_rigid, scenario, t, 0,
                       {0, 0, scenario.mechanism.bodies[0].position_m[2] - 0.75L * closed - fallen});
    test::add_position(of_rigid, scenario, t, 1,
                       {0, 0, scenario.mechanism.bodies[1].position_m[2] + 0.25L * closed - fallen});
  }
  of_rigid.check(0.22);

  test::Coverage of_turns("attitudes in a joint");
  for (double angle = 0.1; angle < 3; angle += 0.1) {
    Scenario turned = cube(ball, 9.81);
    turned.mechanism.bodies[0].attitude = Vec3{angle / 3, -angle, angle / 2};
    for (const Softness softness : {Softness{0.2, 0}, Softness{0.2, 1e-5}}) {
      turned.ode.erp = softness.erp;
      turned.ode.cfm = softness.cfm;
      test::add_turn(of_turns, turned, 0.5, 0);
    }
  }
  of_turns.check(0.58);
}

// No step has ended at the start: row 0 shows the force of the first one, which closes ERP of the gap from rest. By
// hand: 0.75 kg (0.2 0.02 m / 1 ms) / 1 ms, good to some roundings.
void first_force() {
  Scenario scenario = sticks(9.81);
  scenario.ode.erp = 0.2;
  scenario.ode.cfm = 0;
  const Reference reference = test::reference_at(scenario, scenario.step_s);
  for (const std::size_t row : {0U, 1U}) {
    CHECK_NEAR(reference.trace.bodies[0].joint_force[2][row], -3000, 1e-11);
    CHECK_NEAR(reference.trace.bodies[1].joint_force[2][row], 3000, 1e-11);
  }
}

struct Errors {
  double position;
  double force;
  double uncertainty;
};

Errors errors_of(Scenario scenario, double step_s) {
  scenario.step_s = step_s;
  catalogue::Evaluator evaluator(scenario);
  const auto run = evaluator.evaluate(catalogue::find_method("ode-step-double"));
  const Metrics metrics = evaluator.measure(run, scenario.duration_s);
  return {metrics[quantity::max_error_position].value(), metrics[quantity::max_reaction_error].value(),
          *metrics[quantity::position_uncertainty]};
}

// First order for each damping, positions and forces; 0.95 to 1.05 leaves room for the next term from 4 to 0.5 ms.
void oscillator_order() {
  for (const double damping : {0.1, 1.0, 3.0}) {
    for (const bool pair : {false, true}) {
      Scenario scenario = pair ? sticks(9.81) : cube(ball, 9.81);
      const double mass = pair ? 0.75 : 2;
      const double kp = 150;
      scenario.ode.spring = Spring{kp, damping * 2 * std::sqrt(mass * kp)};
      // What falls is off by g h t / 2, which is first order as well.
      std::vector<ErrorPoint> position;
      std::vector<ErrorPoint> force;
      for (const double h : {2e-3, 1e-3, 5e-4, 2.5e-4}) {
        const Errors errors = errors_of(scenario, h);
        position.push_back({h, errors.position, errors.uncertainty});
        force.push_back({h, errors.force, 0});
      }
      CHECK_BETWEEN(observed_order(position, 1).value().order, 0.95, 1.05);
      CHECK_BETWEEN(observed_order(force, 1e3).value().order, 0.9, 1.1);
    }
  }
}

// What the error is, to first order: implicit Euler is the exact motion of another spring, kp (1 - h kd / 2m), and
// another damper, kd + h kp - h kd^2 / 2m, started with the velocity that v0 will be half a step later. Against that
// motion the error falls by four when the step is halved.
void error_predicted() {
  const double m = 2;
  const auto left = [&](double damping, double h) {
    Scenario scenario = cube(ball, 0);
    scenario.step_s = h;
    const double kp = 150;
    const double kd = damping * 2 * std::sqrt(m * kp);
    scenario.ode.spring = Spring{kp, kd};
    const auto run = run_of(scenario);
    const DampedOscillator other{m, kp * (1 - h * kd / (2 * m)), kd + h * kp - h * kd * kd / (2 * m), 0};
    const double x0 = scenario.mechanism.bodies[0].position_m[0];
    const double v0 = scenario.mechanism.bodies[0].velocity_m_s[0];
    const double v_half = v0 + h / 2 * (-kp * x0 - kd * v0) / m;
    double largest = 0;
    for (std::size_t k = 0; k < run.trace.rows(); ++k) {
      const double x = other.at(run.trace.t[k], {x0, v_half}).x;
      largest = std::max(largest, std::fabs(run.trace.bodies[0].position[0][k] - x));
    }
    return largest;
  };
  for (const double damping : {0.0, 0.1, 0.7}) CHECK_BETWEEN(left(damping, 1e-3) / left(damping, 5e-4), 3.8, 4.2);
}

// At rest a spring gives way by m g / kp, whatever the step; then its force is the weight.
void static_sag() {
  for (const double h : {1e-3, 1e-2}) {
    Scenario scenario = cube(ball, 9.81);
    scenario.step_s = h;
    scenario.duration_s = 20;
    scenario.ode.spring = Spring{150, 10};
    const auto run = run_of(scenario);
    CHECK_NEAR(run.trace.bodies[0].position[2].back(), -2 * 9.81 / 150, 1e-13);
    CHECK_NEAR(run.trace.gap.back(), 2 * 9.81 / 150, 1e-13);
    CHECK_NEAR(run.trace.bodies[0].joint_force[2].back(), 2 * 9.81, 1e-11);
  }
}

// Two bodies pulled apart close the gap between them by the same law, share it as their masses say, and fall together.
void two_bodies() {
  Scenario scenario = sticks(9.81);
  scenario.ode.erp = 0.2;
  scenario.ode.cfm = 0;
  catalogue::Evaluator evaluator(scenario);
  const auto run = evaluator.evaluate(catalogue::find_method("ode-step-double"));
  CHECK_BETWEEN(evaluator.measure(run, 0.5)[quantity::max_error_position].value(), 0, 1e-13);
  const auto& z0 = run.trace.bodies[0].position[2];
  const auto& z1 = run.trace.bodies[1].position[2];
  for (std::size_t k = 1; k < 100; ++k) {
    CHECK_NEAR(run.trace.gap[k], 0.02 * std::pow(0.8, static_cast<double>(k)), 1e-15);
    CHECK_NEAR((z0[k] + 3 * z1[k] - (0.52 - 1.5)) / 4, -9.81 * 1e-6 * static_cast<double>(k * (k + 1)) / 2, 1e-14);
    for (std::size_t d = 0; d < 3; ++d) {
      CHECK_NEAR(run.trace.bodies[0].joint_force[d][k], -run.trace.bodies[1].joint_force[d][k], 1e-9);
    }
  }
  CHECK_NEAR(run.trace.gap[0], 0.02, 1e-16);
}

void other_methods() {
  Scenario scenario = cube(ball, 9.81);
  scenario.ode.spring = Spring{150, 4};
  scenario.ode.iterations = 60;  // 0.3^60 of an iteration's error is none
  CHECK_BETWEEN(off_the_law(scenario, run_of(scenario, "ode-quickstep-double")), 0, 1e-12);
  // Single precision rounds 0.05 m by 4e-9 in each of 500 steps.
  if (test::in_this_build("ode-step-single")) {
    CHECK_BETWEEN(off_the_law(scenario, run_of(scenario, "ode-step-single")), 1e-9, 2e-5);
  }
  scenario.ode.start = Start::half_step;
  CHECK(run_of(scenario).trace.rows() > 1);
}

void refusals() {
  const auto refused = [](Scenario scenario, const char* text) {
    CHECK_THROWS(catalogue::Evaluator(scenario).reference(), UserError, text);
  };
  Scenario off = sticks(9.81);
  off.mechanism.joints[0].opening_m = {0.01, 0, 0};
  off.mechanism.bodies[0].position_m = {0.01, 0, 0.5};
  refused(off, "bodies.0.position must be the joint's anchor or lie along its displacement");
  Scenario spinning = sticks(0);
  spinning.mechanism.bodies[1].spin_rad_s = {0, 0, 1};
  refused(spinning, "bodies.1.spin must be 0");
  Scenario thrown = sticks(0);
  thrown.mechanism.bodies[0].velocity_m_s = {1, 0, 0};
  refused(thrown, "bodies.0.velocity must lie along");
  Scenario tilted = cube(ball, 9.81);
  tilted.mechanism.joints[0] = Joint{.kind = BallJoint{{1, 0, 0}}, .second = {}, .opening_m = {0.1, 0, 0}};
  tilted.mechanism.bodies[0].velocity_m_s = {};
  tilted.mechanism.bodies[0].position_m = {0.1, 0, 0};
  refused(tilted, "bodies.0.position must be the joint's anchor, above or below it");
}

}  // namespace

int main() {
  conversion();
  closed_form();
  stated_uncertainty();
  first_force();
  law_in_closed_form();
  discrete_law();
  oscillator_order();
  error_predicted();
  static_sag();
  two_bodies();
  other_methods();
  refusals();
  return test::verdict();
}
