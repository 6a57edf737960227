// Bodies in space, from a recorded motion to energies, momentum and errors.
#include "measure/body_trace.hpp"

#include <numbers>

#include "measure/metrics.hpp"
#include "reference/closed_form/body_motion.hpp"
#include "reference/closed_form/rotation.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

constexpr double rounding = 1e-14;  // of a few operations on numbers of order 1

Scenario one_box() {
  Scenario scenario;
  scenario.step_s = 0.5;
  scenario.duration_s = 0.5;
  scenario.gravity = 10;
  scenario.mechanism.bodies = {
      Body{.shape = Box{{1, 2, 3}}, .mass_kg = 2, .position_m = {0, 0, 4}, .velocity_m_s = {3, 0, 0}}};
  return scenario;
}

BodyState state(const Vec3& turn, const Vec3& spin) {
  return {.position = {0, 0, 4}, .rotation = reference::rotation_of(turn), .velocity = {3, 0, 0}, .spin = spin};
}

/// Of one body, and a joint that holds it.
Motion motion_of(std::initializer_list<BodyState> states) {
  Motion motion({.bodies = 1, .joints = 1}, states.size());
  for (const BodyState& body : states) motion.append().bodies[0] = body;
  return motion;
}

// Moments of the box: 2 (4 + 9) / 12, 2 (9 + 1) / 12, 2 (1 + 4) / 12. A spin is split along the body's axes as they
// lie.
void energies_and_momentum() {
  const Scenario scenario = one_box();
  const SampleGrid grid = sample_grid(scenario);
  constexpr double quarter_turn = std::numbers::pi / 2;
  const Motion motion = motion_of({state({}, {1, 2, 3}), state({0, 0, quarter_turn}, {1, 2, 3})});
  const Trace trace = body_trace(scenario, grid, motion);
  const double x = 26.0 / 12;
  const double y = 20.0 / 12;
  const double z = 10.0 / 12;
  CHECK_NEAR(trace.potential[0], 2 * 10 * 4, rounding);
  CHECK_NEAR(trace.kinetic[0], 0.5 * 2 * 9 + 0.5 * (x * 1 + y * 4 + z * 9), rounding);
  // Turned about z by a quarter, the body's x axis lies along y, its y axis along -x.
  CHECK_NEAR(trace.kinetic[1], 0.5 * 2 * 9 + 0.5 * (y * 1 + x * 4 + z * 9), rounding);
  CHECK_NEAR(trace.angular_momentum_drift[1], std::hypot((y - x) * 1, (x - y) * 2), rounding);
  CHECK_NEAR(measure(trace, nullptr, 1)[quantity::max_angular_momentum_drift].value_or(0), (x - y) * std::sqrt(5.0),
             rounding);
  CHECK(!measure(trace, nullptr, 1)[quantity::max_gap]);
}

// A trace has the columns that its scenario gives a meaning, and no others: a joint in the air has no ground to reach
// into.
void columns() {
  Scenario scenario = one_box();
  const SampleGrid grid = sample_grid(scenario);
  BodyState low = state({}, {});
  low.position[2] = 1.25;
  const Motion motion = motion_of({state({}, {}), low});
  const Trace free = body_trace(scenario, grid, motion);
  CHECK(free.gap.empty() && free.penetration.empty() && !free.angular_momentum_drift.empty());
  scenario.mechanism.joints = {Joint{.kind = BallJoint{}, .second = {}}};
  const Trace jointed = body_trace(scenario, grid, motion);
  CHECK(!jointed.gap.empty() && jointed.penetration.empty() && jointed.angular_momentum_drift.empty());
  scenario.mechanism.joints.clear();
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  scenario.mechanism.contacts = {{.restitution = 0, .friction = {}}};
  const Trace grounded = body_trace(scenario, grid, motion);
  CHECK(grounded.gap.empty() && !grounded.penetration.empty() && grounded.angular_momentum_drift.empty());
  CHECK_EQUAL(grounded.penetration[0], 0.0);
  CHECK_NEAR(grounded.penetration[1], 0.25, rounding);  // half the box is 1.5 m high
  // A foot of 0.2 m at its lower end, which contacts name alone: the rest of the body hangs through. A second plane,
  // 0.3 m higher, that nothing names.
  Body& box = scenario.mechanism.bodies[0];
  box.name = "leg";
  box.several = {{box.shape, Frame{}, ""}, {Sphere{0.2}, {{0, 0, -1.2}, Frame{}.rotation}, "foot"}};
  scenario.mechanism.obstacles.push_back({HalfSpace{.normal = {0, 0, 1}, .offset_m = 0.3}, "shelf"});
  scenario.mechanism.contacts[0].first = "leg.foot";
  scenario.mechanism.contacts[0].second = "ground";
  CHECK_NEAR(body_trace(scenario, grid, motion).penetration[1], 0.05, rounding);
}

