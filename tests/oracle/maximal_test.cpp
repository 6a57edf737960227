// Newton-Euler with Lagrange multipliers (report 5.3): order, joints, forces and energy against the reference.
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

catalogue::Evaluation run(const Scenario& scenario, std::string_view method) {
  return catalogue::Evaluator(scenario).evaluate(catalogue::find_method(method));
}

Metrics metrics(const Scenario& scenario, std::string_view method) {
  catalogue::Evaluator evaluator(scenario);
  return evaluator.measure(evaluator.evaluate(catalogue::find_method(method)), scenario.duration_s);
}

Scenario with_feedback(std::string_view name, double duration_s, double step_s, double ks, double kd) {
  Scenario scenario = test::report_scenario(name, duration_s, step_s);
  scenario.maximal = {ks, kd};
  return scenario;
}

/// No two numbers alike, so that a mass, side, angle or rate in the wrong place shows.
Scenario uneven(std::string_view name, double duration_s, double step_s) {
  Scenario scenario = test::report_scenario(name, duration_s, step_s);
  const Link links[] = {{1.7, 0.8, 0.25, 0.06}, {0.6, 1.3, 0.05, 0.4}};
  const double angles[] = {0.3, 0.9};
  const double rates[] = {1.1, -2.3};
  change_planar(scenario, [&](PlanarView& view) {
    const std::size_t n = view.links.size();
    view.links.assign(links, links + n);
    view.q0.assign(angles, angles + n);
    view.qd0.assign(rates, rates + n);
  });
  return scenario;
}

// Without feedback the angles' accelerations are functions of the angles alone, whatever the joints have drifted: both
// methods turn the links exactly as their twins in generalized coordinates do. Half a second amplifies rounding to
// 2e-15 (measured).
void check_twins_without_feedback() {
  for (const auto& [ours, twin] : {std::pair{"maximal-euler", "lagrange-euler"}, {"maximal-rk4", "lagrange-rk4"}}) {
    Scenario scenario = uneven("double_pendulum", 0.5, 1e-3);
    scenario.maximal = {0, 0};
    const Trace a = run(scenario, ours).trace;
    const Trace b = run(scenario, twin).trace;
    double largest = 0;
    for (std::size_t k = 0; k < a.rows(); ++k) {
      for (std::size_t i = 0; i < 2; ++i) largest = std::fmax(largest, std::fabs(a.q[i][k] - b.q[i][k]));
    }
    std::printf("%s and %s part by %.2g rad\n", ours, twin, largest);
    CHECK_BETWEEN(largest, 0, 1e-12);
  }
}

struct Order {
  const char* method;
  double step_s;  // the coarsest
  double least;   // order
  double most;
};

void check_order(const Order& order, const Scenario& coarse) {
  double error[3];
  double force[3];
  for (int k = 0; k < 3; ++k) {
    Scenario scenario = coarse;
    scenario.step_s = order.step_s / (1 << k);
    const Metrics found = metrics(scenario, order.method);
    error[k] = found[quantity::max_error_q].value();
    force[k] = found[quantity::max_reaction_error].value();
  }
  const double orders[] = {std::log2(error[0] / error[1]), std::log2(error[1] / error[2]),
                           std::log2(force[0] / force[1]), std::log2(force[1] / force[2])};
  std::printf("%s: errors %.3g %.3g %.3g rad, order %.2f %.2f; forces %.3g %.3g %.3g N, order %.2f %.2f\n",
              order.method, error[0], error[1], error[2], orders[0], orders[1], force[0], force[1], force[2], orders[2],
              orders[3]);
  for (const double found : orders) CHECK_BETWEEN(found, order.least, order.most);
}

// Measured: 0.999 to 1.006, and 4.00 to 4.03, where the feedback's time constant of 50 ms adds h over it to the next
// term. 1 mm in a length, g 9.8 or a force of the wrong sign leaves errors that do not shrink with h.
void check_orders() {
  for (const char* name : {"single_pendulum", "double_pendulum"}) {
    for (const auto& scenario : {test::report_scenario(name, 1.0, 1e-3), uneven(name, 0.5, 1e-3)}) {
      check_order({"maximal-euler", 2.5e-4, 0.97, 1.03}, scenario);
      check_order({"maximal-rk4", 2e-3, 3.95, 4.1}, scenario);
    }
  }
}

