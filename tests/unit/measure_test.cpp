// Traces with known errors, and poses with known angles, energies and gaps.
#include <cmath>
#include <limits>
#include <random>

#include "measure/cartesian_trace.hpp"
#include "measure/metrics.hpp"
#include "measure/spread.hpp"
#include "model/generate.hpp"
#include "model/problems.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;

constexpr double pi = 3.14159265358979323846;
constexpr double infinity = std::numeric_limits<double>::infinity();
const double nan = std::nan("");

// Rounding of a few operations on numbers of order 1 to 100.
constexpr double rounding = 1e-12;

Scenario scenario_of(std::string_view problem_name) {
  Scenario scenario;
  const Problem& problem = *std::ranges::find(problems, problem_name, &Problem::name);
  const auto links = static_cast<std::size_t>(problem.links);
  const std::vector<double> zeros(links);
  put_planar(scenario, {problem.frame, std::vector(links, Link{2.0, 1.2, 0.1, 0.3}), zeros, zeros, {}});
  scenario.duration_s = 1;
  scenario.step_s = 0.01;
  return scenario;
}

/// A row every step, or every `stride` steps, for 1 s.
SampleGrid grid_of(const Scenario& scenario, long stride = 1) {
  return {scenario.step_s, stride, std::lround(1 / (scenario.step_s * static_cast<double>(stride))) + 1};
}

/// Bodies of a chain whose absolute angles turn at constant rates, joints closed.
void append_pose(const Scenario& scenario, const std::vector<double>& angles, const std::vector<double>& rates,
                 Motion& motion) {
  const PlanarFrame& frame = scenario.planar->frame;
  const Vec3 axis = frame.axis();
  const Sample sample = motion.append();
  Vec3 anchor = frame.hinge_m;
  Vec3 anchor_velocity{};
  for (std::size_t i = 0; i < scenario.planar->links.size(); ++i) {
    const double a = angles[i];
    const double length = scenario.planar->links[i].length_m;
    Vec3 along{}, across{};
    for (std::size_t d = 0; d < 3; ++d) {
      along[d] = frame.horizontal[d] * std::cos(a) + frame.up[d] * std::sin(a);
      across[d] = -frame.horizontal[d] * std::sin(a) + frame.up[d] * std::cos(a);
    }
    BodyState& body = sample.bodies[i];
    body.angle = a;
    for (std::size_t d = 0; d < 3; ++d) {
      body.position[d] = anchor[d] + length / 2 * along[d];
      body.velocity[d] = anchor_velocity[d] + length / 2 * rates[i] * across[d];
      body.spin[d] = rates[i] * axis[d];
      anchor[d] += length * along[d];
      anchor_velocity[d] += length * rates[i] * across[d];
      // R takes along_body to along, across_body to across, their cross product to the axis.
      const Vec3 third = cross(frame.along_body, frame.across_body);
      for (std::size_t c = 0; c < 3; ++c) {
        body.rotation[3 * d + c] =
            along[d] * frame.along_body[c] + across[d] * frame.across_body[c] + axis[d] * third[c];
      }
    }
  }
}

Motion motion_for(const Scenario& scenario, const SampleGrid& grid) {
  const std::size_t links = scenario.planar->links.size();
  return {{.bodies = links, .joints = links}, static_cast<std::size_t>(grid.rows)};
}

void frames_are_right_handed() {
  for (const Problem& problem : problems) {
    const PlanarFrame& frame = problem.frame;
    CHECK_NEAR(dot(frame.along_body, frame.across_body), 0, 0);
    CHECK_EQUAL(frame.up[2], 1.0);
    // The box's third side lies along the hinge, whichever way the report's axis points.
    CHECK_EQUAL(std::fabs(dot(frame.hinge_axis, frame.axis())), 1.0);
    CHECK_EQUAL(std::fabs(dot(frame.hinge_axis, cross(frame.along_body, frame.across_body))), 1.0);
  }
}