void errors() {
  const Scenario scenario = one_box();
  const SampleGrid grid = sample_grid(scenario);
  BodyState moved = state({0.3, -0.4, 1.2}, {});
  moved.position[0] = 3;
  moved.position[1] = -4;
  Trace trace = body_trace(scenario, grid, motion_of({state({}, {}), moved}));
  Reference reference;
  reference.trace = body_trace(scenario, grid, motion_of({state({}, {}), state({}, {})}));
  reference.uncertainty_position = {0, 0.25};
  reference.uncertainty_turn = {0, 0.125};
  compare(trace, reference);
  const Metrics metrics = measure(trace, &reference, 1);
  CHECK_NEAR(metrics[quantity::max_error_position].value_or(0), 5, rounding);
  CHECK_NEAR(metrics[quantity::max_error_turn].value_or(0), 1.3, rounding);
  CHECK_EQUAL(metrics[quantity::position_uncertainty].value_or(0), 0.25);
  CHECK_EQUAL(metrics[quantity::turn_uncertainty].value_or(0), 0.125);
  CHECK(!metrics[quantity::max_error_q]);
  CHECK_EQUAL(measure(trace, &reference, 0)[quantity::max_error_position].value_or(1), 0.0);
  CHECK(judge({"any", "max_error_position", 1, 5.2, {}}, metrics) == Judgement::undecided);
  CHECK(judge({"any", "max_error_position", 1, 5.3, {}}, metrics) == Judgement::kept);
  CHECK(judge({"any", "max_error_turn", 1, 1.1, {}}, metrics) == Judgement::failed);
}

// About the longest side, z, as it lies in the world; against a reference that spins about it as well.
void long_axis_spin() {
  const Scenario scenario = one_box();
  const SampleGrid grid = sample_grid(scenario);
  constexpr double quarter_turn = std::numbers::pi / 2;
  Trace trace = body_trace(scenario, grid, motion_of({state({}, {1, 2, 3}), state({0, quarter_turn, 0}, {1, 2, 3})}));
  CHECK_NEAR(trace.long_axis_spin[0][0], 3, rounding);
  CHECK_NEAR(trace.long_axis_spin[0][1], 1, rounding);  // z lies along x
  Reference reference;
  reference.trace = body_trace(scenario, grid, motion_of({state({}, {0, 0, 3}), state({}, {0, 0, 3.5})}));
  reference.uncertainty_position = reference.uncertainty_turn = {0, 0};
  reference.uncertainty_spin = {0, 0.5};
  compare(trace, reference);
  const Metrics metrics = measure(trace, &reference, 1);
  CHECK_NEAR(metrics[quantity::max_long_axis_spin].value_or(0), 2.5, rounding);
  CHECK_EQUAL(metrics[quantity::spin_uncertainty].value_or(0), 0.5);
  CHECK(judge({"any", "max_long_axis_spin", 1, 2.7, {}}, metrics) == Judgement::undecided);
}

// Semi-implicit Euler falls by g h t / 2 too far; started half a step early it does not.
void fall() {
  Scenario scenario = one_box();
  scenario.step_s = 1e-3;
  scenario.duration_s = 2;
  const auto error = [&] {
    catalogue::Evaluator evaluator(scenario);
    const auto run = evaluator.evaluate(catalogue::find_method("ode-step-double"));
    return evaluator.measure(run, 2)[quantity::max_error_position].value_or(0);
  };
  CHECK_NEAR(error(), 10 * 1e-3 * 2 / 2, 1e-12);
  scenario.ode.start = Start::half_step;
  CHECK_NEAR(error(), 0, 1e-12);
}

}  // namespace

int main() {
  energies_and_momentum();
  columns();
  errors();
  long_axis_spin();
  fall();
  return test::verdict();
}
