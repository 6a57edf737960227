// Motors, stops, springs, torques and controllers of one joint, in closed form: beside the reference, which has to
// agree to 1e-9 and within what it states, and ODE, which has to come nearer by the step.
#include <cmath>
#include <functional>
#include <numbers>

#include "catalogue/accurate_method.hpp"
#include "engines/ode/module.hpp"
#include "odeval/error.hpp"
#include "reference/tree/tree_reference.hpp"
#include "tests/check.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

/// Where a joint is at a time, and how fast.
struct Way {
  double q;
  double rate;
};
using ClosedForm = std::function<Way(double t)>;

// A wheel that turns about a slanting axis through its centre, one of its own; a sledge on a vertical rail.
const Vec3 axle{0, 0.6, 0.8};
constexpr double moment = 2 * (0.3 * 0.3 + 0.4 * 0.4) / 12;  // kg m²
constexpr double mass = 3;                                   // kg

Scenario wheel(double rate, double duration_s) {
  Scenario scenario;
  scenario.name = "wheel";
  scenario.duration_s = duration_s;
  scenario.ode.cfm = 0;
  // Its axis y is the axle.
  const Vec3 turn = std::atan2(axle[2], axle[1]) * Vec3{1, 0, 0};
  scenario.mechanism.bodies = {
      {.shape = Box{{0.3, 0.1, 0.4}}, .mass_kg = 2, .attitude = turn, .spin_rad_s = rate * axle}};
  scenario.mechanism.joints = {{.kind = HingeJoint{{0, 0, 0}, axle}, .second = {}}};
  return scenario;
}

Scenario sledge(double rate, double duration_s) {
  Scenario scenario;
  scenario.name = "sledge";
  scenario.duration_s = duration_s;
  scenario.ode.cfm = 0;
  scenario.mechanism.bodies = {{.shape = Box{{0.2, 0.3, 0.1}}, .mass_kg = mass, .velocity_m_s = {0, 0, rate}}};
  scenario.mechanism.joints = {{.kind = SliderJoint{{0, 0, 0}, {0, 0, 1}}, .second = {}}};
  return scenario;
}

/// Of the wheel within half a turn, or of the sledge.
Way way_of(const Scenario& scenario, const Vec3& position, const Rotation& rotation, const Vec3& velocity,
           const Vec3& spin) {
  if (std::holds_alternative<SliderJoint>(scenario.mechanism.joints[0].kind)) return {position[2], velocity[2]};
  const Vec3 across = unit(cross(axle, {1, 0, 0}));  // the world's x is the wheel's at t = 0
  const Vec3 x = axis_of(rotation, 0);
  return {std::atan2(dot(x, across), x[0]), dot(spin, axle)};
}

template <std::size_t N>
std::array<double, N> row(const std::array<Column, N>& columns, std::size_t k) {
  std::array<double, N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = columns[i][k];
  return values;
}

/// How far two ways are apart, a full turn being none.
double apart(const Scenario& scenario, double a, double b) {
  const bool slides = std::holds_alternative<SliderJoint>(scenario.mechanism.joints[0].kind);
  return std::fabs(slides ? a - b : std::remainder(a - b, 2 * std::numbers::pi));
}

/// The reference's largest error, and its rate's; both within 1e-9, the way within what is stated.
void check_reference(const char* what, const Scenario& scenario, double spacing_s, const ClosedForm& truth) {
  const SampleGrid grid{spacing_s, 1, std::lround(scenario.duration_s / spacing_s) + 1};
  const Reference reference = reference::solve_tree(scenario, grid);
  double way = 0;
  double rate = 0;
  double part = 0;
  const BodyColumns& body = reference.trace.bodies[0];
  for (std::size_t k = 0; k < reference.trace.rows(); ++k) {
    const Way wanted = truth(grid.time(static_cast<long>(k)));
    const Way found =
        way_of(scenario, row(body.position, k), row(body.rotation, k), row(body.velocity, k), row(body.spin, k));
    const double off = apart(scenario, found.q, wanted.q);
    way = std::fmax(way, off);
    rate = std::fmax(rate, std::fabs(found.rate - wanted.rate));
    part = std::fmax(part, off / (reference.uncertainty_position[k] + reference.uncertainty_turn[k] + 1e-15));
  }
  std::printf("%s: reference %.3g off, its rate %.3g, %.3g of what it states (%.3g)\n", what, way, rate, part,
              reference.uncertainty_position.back() + reference.uncertainty_turn.back());
  CHECK_BETWEEN(way, 0, 1e-9);
  CHECK_BETWEEN(rate, 0, 1e-9);
  CHECK_BETWEEN(part, 0, 1);
}