// A link that turns steadily, many turns, in both frames: everything is known in closed form.
void a_turning_link_is_measured_exactly(const char* problem, double q0, double rate) {
  Scenario scenario = scenario_of(problem);
  change_planar(scenario, [&](PlanarView& view) { view.q0 = {q0}; });
  scenario.gravity = 9.0;
  const SampleGrid grid = grid_of(scenario);
  Motion motion = motion_for(scenario, grid);
  for (long k = 0; k < grid.rows; ++k) append_pose(scenario, {q0 + rate * grid.time(k)}, {rate}, motion);
  motion[100].joints[0].force[2] = 7;
  const Trace trace = cartesian_trace(scenario, grid, motion);

  const double m = 2.0, l = 1.2, w = 0.1;
  const double kinetic = 0.5 * rate * rate * (m * l * l / 4 + m * (l * l + w * w) / 12);
  double error = 0;
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    const double q = q0 + rate * trace.t[k];
    const double potential = m * 9.0 * l / 2 * std::sin(q);
    error = std::fmax(error, std::fabs(trace.q[0][k] - q));
    error = std::fmax(error, std::fabs(trace.qd[0][k] - rate));
    error = std::fmax(error, std::fabs(trace.kinetic[k] - kinetic) / (1 + kinetic));
    error = std::fmax(error, std::fabs(trace.potential[k] - potential));
    error = std::fmax(error, trace.gap[k]);
    error = std::fmax(error, trace.out_of_plane[k]);
  }
  CHECK_EQUAL(trace.rows(), 101u);
  CHECK_NEAR(error, 0, rounding);
  CHECK_EQUAL(trace.bodies.size(), 1u);
  CHECK_EQUAL(trace.bodies[0].position[2][0], motion[0].bodies[0].position[2]);
  CHECK_EQUAL(trace.bodies[0].joint_force[2][100], 7.0);
}

void relative_angles_of_two_links() {
  Scenario scenario = scenario_of("double_pendulum");
  change_planar(scenario, [](PlanarView& view) { view.q0 = {pi / 4, -pi / 4}; });
  const SampleGrid grid = grid_of(scenario);
  Motion motion = motion_for(scenario, grid);
  for (long k = 0; k < grid.rows; ++k) {
    const double t = grid.time(k);
    append_pose(scenario, {pi / 4 - 20 * t, 30 * t}, {-20, 30}, motion);
  }
  const Trace trace = cartesian_trace(scenario, grid, motion);
  CHECK_NEAR(trace.q[0].back(), pi / 4 - 20, rounding);
  CHECK_NEAR(trace.q[1].back(), 30 - (pi / 4 - 20), rounding);
  CHECK_NEAR(trace.qd[0].back(), -20, rounding);
  CHECK_NEAR(trace.qd[1].back(), 50, rounding);
  CHECK_NEAR(trace.gap.back(), 0, rounding);
}

// 100 rad/s sampled every 0.05 s: 5 rad between rows, more than half a turn. The row says which branch it is on.
void sparse_rows_keep_their_turns() {
  const Scenario scenario = scenario_of("single_pendulum");
  const SampleGrid grid = grid_of(scenario, 5);
  Motion motion = motion_for(scenario, grid);
  for (long k = 0; k < grid.rows; ++k) append_pose(scenario, {100 * grid.time(k)}, {100}, motion);
  CHECK_NEAR(cartesian_trace(scenario, grid, motion).q[0].back(), 100, rounding);
}

