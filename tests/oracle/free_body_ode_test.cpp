// ODE's step of a free body: what it is, what it therefore misses, and what single precision leaves of it.
#include <Eigen/Geometry>
#include <cstring>
#include <numbers>

#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "reference/closed_form/rotation.hpp"
#include "reference/maximal/ode_step.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using reference::maximal::Gyroscopic;
using reference::maximal::OdeStep;
using reference::maximal::OdeStepSettings;

Scenario read(const std::string& name, const std::vector<Override>& overrides = {}) {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return read_scenario(find_scenario(name, catalogue::scenario_folder()), overrides, names);
}

Metrics metrics_of(const Scenario& scenario, const char* method, double until_s) {
  catalogue::Evaluator evaluator(scenario);
  return evaluator.measure(evaluator.evaluate(catalogue::find_method(method)), until_s);
}

Vector3d vector_of(const std::array<Column, 3>& columns, std::size_t row) {
  return {columns[0][row], columns[1][row], columns[2][row]};
}

/// What the rebuilt step is broken by.
struct Change {
  Gyroscopic gyroscopic = Gyroscopic::implicit_linear;
  double gravity = 0;                   // m/s², on top
  Vector3d moments = Vector3d::Ones();  // factors
};

/// Largest deviation of one rebuilt step from ODE's, over all rows of a run: each step starts from ODE's own row.
/// Relative to 1 or the value, whichever is greater.
double deviation(const Scenario& scenario, const Change& change = {}) {
  const Trace trace = catalogue::Evaluator(scenario).evaluate(catalogue::find_method("ode-step-double")).trace;
  OdeStepSettings settings;
  settings.gravity = Vector3d(0, 0, -scenario.gravity - change.gravity);
  settings.gyroscopic = change.gyroscopic;
  OdeStep step(settings);
  const Body& what = scenario.mechanism.bodies[0];
  reference::maximal::Body body;
  body.mass = what.mass_kg;
  const Vec3 moments = what.uniform_moments_kgm2();
  body.inertia = Vector3d(moments[0], moments[1], moments[2]).cwiseProduct(change.moments).asDiagonal();
  step.add_body(body);

  const BodyColumns& rows = trace.bodies[0];
  const auto rotation_at = [&](std::size_t k) {
    Matrix3d r;
    for (int i = 0; i < 9; ++i) r(i / 3, i % 3) = rows.rotation[static_cast<std::size_t>(i)][k];
    return r;
  };
  double worst = 0;
  const auto compare = [&](const auto& rebuilt, const auto& wanted) {
    for (Eigen::Index i = 0; i < wanted.size(); ++i) {
      worst = std::fmax(worst, std::fabs(rebuilt(i) - wanted(i)) / std::fmax(1, std::fabs(wanted(i))));
    }
  };
  for (std::size_t k = 0; k + 1 < trace.rows(); ++k) {
    auto& now = step.body(0);
    now.position = vector_of(rows.position, k);
    now.orientation = Quaterniond(rotation_at(k));
    now.rotation = rotation_at(k);
    now.velocity = vector_of(rows.velocity, k);
    now.spin = vector_of(rows.spin, k);
    step.step(scenario.step_s);
    compare(now.position, vector_of(rows.position, k + 1));
    compare(now.rotation.reshaped().eval(), rotation_at(k + 1).reshaped().eval());
    compare(now.velocity, vector_of(rows.velocity, k + 1));
    compare(now.spin, vector_of(rows.spin, k + 1));
  }
  return worst;
}

// The scheme rebuilt (ode_step.hpp) is the scheme. Of thin bodies its order of operations multiplies rounding by the
// ratio of the moments twice: once in the difference (I (I - h [L]x)^-1 - 1) L / h, once where the small moment divides
// what is left of it (other orders do not: gyroscopic_rounding.hpp). The rebuilt step has that order and roundings of
// its own, so the two may differ by 2.2e-16 5000^2 = 6e-9 at 1:100 (1.9e-9 measured) and by 6e-5 at 1:1000 (6.9e-6).
void the_discrete_law() {
  CHECK_BETWEEN(deviation(read("free_box")), 0, 1e-12);
  CHECK_BETWEEN(
      deviation(read("thin_body", {{"bodies.0.aspect", "10", "--set"}, {"bodies.0.spin", "[2.0, 1.0, 0.5]", "--set"}})),
      0, 1e-12);
  CHECK_BETWEEN(deviation(read("thin_body")), 0, 6e-9);
  CHECK_BETWEEN(deviation(read("thin_body", {{"bodies.0.aspect", "1000", "--set"}})), 0, 6e-5);
  Scenario off = read("free_box");
  off.ode.gyroscopic = false;
  CHECK_BETWEEN(deviation(off, {.gyroscopic = Gyroscopic::none}), 0, 1e-12);

  // ... and nothing else is.
  const Scenario box = read("free_box");
  CHECK(deviation(box, {.gyroscopic = Gyroscopic::none}) > 1e-4);
  CHECK(deviation(box, {.gyroscopic = Gyroscopic::explicit_torque}) > 1e-7);
  CHECK(deviation(box, {.gravity = 0.01}) > 1e-9);
  CHECK(deviation(box, {.moments = {1, 1.0001, 1}}) > 1e-8);
  CHECK(deviation(off) > 1e-4);
}

