// The books of a mechanism's energy: what motors, stops, springs, dampers, torques, controllers and contacts do, beside
// closed forms, and what is left when all is told: of the reference its own error, of ODE what goes with the step.
#include <algorithm>
#include <cmath>
#include <string>

#include "catalogue/evaluation.hpp"
#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;

Names names() {
  Names all{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) all.metrics.emplace_back(row.name);
  return all;
}

Scenario scenario_of(const char* name, double duration_s) {
  Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names());
  scenario.duration_s = duration_s;
  return scenario;
}

// An arm between stops: a motor that holds the shoulder against its weight as long as it can, a spring and a damper in
// the elbow, and a controller that pulls it.
Scenario stopped_arm() {
  return ScenarioFile("arm.toml", R"(problem = "mechanism"
duration = 1.0
[[bodies]]
name = "upper"
mass = 2.0
size = [0.5, 0.1, 0.1]
position = [0.25, 0.0, 1.0]
[[bodies]]
name = "lower"
mass = 1.0
size = [0.4, 0.08, 0.06]
position = [0.7, 0.0, 1.0]
[[joints]]
name = "shoulder"
kind = "hinge"
parent = "world"
child = "upper"
anchor = [0.0, 0.0, 1.0]
axis = [0.0, 1.0, 0.0]
stops = [-0.5, 0.7]
stop_restitution = 0.5
motor = { velocity = 0.5, force = 3.0 }
[[joints]]
name = "elbow"
kind = "hinge"
parent = "upper"
child = "lower"
anchor = [0.5, 0.0, 1.0]
axis = [0.0, 1.0, 0.0]
[[springs]]
joint = "elbow"
stiffness = 20.0
damping = 0.2
rest = 0.1
[[controllers]]
joint = "elbow"
kp = 5.0
kd = 0.1
target = 0.4
[ode]
cfm = 1e-10
)")
      .read({}, names());
}

struct Books {
  catalogue::Evaluation run;
  double unaccounted = 0;  // at most
  double turnover = 0;     // the largest size of a work or of the kinetic energy, J

  double at_end(Work kind) const { return run.trace.works[static_cast<std::size_t>(kind)].back(); }
};

Books books_of(Scenario scenario, const char* method, double step_s = 0) {
  if (step_s > 0) scenario.step_s = step_s;
  catalogue::Evaluator evaluator(scenario);
  Books books{evaluator.evaluate(catalogue::find_method(method)), 0, 0};
  CHECK(!books.run.outcome.diverged);
  const Trace& trace = books.run.trace;
  CHECK_EQUAL(trace.works.size(), work_names.size());
  CHECK_EQUAL(trace.unaccounted.size(), trace.rows());
  for (const double left : trace.unaccounted) books.unaccounted = std::fmax(books.unaccounted, std::fabs(left));
  for (const double energy : trace.kinetic) books.turnover = std::fmax(books.turnover, energy);
  for (const Column& work : trace.works) {
    for (const double value : work) books.turnover = std::fmax(books.turnover, std::fabs(value));
  }
  return books;
}

/// Motors at their limits and joints on their stops as the reference has them, to what goes with the step.
void check_joints(const catalogue::Evaluation& ode, const catalogue::Evaluation& truth, double step_s) {
  const Outcome& now = ode.outcome;
  const Outcome& wanted = truth.outcome;
  CHECK_EQUAL(now.motors.size(), wanted.motors.size());
  for (std::size_t i = 0; i < std::min(now.motors.size(), wanted.motors.size()); ++i) {
    std::printf("motor: %.6g of the time at its limit, %.6g in the reference\n", now.motors[i].share,
                wanted.motors[i].share);
    CHECK_EQUAL(now.motors[i].joint, wanted.motors[i].joint);
    CHECK_NEAR(now.motors[i].share, wanted.motors[i].share, 5 * step_s);
    CHECK_EQUAL(now.motors[i].first_s.has_value(), wanted.motors[i].first_s.has_value());
    if (wanted.motors[i].first_s) CHECK_NEAR(now.motors[i].first_s.value(), *wanted.motors[i].first_s, 2 * step_s);
  }
  CHECK(now.strikes.empty() == wanted.strikes.empty());
  if (now.strikes.empty() || wanted.strikes.empty()) return;
  const StopStrike& first = now.strikes.front();
  const StopStrike& is = wanted.strikes.front();
  std::printf("stop: struck at %.6g s with %.4g, leaves with %.4g; %.6g s, %.4g, %.4g in the reference\n", first.t,
              first.rate_before, first.rate_after, is.t, is.rate_before, is.rate_after);
  CHECK(first.joint == is.joint && first.low == is.low);
  CHECK_NEAR(first.t, is.t, 2 * step_s);
  CHECK_NEAR(first.rate_before, is.rate_before, 0.02 * std::fabs(is.rate_before));
  CHECK_NEAR(is.rate_after, -0.5 * is.rate_before, 1e-9 * std::fabs(is.rate_before));  // of both files' stops
}