void faults_of_the_pose_show() {
  const Scenario scenario = scenario_of("double_pendulum");
  SampleGrid grid = grid_of(scenario);
  grid.rows = 4;
  Motion motion = motion_for(scenario, grid);
  for (long k = 0; k < grid.rows; ++k) append_pose(scenario, {0, 0}, {0, 0}, motion);
  motion[1].bodies[1].position[1] += 1e-3;  // of link 2: its anchor leaves that of link 1
  motion[2].bodies[0].position[0] -= 2e-3;  // of link 1: out of plane, and away from both its anchors
  motion[3].bodies[0].spin[0] = 4;          // of link 1 about x, the hinge
  motion[3].bodies[1].spin[1] = 3;          // of link 2 about y, its long axis at angle 0
  motion[3].contacts = 2;
  const Trace trace = cartesian_trace(scenario, grid, motion);
  CHECK_NEAR(trace.gap[0], 0, rounding);
  CHECK_NEAR(trace.gap[1], 1e-3, rounding);
  CHECK_NEAR(trace.gap[2], 2e-3, rounding);
  CHECK_NEAR(trace.out_of_plane[1], 0, rounding);
  CHECK_NEAR(trace.out_of_plane[2], 2e-3, rounding);
  // m (l^2 + w^2) / 12 about the hinge, m (w^2 + d^2) / 12 about the long axis.
  const double hinge = 2.0 * (1.2 * 1.2 + 0.1 * 0.1) / 12;
  const double length = 2.0 * (0.1 * 0.1 + 0.3 * 0.3) / 12;
  CHECK_NEAR(trace.kinetic[3], 0.5 * (hinge * 16 + length * 9), rounding);
  CHECK_EQUAL(trace.contacts[2], 0.0);
  CHECK_EQUAL(trace.contacts[3], 2.0);
}

void a_broken_row_stays_broken() {
  const Scenario scenario = scenario_of("double_pendulum");
  SampleGrid grid = grid_of(scenario);
  grid.rows = 2;
  Motion motion = motion_for(scenario, grid);
  for (long k = 0; k < grid.rows; ++k) append_pose(scenario, {0, 0}, {0, 0}, motion);
  motion[1].bodies[0].position[0] = nan;
  const Trace trace = cartesian_trace(scenario, grid, motion);
  CHECK(std::isnan(trace.gap[1]));
  CHECK(std::isnan(trace.out_of_plane[1]));
  const Metrics metrics = measure(trace, nullptr, 1);
  CHECK_EQUAL(metrics[quantity::max_gap].value_or(0), infinity);
  CHECK_EQUAL(metrics[quantity::max_out_of_plane].value_or(0), infinity);
}

/// Five samples, 1 s apart, of two angles that stand still in the reference.
Trace still_trace() {
  Trace trace;
  trace.t = {0, 1, 2, 3, 4};
  trace.q.assign(2, Column(5, 0.5));
  trace.qd.assign(2, Column(5));
  for (Column* column : {&trace.kinetic, &trace.potential, &trace.gap, &trace.out_of_plane, &trace.contacts}) {
    column->assign(5, 0.0);
  }
  return trace;
}

Reference still_reference() {
  Reference reference;
  reference.trace = still_trace();
  reference.uncertainty_q = {0, 1e-9, 2e-9, 3e-9, 4e-9};
  reference.joint_force.assign(2, {Column(5, 1.0), Column(5, 2.0), Column(5, 3.0)});
  return reference;
}

Trace with_bodies(Trace trace) {
  trace.bodies.resize(2);
  for (BodyColumns& body : trace.bodies) body.joint_force = {Column(5, 1.0), Column(5, 2.0), Column(5, 3.0)};
  return trace;
}

void errors_are_differences_from_the_reference() {
  Trace trace = still_trace();
  trace.q[0] = {0.5, 0.51, 0.5, 0.5, 0.5};
  trace.q[1] = {0.5, 0.5, 0.47, 0.65, 0.5};
  compare(trace, still_reference());
  CHECK_NEAR(trace.error_q[0][1], 0.01, 1e-15);
  CHECK_NEAR(trace.error_q[1][2], -0.03, 1e-15);

  const Reference reference = still_reference();
  const Metrics at_1 = measure(trace, &reference, 1);
  CHECK_NEAR(at_1[quantity::max_error_q].value(), 0.01, 1e-15);
  CHECK_NEAR(at_1[quantity::rms_error_q].value(), 0.01 / 2, 1e-15);  // one of four samples
  CHECK_EQUAL(at_1[quantity::reference_uncertainty].value(), 1e-9);
  CHECK(!at_1[quantity::divergence_time]);
  CHECK(!at_1[quantity::max_reaction_error]);  // no bodies
  CHECK_NEAR(measure(trace, &reference, 2.9999)[quantity::max_error_q].value(), 0.03, 1e-15);
  CHECK_NEAR(measure(trace, &reference, 3 - 1e-12)[quantity::max_error_q].value(), 0.15, 1e-15);  // 3, up to rounding
  const Metrics all = measure(trace, &reference, 10);
  CHECK_EQUAL(all[quantity::divergence_time].value(), 3.0);
  CHECK_EQUAL(all[quantity::reference_uncertainty].value(), 4e-9);
  CHECK_NEAR(all[quantity::rms_error_q].value(), std::sqrt((0.01 * 0.01 + 0.03 * 0.03 + 0.15 * 0.15) / 10), 1e-15);

  const Metrics alone = measure(still_trace(), nullptr, 10);
  CHECK(!alone[quantity::max_error_q] && !alone[quantity::rms_error_q] && !alone[quantity::reference_uncertainty] &&
        !alone[quantity::divergence_time]);
}