// It falls too far by g h t / 2, to the rounding of as many steps.
void falls_too_far() {
  for (const double h : {1e-4, 5e-4, 1e-3}) {
    for (const char* method : {"ode-step-double", "ode-quickstep-double"}) {
      Scenario scenario = read("free_box");
      scenario.step_s = h;
      const double error = metrics_of(scenario, method, 10)[quantity::max_error_position].value();
      const double steps = 10 / h;
      CHECK_NEAR(error, 9.8 * h * 10 / 2, steps * 5.7e-14);  // half an ulp at 256 to 512 m, all one way
    }
  }
  Scenario other = read("free_box");
  other.gravity = 9.81;  // what a wrong g would do to the check above
  CHECK(std::fabs(metrics_of(other, "ode-step-double", 10)[quantity::max_error_position].value() - 0.049) > 1e-5);
}

// In single precision the same, within half an ulp of position and speed a step, all one way: 3e-5 m at 256 to 512 m
// and 7.6e-6 m/s at 64 to 128 m/s.
void falls_in_single_precision() {
  if (!test::in_this_build("ode-step-single")) return;
  for (const double h : {1e-4, 5e-4, 1e-3}) {
    Scenario scenario = read("free_box");
    scenario.step_s = h;
    const double error = metrics_of(scenario, "ode-step-single", 10)[quantity::max_error_position].value();
    const double steps = 10 / h;
    const double allowed = steps * (1.5e-5 + 3.8e-6 * 10 / 2);
    std::printf("single precision, h = %g s: %.4g m off, of %.4g m that half an ulp a step may come to\n", h,
                std::fabs(error - 9.8 * h * 10 / 2), allowed);
    CHECK_NEAR(error, 9.8 * h * 10 / 2, allowed);
  }
}

// The "simple" case turns about a principal axis: by 2 atan(w h / 2) a step.
void turns_too_little() {
  const Scenario scenario = read("free_box", {{"gravity", "0.0", "--set"},
                                              {"bodies.0.velocity", "[-0.9, 0.4, 0.1]", "--set"},
                                              {"bodies.0.spin", "[0.5, 0.0, 0.0]", "--set"}});
  const Metrics metrics = metrics_of(scenario, "ode-step-double", 10);
  const double wanted = 10 * 0.5 - 1e4 * 2 * std::atan(0.5 * 1e-3 / 2);
  CHECK_BETWEEN(wanted, 1.04e-7, 1.05e-7);
  CHECK_NEAR(metrics[quantity::max_error_turn].value(), wanted, 1e-11);  // rounding of 10000 steps
  CHECK_NEAR(metrics[quantity::max_error_position].value(), 0, 1e-11);
  CHECK_NEAR(*metrics[quantity::max_energy_drift], 0, 1e-11);
  CHECK_NEAR(metrics[quantity::max_angular_momentum_drift].value(), 0, 1e-12);
}

// Tumbling is first order. The next term leaves 1.95 to 2.0 between 1 and 0.1 ms; a change of order would be 4 or 1.
void tumbles_in_first_order() {
  const auto at = [](double h, const char* method) {
    Scenario scenario = read("free_box");
    scenario.step_s = h;
    scenario.duration_s = 1;
    return metrics_of(scenario, method, 1);
  };
  for (const char* method : {"ode-step-double", "ode-step-single"}) {
    if (!test::in_this_build(method)) continue;
    const Metrics coarse = at(1e-3, method);
    const Metrics fine = at(5e-4, method);
    const double turns = coarse[quantity::max_error_turn].value() / fine[quantity::max_error_turn].value();
    const double momentum =
        coarse[quantity::max_angular_momentum_drift].value() / fine[quantity::max_angular_momentum_drift].value();
    std::printf("%s: turn %.4f, momentum %.4f, halving the step\n", method, turns, momentum);
    CHECK_BETWEEN(turns, 1.9, 2.1);
    CHECK_BETWEEN(momentum, 1.9, 2.1);
  }
}

// Without the term a torque-free body keeps its spin in the world and its momentum goes astray.
void the_key_takes_the_term_away() {
  Scenario scenario = read("free_box");
  scenario.ode.gyroscopic = false;
  scenario.duration_s = 1;
  for (const char* method : {"ode-step-double", "ode-quickstep-double"}) {
    catalogue::Evaluator evaluator(scenario);
    const auto run = evaluator.evaluate(catalogue::find_method(method));
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK_EQUAL(run.trace.bodies[0].spin[k].back(), scenario.mechanism.bodies[0].spin_rad_s[k]);
    }
    CHECK(evaluator.measure(run, 1)[quantity::max_error_turn].value() > 0.1);
  }
}

}  // namespace

int main() {
  the_discrete_law();
  falls_too_far();
  falls_in_single_precision();
  turns_too_little();
  tumbles_in_first_order();
  the_key_takes_the_term_away();
  return test::verdict();
}