double error(MakeSimulation make, Scenario scenario, const ClosedForm& truth, double h) {
  scenario.step_s = h;
  const SampleGrid grid{h, 1, std::lround(scenario.duration_s / h) + 1};
  const test::Recorded run = test::recorded(make, scenario, grid);
  CHECK(!run.outcome.diverged);
  if (run.outcome.diverged) std::printf("%s\n", run.outcome.reason.c_str());
  double most = 0;
  for (std::size_t k = 0; k < run.motion.size(); ++k) {
    const BodyState& body = run.motion[k].bodies[0];
    const Way found = way_of(scenario, body.position, body.rotation, body.velocity, body.spin);
    most = std::fmax(most, apart(scenario, found.q, truth(grid.time(static_cast<long>(k))).q));
  }
  return most;
}

MakeSimulation world_step() { return engine_ode::odeval_ode_double().make_step; }

/// `form` gives the truth at a step: that of controllers which look once a step.
using FormAt = std::function<ClosedForm(double step_s)>;

void check_engines(const char* what, const Scenario& scenario, const FormAt& form, double rk4_most,
                   double most_order = 1.1) {
  double before = 0;
  double order = 0;
  for (const double h : {4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4}) {
    const double off = error(world_step(), scenario, form(h), h);
    order = std::log2(before / off);
    std::printf("%s: ODE at %g: %.4g, order %.3f\n", what, h, off, order);
    before = off;
  }
  const double rk4 = error(catalogue::make_accurate_4, scenario, form(1e-3), 1e-3);
  std::printf("%s: accurate step %.3g\n", what, rk4);
  CHECK_BETWEEN(order, 0.9, most_order);
  CHECK_BETWEEN(rk4, 0, rk4_most);
}

FormAt always(const ClosedForm& truth) {
  return [truth](double) { return truth; };
}

// ---- A motor at its limit of force

void a_motor_that_reaches_its_speed() {
  const Motor motor{3, 0.4};
  Scenario scenario = wheel(0, 1);
  scenario.mechanism.joints[0].motor = motor;
  const double reached_s = motor.speed * moment / motor.most;  // 0.3125 s
  const ClosedForm truth = [=](double t) -> Way {
    const double pull = motor.most / moment;
    if (t < reached_s) return {pull * t * t / 2, pull * t};
    return {motor.speed * (t - reached_s / 2), motor.speed};
  };
  check_reference("motor", scenario, 0.01, truth);
  check_engines("motor", scenario, always(truth), 1e-12);
}

// Down to its speed by its limit; there it holds against the weight with what that needs.
void a_motor_that_lifts() {
  const Motor motor{0.7, 40};
  Scenario scenario = sledge(-0.9, 1);
  scenario.mechanism.joints[0].motor = motor;
  const double pull = motor.most / mass - scenario.gravity;
  const double reached_s = (motor.speed + 0.9) / pull;
  const ClosedForm truth = [=](double t) -> Way {
    const double s = std::fmin(t, reached_s);
    return {-0.9 * s + pull * s * s / 2 + motor.speed * (t - s), t < reached_s ? -0.9 + pull * t : motor.speed};
  };
  check_reference("lift", scenario, 0.01, truth);
  check_engines("lift", scenario, always(truth), 1e-12);
}