void other_times_are_refused() {
  const Reference reference = still_reference();
  Trace shifted = still_trace();
  shifted.t[2] = 2.5;
  CHECK_THROWS(compare(shifted, reference), MachineError, "times of the trace");
  Trace single = still_trace();
  single.q.pop_back();
  CHECK_THROWS(compare(single, reference), MachineError, "2 angles, the trace 1");
  Reference shorter = still_reference();
  shorter.trace.t.pop_back();
  Trace trace = still_trace();
  CHECK_THROWS(compare(trace, shorter), MachineError, "times of the trace");
}

void drift_is_counted_from_the_start() {
  Trace trace = still_trace();
  trace.kinetic = {1, 1, 1, 1, 1};
  trace.potential = {-3, -3, -1, -7, -4};
  const Metrics metrics = measure(trace, nullptr, 4);
  CHECK_EQUAL(*metrics[quantity::max_energy_drift], 4.0);
  CHECK_EQUAL(*metrics[quantity::final_energy_drift], -1.0);
  CHECK_NEAR(*metrics[quantity::rms_energy_drift], std::sqrt((4.0 + 16.0 + 1.0) / 5), 1e-15);
  CHECK_EQUAL(*measure(trace, nullptr, 2)[quantity::max_energy_drift], 2.0);
  CHECK_EQUAL(*measure(trace, nullptr, 2)[quantity::final_energy_drift], 2.0);
}

void not_a_number_is_never_small() {
  const Reference reference = still_reference();
  for (const double broken : {nan, infinity, -infinity}) {
    Trace trace = with_bodies(still_trace());
    trace.q[1][2] = broken;
    trace.kinetic[3] = broken;
    trace.gap[1] = broken;
    trace.out_of_plane[1] = broken;
    trace.bodies[0].joint_force[1][2] = broken;
    compare(trace, reference);
    const Metrics metrics = measure(trace, &reference, 4);
    CHECK_EQUAL(metrics[quantity::max_error_q].value(), infinity);
    CHECK_EQUAL(metrics[quantity::rms_error_q].value(), infinity);
    CHECK_EQUAL(metrics[quantity::divergence_time].value(), 2.0);
    CHECK_EQUAL(*metrics[quantity::max_energy_drift], infinity);
    CHECK_EQUAL(*metrics[quantity::rms_energy_drift], infinity);
    CHECK_EQUAL(metrics[quantity::max_gap].value_or(0), infinity);
    CHECK_EQUAL(metrics[quantity::max_out_of_plane].value_or(0), infinity);
    CHECK_EQUAL(metrics[quantity::max_reaction_error].value(), infinity);
    CHECK_EQUAL(measure(trace, &reference, 0)[quantity::max_error_q].value(), 0.0);
  }
}