// Without feedback the gap grows, with it it does not: over the second half of the run it is no larger than over the
// first, give or take what the motion does. Explicit Euler; the stronger the feedback, the smaller the gap.
void check_gaps() {
  const auto largest = [](const Trace& trace, double from_s, double to_s) {
    double gap = 0;
    for (std::size_t k = 0; k < trace.rows(); ++k) {
      if (trace.t[k] >= from_s && trace.t[k] <= to_s) gap = std::fmax(gap, trace.gap[k]);
    }
    return gap;
  };
  // One link, so that no chaos blurs the picture.
  const Trace open = run(with_feedback("single_pendulum", 10, 1e-3, 0, 0), "maximal-euler").trace;
  const Trace held = run(with_feedback("single_pendulum", 10, 1e-3, 400, 40), "maximal-euler").trace;
  std::printf("gap of one link: %.3g m, then %.3g m; held %.3g m, then %.3g m\n", largest(open, 0, 5),
              largest(open, 5, 10), largest(held, 0, 5), largest(held, 5, 10));
  CHECK(largest(open, 5, 10) > 1.5 * largest(open, 0, 5));
  CHECK(largest(held, 5, 10) < 1.5 * largest(held, 0, 5));
  CHECK(largest(held, 0, 10) < largest(open, 0, 10) / 10);
  CHECK(largest(run(with_feedback("single_pendulum", 10, 1e-3, 1e4, 200), "maximal-euler").trace, 0, 10) <
        largest(held, 0, 10) / 2);
  // Runge-Kutta over 10 s of the double pendulum: 8.8e-7 m without, 1.2e-9 m with.
  const double rk4_open =
      metrics(with_feedback("double_pendulum", 10, 1e-3, 0, 0), "maximal-rk4")[quantity::max_gap].value();
  const double rk4_held =
      metrics(with_feedback("double_pendulum", 10, 1e-3, 400, 40), "maximal-rk4")[quantity::max_gap].value();
  CHECK_BETWEEN(rk4_open / rk4_held, 100, 3000);
}

// Joints that do no work: the energy's drift is the integrator's alone.
void check_energy() {
  CHECK_BETWEEN(*metrics(test::report_scenario("double_pendulum", 3, 1e-3), "maximal-rk4")[quantity::max_energy_drift],
                0, 2e-7);
  const double coarse =
      *metrics(test::report_scenario("double_pendulum", 1, 5e-4), "maximal-euler")[quantity::max_energy_drift];
  const double fine =
      *metrics(test::report_scenario("double_pendulum", 1, 2.5e-4), "maximal-euler")[quantity::max_energy_drift];
  CHECK_BETWEEN(coarse / fine, 1.8, 2.2);
}

// A feedback too stiff for the step is no stable one (h > 4/kd): the run ends, and says so.
void check_divergence_is_said() {
  const catalogue::Evaluation evaluation = run(with_feedback("double_pendulum", 10, 1e-3, 9e6, 6000), "maximal-euler");
  CHECK(evaluation.outcome.diverged);
  CHECK(evaluation.outcome.reason.find("left the finite numbers in the step from t = ") != std::string::npos);
  CHECK(evaluation.trace.rows() < 10001);
  CHECK_EQUAL(static_cast<long>(evaluation.trace.rows()),
              evaluation.outcome.steps);  // row 0, and all but the last step
}

// The half-step start is for those who step as ODE does.
void check_start_is_as_given() {
  Scenario scenario = test::report_scenario("double_pendulum", 0.1, 1e-3);
  scenario.ode.start = Start::half_step;
  CHECK_EQUAL(run(scenario, "maximal-rk4").trace.qd[0][0], 0.0);
  CHECK_EQUAL(run(scenario, "maximal-euler").trace.qd[0][0], 0.0);
  CHECK(run(scenario, "maximal-ode-step").trace.qd[0][0] != 0);
}

}  // namespace

int main() {
  check_twins_without_feedback();
  check_orders();
  check_gaps();
  check_energy();
  check_divergence_is_said();
  check_start_is_as_given();
  return test::verdict();
}