// A torque rises beyond the motor's limit, which lets the speed go, falls again, and the motor takes it back.
void a_motor_that_lets_go() {
  const Motor motor{2, 0.4};
  Scenario scenario = wheel(2, 1.5);
  scenario.mechanism.joints[0].motor = motor;
  scenario.mechanism.joints[0].torques = {{.times_s = {0, 0.5, 1}, .values = {0, 0.8, 0}}};
  // Beyond the limit 1.6 N m/s (t - 0.25 s) until 0.5 s, then 0.4 N m - 1.6 N m/s (t - 0.5 s) until 1 s, then the limit
  // alone, which takes 0.125 s for what is left.
  const auto piece = [](double t, double from, double to) { return std::fmin(std::fmax(t - from, 0), to - from); };
  const ClosedForm truth = [=](double t) -> Way {
    const double a = piece(t, 0.25, 0.5);
    const double b = piece(t, 0.5, 1);
    const double c = piece(t, 1, 1.125);
    const double gained = 0.8 * a * a + 0.4 * b - 0.8 * b * b - 0.4 * c;
    const double before_b = 0.8 * 0.25 * 0.25;
    const double before_c = before_b + 0.4 * 0.5 - 0.8 * 0.25;
    const double way =
        0.8 * a * a * a / 3 + before_b * b + 0.2 * b * b - 0.8 * b * b * b / 3 + before_c * c - 0.2 * c * c;
    return {2 * t + way / moment, 2 + gained / moment};
  };
  check_reference("let go", scenario, 0.01, truth);
  // ODE turns a wheel at constant speed exactly, and a ramp whose bends are ticks by its trapezes: second order.
  check_engines("let go", scenario, always(truth), 1e-9, 2.1);
}

// ---- A stop struck at speed

/// Falls on its stop and bounces, by Newton's law, until it lies there.
Way bouncing(double height, double gravity, double restitution, double t) {
  double begin = 0;
  double up = 0;
  double from = height;
  for (int bounce = 0; bounce < 200; ++bounce) {
    const double end = begin + (up + std::sqrt(up * up + 2 * gravity * from)) / gravity;
    const double s = t - begin;
    if (t <= end) return {from - height + up * s - gravity * s * s / 2, up - gravity * s};
    up = restitution * (gravity * (end - begin) - up);
    begin = end;
    from = 0;
  }
  return {-height, 0};
}

void a_stop_struck_at_speed() {
  Scenario scenario = sledge(0, 1);
  // Struck after 0.32 s, on the tick of every step, so that ODE sees it as late in each: half a step.
  const double height = scenario.gravity * 0.32 * 0.32 / 2;
  scenario.mechanism.joints[0].stop = Stop{-height, 1, 0.6};
  const ClosedForm truth = [&](double t) { return bouncing(height, scenario.gravity, 0.6, t); };
  check_reference("stop", scenario, 0.01, truth);
  scenario.duration_s = 0.6;
  check_engines("stop", scenario, always(truth), 1e-9);
}

void a_stop_on_which_it_comes_to_rest() {
  Scenario scenario = sledge(0, 1);
  scenario.mechanism.joints[0].stop = Stop{-0.2, 1, 0.5};  // at rest after 3 sqrt(2 h / g) = 0.606 s
  const ClosedForm truth = [&](double t) { return bouncing(0.2, scenario.gravity, 0.5, t); };
  check_reference("rest", scenario, 0.01, truth);
  const Reference reference = reference::solve_tree(scenario, SampleGrid{0.01, 1, 101});
  CHECK_BETWEEN(reference.uncertainty_position.back(), 0, 1e-12);  // it lies where it lies
}

// ---- Springs and torques

/// m x'' = -k (x - rest) - d x' - m g, from rest at 0.
void a_sprung_sledge() {
  const JointSpring spring{200, 6, 0.1};
  Scenario scenario = sledge(0, 1);
  scenario.mechanism.joints[0].springs = {spring};
  const double low = spring.rest - mass * scenario.gravity / spring.stiffness;
  const double decay = spring.damping / mass / 2;
  const double swing = std::sqrt(spring.stiffness / mass - decay * decay);
  const ClosedForm truth = [=](double t) -> Way {
    const double shrink = std::exp(-decay * t);
    const double cosine = std::cos(swing * t);
    const double sine = std::sin(swing * t);
    return {low - low * shrink * (cosine + decay / swing * sine),
            low * shrink * (decay * decay / swing + swing) * sine};
  };
  check_reference("spring", scenario, 0.01, truth);
  // It goes up and down, and what the spring does is no force of the joint: that has nothing to hold.
  const SampleGrid grid{0.01, 1, 101};
  const Reference reference = reference::solve_tree(scenario, grid);
  for (const Column& force : reference.trace.bodies[0].joint_force) {
    CHECK_EQUAL(force.size(), 101U);
    for (const double part : force) CHECK_NEAR(part, 0, 1e-9);  // N of 10
  }
  check_engines("spring", scenario, always(truth), 1e-9);
}