void a_run_that_ended_early_is_lost() {
  const Reference reference = still_reference();
  Trace trace = still_trace();
  for (Column* column : {&trace.t, &trace.q[0], &trace.q[1], &trace.kinetic, &trace.potential, &trace.gap,
                         &trace.out_of_plane, &trace.contacts}) {
    column->resize(2);
  }
  compare(trace, reference);
  CHECK_EQUAL(measure(trace, &reference, 1)[quantity::max_error_q].value(), 0.0);
  const Metrics metrics = measure(trace, &reference, 4);
  CHECK_EQUAL(metrics[quantity::max_error_q].value(), infinity);
  CHECK_EQUAL(metrics[quantity::divergence_time].value(), 2.0);  // the first sample it lacks
  CHECK_EQUAL(*metrics[quantity::max_energy_drift], infinity);
}

void reactions_count_without_contact_and_after_the_first_row() {
  const Reference reference = still_reference();
  Trace trace = with_bodies(still_trace());
  trace.bodies[0].joint_force[0][0] = 100;  // row 0: of no step
  trace.bodies[1].joint_force[2][1] = 50;
  trace.contacts[1] = 1;
  trace.bodies[1].joint_force[0][2] = 1 + 3;  // 3 and 4 across: 5
  trace.bodies[1].joint_force[1][2] = 2 + 4;
  CHECK_EQUAL(measure(trace, &reference, 4)[quantity::max_reaction_error].value(), 5.0);
  CHECK_EQUAL(measure(trace, &reference, 1)[quantity::max_reaction_error].value(), 0.0);
}

// An angle that turns evenly, 3 ms ahead, with an error of its own at one sample; an impact ends what is looked at.
void a_clock_that_is_ahead_shows() {
  constexpr double ahead_s = 3e-3;
  Reference reference;
  reference.trace.q.resize(1);
  reference.trace.qd.resize(1);
  Trace trace = reference.trace;
  for (int k = 0; k <= 100; ++k) {
    const double t = 0.01 * k;
    for (Trace* one : {&trace, &reference.trace}) {
      one->t.push_back(t);
      one->q[0].push_back(2 * (one == &trace ? t + ahead_s : t));
      one->qd[0].push_back(2);
      for (Column* column : {&one->kinetic, &one->potential, &one->contacts}) column->push_back(0);
    }
    reference.uncertainty_q.push_back(1e-6);
  }
  compare(trace, reference);
  const Metrics metrics = measure(trace, &reference, 1);
  CHECK_NEAR(metrics[quantity::time_shift].value(), ahead_s, 1e-12);
  CHECK_NEAR(metrics[quantity::error_q_after_shift].value(), 0, 1e-12);
  CHECK_NEAR(metrics[quantity::max_error_q].value(), 2 * ahead_s, 1e-12);
  CHECK_NEAR(metrics[quantity::time_shift_uncertainty].value(), 1e-6 / 2, 1e-12);

  trace.q[0][60] += 0.05;
  CHECK_NEAR(measure(trace, &reference, 0.5)[quantity::error_q_after_shift].value(), 0, 1e-12);
  CHECK_BETWEEN(measure(trace, &reference, 1)[quantity::error_q_after_shift].value(), 0.049, 0.05);
  reference.impacts.push_back({0.55, 0, 0, 0, 0});
  CHECK_NEAR(measure(trace, &reference, 1)[quantity::error_q_after_shift].value(), 0, 1e-12);
  compare(trace, reference);
  trace.q[0][60] += 1;
  compare(trace, reference);
  CHECK(!measure(trace, &reference, 1)[quantity::time_shift]);  // lost
}

Tolerance tolerance(const char* metric, std::optional<double> at_most, std::optional<double> at_least) {
  return {"any", metric, 1, at_most, at_least};
}