/// Every kind of work comes to what it is in the reference, all together by the step: single ones pass it by.
void check_works(const Books& coarse, const Books& fine, const Books& truth) {
  double all_off = 0;
  double all_finer = 0;
  for (std::size_t kind = 0; kind < work_names.size(); ++kind) {
    const double wanted = truth.at_end(static_cast<Work>(kind));
    const double off = std::fabs(coarse.at_end(static_cast<Work>(kind)) - wanted);
    const double finer = std::fabs(fine.at_end(static_cast<Work>(kind)) - wanted);
    std::printf("  %s: %.6g J, ODE %.3g J off at h, %.3g J at half of it\n", std::string(work_names[kind]).c_str(),
                wanted, off, finer);
    CHECK_BETWEEN(finer, 0, 0.01 * truth.turnover);  // 0.006 measured, of the arm's controller
    all_off += off;
    all_finer += finer;
  }
  CHECK_BETWEEN(all_finer, 0, 0.65 * all_off);  // 0.42 to 0.50 measured
}

/// The reference closes its books to a part of what went through them, 4e-13 measured; ODE by the step.
void check_books(const char* what, const Scenario& scenario, double of_turnover, double step_s) {
  const Books truth = books_of(scenario, "mechanism-cvode");
  std::printf("%s: reference %.3g J of %.3g J\n", what, truth.unaccounted, truth.turnover);
  CHECK_BETWEEN(truth.unaccounted, 0, of_turnover * truth.turnover);
  if (step_s == 0) return;
  const Books coarse = books_of(scenario, "ode-step-double", step_s);
  const Books fine = books_of(scenario, "ode-step-double", step_s / 2);
  std::printf("%s: ODE %.3g J at h = %g s, %.3g J at half of it\n", what, coarse.unaccounted, step_s, fine.unaccounted);
  CHECK_BETWEEN(coarse.unaccounted / fine.unaccounted, 1.8, 2.2);
  check_works(coarse, fine, truth);
  check_joints(coarse.run, truth.run, step_s);
}

// The elbow of the arm, by its columns: they count as its file does, the child against the parent. The controller looks
// at the beginning of a step, and so do ODE's spring and damper.
void check_elbow() {
  for (const char* method : {"mechanism-cvode", "ode-step-double"}) {
    const Books books = books_of(stopped_arm(), method);
    const Trace& trace = books.run.trace;
    CHECK_EQUAL(trace.joint_names[1], "elbow");
    const JointColumns& elbow = trace.joints[1];
    const auto spring = [&](std::size_t k) { return -20 * (elbow.q[k] - 0.1) - 0.2 * elbow.qd[k]; };
    const auto controller = [&](std::size_t k) { return 5 * (0.4 - elbow.q[k]) - 0.1 * elbow.qd[k]; };
    const bool by_ode = std::string(method) == "ode-step-double";
    double work_off = 0;
    double torque_off = 0;
    for (std::size_t k = 1; k < trace.rows(); ++k) {
      const double held = 10 * (0.1 * 0.1 - (elbow.q[k] - 0.1) * (elbow.q[k] - 0.1));
      work_off = std::fmax(work_off, std::fabs(trace.works[static_cast<std::size_t>(Work::springs)][k] - held));
      torque_off = std::fmax(torque_off, std::fabs(elbow.load[k] - spring(by_ode ? k - 1 : k) - controller(k - 1)));
    }
    std::printf("elbow by %s: work of its spring %.3g J, torque %.3g N m off its columns\n", method, work_off,
                torque_off);
    CHECK_BETWEEN(work_off, 0, 1e-13);    // rounding: 5e-15 measured
    CHECK_BETWEEN(torque_off, 0, 1e-12);  // likewise 2e-14
  }
}

}  // namespace

int main() {
  check_elbow();
  check_books("arm between stops", stopped_arm(), 2e-12, 1e-3);
  check_books("cart and pole", scenario_of("cart_pole", 1.0), 2e-12, 1e-3);
  check_books("motor that lifts", scenario_of("motor_lift", 1.0), 2e-12, 0);
  check_books("PUMA under PD", scenario_of("puma560", 0.2), 2e-12, 1e-3);
  check_books("governor on struts", scenario_of("iftomm_governor", 0.02), 2e-12, 0);
  check_books("balls that strike", scenario_of("newtons_cradle", 0.5), 2e-12, 0);
  return odeval::test::verdict();
}