/// A sine with a constant on it, and a table that rises to 1 N m within 0.35 s and stays.
void a_torque_over_time() {
  const Signal torque{.constant = 0.2,
                      .amplitude = 0.5,
                      .frequency_Hz = 1.3,
                      .phase_rad = 0.4,
                      .times_s = {0.1, 0.35},
                      .values = {0, 1}};
  Scenario scenario = wheel(0.5, 1);
  scenario.mechanism.joints[0].torques = {torque};
  const double w = 2 * std::numbers::pi * torque.frequency_Hz;
  const ClosedForm truth = [=](double t) -> Way {
    const double c = torque.constant / moment;
    const double a = torque.amplitude / moment / w;
    Way way{0.5 * t + c * t * t / 2 + a * std::cos(0.4) * t - a / w * (std::sin(w * t + 0.4) - std::sin(0.4)),
            0.5 + c * t + a * (std::cos(0.4) - std::cos(w * t + 0.4))};
    const double slope = 4 / moment;
    const double rising = std::fmin(std::fmax(t - 0.1, 0), 0.25);
    const double after = std::fmax(t - 0.35, 0);
    way.rate += slope * rising * rising / 2 + after / moment;
    way.q += slope * rising * rising * rising / 6 + slope * 0.25 * 0.25 / 2 * after + after * after / moment / 2;
    return way;
  };
  check_reference("torque", scenario, 0.01, truth);
  check_engines("torque", scenario, always(truth), 1e-7);
}

// ---- A controller that looks once a step

/// From one look to the next its load is constant: a parabola each.
void a_controller_sampled_once_a_step() {
  const Controller controller{.kp = 8, .kd = 0.5, .target = {.constant = 0.7}, .sampled = true};
  Scenario scenario = wheel(0, 1);
  scenario.mechanism.joints[0].controllers = {controller};
  const FormAt form = [=](double step_s) -> ClosedForm {
    return [=](double t) -> Way {
      Way way{0, 0};
      for (long k = 0;; ++k) {
        const double s = std::fmin(t - static_cast<double>(k) * step_s, step_s);
        if (s <= 0) return way;
        const double pull = (controller.kp * (0.7 - way.q) - controller.kd * way.rate) / moment;
        way = {way.q + s * way.rate + s * s * pull / 2, way.rate + s * pull};
      }
    };
  };
  scenario.step_s = 0.01;
  check_reference("sampled, 10 ms", scenario, 0.01, form(0.01));
  scenario.step_s = 0.003;
  check_reference("sampled, 3 ms", scenario, 0.01, form(0.003));
  check_engines("sampled", scenario, form, 1e-12);
}

/// At every moment it is a spring and a damper.
void a_continuous_controller() {
  Scenario one = wheel(0.4, 1);
  Scenario other = one;
  one.mechanism.joints[0].controllers = {{.kp = 8, .kd = 0.5, .target = {.constant = 0.7}}};
  other.mechanism.joints[0].springs = {{.stiffness = 8, .damping = 0.5, .rest = 0.7}};
  const SampleGrid grid{0.01, 1, 101};
  const Reference a = reference::solve_tree(one, grid);
  const Reference b = reference::solve_tree(other, grid);
  for (std::size_t k = 0; k < 101; ++k) {
    CHECK_NEAR(distance(row(a.trace.bodies[0].spin, k), row(b.trace.bodies[0].spin, k)), 0, 1e-10);
  }
}

}  // namespace

int main() {
  a_motor_that_reaches_its_speed();
  a_motor_that_lifts();
  a_motor_that_lets_go();
  a_stop_struck_at_speed();
  a_stop_on_which_it_comes_to_rest();
  a_sprung_sledge();
  a_torque_over_time();
  a_controller_sampled_once_a_step();
  a_continuous_controller();
  return test::verdict();
}