void tolerances_are_kept_or_not() {
  Metrics metrics;
  CHECK(judge(tolerance("max_error_q", 1, {}), metrics) == Judgement::failed);  // no reference: nothing is promised
  CHECK(judge(tolerance("divergence_time", {}, 1), metrics) == Judgement::failed);
  metrics[quantity::max_error_q] = 0.5;
  CHECK(judge(tolerance("max_error_q", 0.5, {}), metrics) == Judgement::kept);
  CHECK(judge(tolerance("max_error_q", 0.6, 0.4), metrics) == Judgement::kept);
  CHECK(judge(tolerance("max_error_q", 0.4, {}), metrics) == Judgement::failed);
  CHECK(judge(tolerance("max_error_q", {}, 0.6), metrics) == Judgement::failed);
  metrics[quantity::reference_uncertainty] = 0.15;
  CHECK(judge(tolerance("max_error_q", 0.6, {}), metrics) == Judgement::undecided);
  CHECK(judge(tolerance("max_error_q", {}, 0.4), metrics) == Judgement::undecided);
  CHECK(judge(tolerance("max_error_q", 0.3, {}), metrics) == Judgement::failed);
  CHECK(judge(tolerance("max_error_q", 0.7, 0.3), metrics) == Judgement::kept);
  CHECK(judge(tolerance("divergence_time", {}, 1), metrics) == Judgement::kept);  // compared, never lost
  CHECK(judge(tolerance("divergence_time", 5, {}), metrics) == Judgement::failed);
  CHECK_EQUAL(judged_value(tolerance("divergence_time", {}, 1), metrics).value(), infinity);
  metrics[quantity::divergence_time] = 3;
  CHECK(judge(tolerance("divergence_time", {}, 3), metrics) == Judgement::kept);
  CHECK(judge(tolerance("divergence_time", {}, 3.1), metrics) == Judgement::failed);
  metrics[quantity::max_error_q] = infinity;
  CHECK(judge(tolerance("max_error_q", {}, 1), metrics) == Judgement::failed);  // blown up is not "at least 1"
  CHECK_THROWS(judge(tolerance("speed", 1, {}), metrics), UserError, "no metric named 'speed'");
}

// By hand, with one value far off, which moves a mean and a standard deviation and no median.
void repeated_timings_have_a_middle_and_a_spread() {
  CHECK_EQUAL(median({16, 1, 8, 2, 4}), 4.0);
  CHECK_EQUAL(median({8, 1, 2, 4}), 3.0);
  CHECK_EQUAL(median_absolute_deviation({16, 1, 8, 2, 4}), 3.0);  // 12, 3, 4, 2 and 0 from 4
  CHECK_EQUAL(median_absolute_deviation({8, 1, 2, 4}), 1.5);      // 5, 2, 1 and 1 from 3
  CHECK_EQUAL(median_absolute_deviation({7}), 0.0);
}

// Of normal noise the interval holds the true median 19 times of 20, a little less often where 101 values have to tell
// its width: 0.942 measured, and 4000 tries are good to 0.004 (one sigma).
void the_medians_interval_is_one_of_95_percent() {
  std::mt19937_64 bits(1);
  std::normal_distribution<double> noise(3, 2);
  constexpr int tries = 4000;
  int held = 0;
  std::vector<double> values(101);
  for (int i = 0; i < tries; ++i) {
    for (double& value : values) value = noise(bits);
    held += std::fabs(median(values) - 3) <= median_half_width(values) ? 1 : 0;
  }
  CHECK_BETWEEN(static_cast<double>(held) / tries, 0.93, 0.955);
}

}  // namespace

int main() {
  frames_are_right_handed();
  a_turning_link_is_measured_exactly("single_pendulum", 0.3, 7);
  a_turning_link_is_measured_exactly("single_pendulum", -40, -25);
  a_turning_link_is_measured_exactly("wall_pendulum", 0.3, 7);
  a_turning_link_is_measured_exactly("wall_pendulum", 3.1, -25);
  relative_angles_of_two_links();
  sparse_rows_keep_their_turns();
  faults_of_the_pose_show();
  a_broken_row_stays_broken();
  errors_are_differences_from_the_reference();
  other_times_are_refused();
  drift_is_counted_from_the_start();
  not_a_number_is_never_small();
  a_run_that_ended_early_is_lost();
  reactions_count_without_contact_and_after_the_first_row();
  a_clock_that_is_ahead_shows();
  tolerances_are_kept_or_not();
  repeated_timings_have_a_middle_and_a_spread();
  the_medians_interval_is_one_of_95_percent();
  return odeval::test::verdict();
}
