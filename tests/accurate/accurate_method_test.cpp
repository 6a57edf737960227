// Method ode-rk4-double on the scenarios: order, errors, energy and gap against the reference.
#include "catalogue/paths.hpp"
#include "measure/metrics.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

struct Run {
  catalogue::Evaluation evaluation;
  Metrics metrics;
  Reference reference;
};

Run run(const Scenario& scenario, double until, const char* method = "ode-rk4-double") {
  catalogue::Evaluator evaluator(scenario);
  auto evaluation = evaluator.evaluate(catalogue::find_method(method));
  const Metrics metrics = evaluator.measure(evaluation, until);
  return {std::move(evaluation), metrics, evaluator.reference()};
}

double slope(double coarse, double fine) { return std::log2(coarse / fine); }

/// The order on the double pendulum until t = 2, from steps whose errors stand far above the reference's (1e-11 rad).
void check_order() {
  const auto error = [](double h) {
    return run(test::report_scenario("double_pendulum", 2, h), 2).metrics[quantity::max_error_q].value();
  };
  const double coarse = error(4e-3), middle = error(2e-3), fine = error(1e-3);
  std::printf("until t = 2: %.3g %.3g %.3g rad, order %.2f %.2f\n", coarse, middle, fine, slope(coarse, middle),
              slope(middle, fine));
  CHECK_BETWEEN(slope(coarse, middle), 3.9, 5);
  CHECK_BETWEEN(slope(middle, fine), 3.9, 5);
}

/// Order 8, at steps ten times as long: the slope between errors that stand above the reference's, and the promise of
/// the README: 1e-8 rad until t = 3 from 12 evaluations a step of 10 ms, where order 4 takes 4 a step of 1 ms.
void check_order_8() {
  const auto error = [](double h, double until) {
    return run(test::report_scenario("double_pendulum", until, h), until, "ode-rk8-double")
        .metrics[quantity::max_error_q];
  };
  const double coarse = *error(4e-2, 2), fine = *error(2e-2, 2);
  const double at_10_ms = *error(1e-2, 3);
  std::printf("order 8 until t = 2: %.3g %.3g rad, order %.2f; until t = 3 at 10 ms: %.3g rad\n", coarse, fine,
              slope(coarse, fine), at_10_ms);
  CHECK_BETWEEN(slope(coarse, fine), 7, 10);
  CHECK_BETWEEN(at_10_ms, 0, 1e-8);
}

/// The promises of the README at h = 0.001.
void check_double_pendulum() {
  const Run ten = run(test::report_scenario("double_pendulum", 10, 1e-3), 10);
  const Metrics three = measure(ten.evaluation.trace, &ten.reference, 3);
  std::printf("until t = 3: %.3g rad +- %.2g; 10 s: drift %.3g J, gap %.3g m\n", *three[quantity::max_error_q],
              *three[quantity::reference_uncertainty], *ten.metrics[quantity::max_energy_drift],
              *ten.metrics[quantity::max_gap]);
  CHECK_BETWEEN(*three[quantity::max_error_q] + *three[quantity::reference_uncertainty], 0, 1e-8);
  CHECK_BETWEEN(*ten.metrics[quantity::max_energy_drift], 0, 1e-6);
  CHECK_BETWEEN(*ten.metrics[quantity::max_gap], 0, 1e-12);
  CHECK_BETWEEN(*ten.metrics[quantity::max_out_of_plane], 0, 1e-12);
  // Of up to 187 N, third order: 1.4e-4 N measured, dWorldStep 2.6 N.
  std::printf("joint forces off by %.3g N\n", *three[quantity::max_reaction_error]);
  CHECK_BETWEEN(*three[quantity::max_reaction_error], 1e-5, 1e-3);
}

/// Every impact within 1e-9 s of the reference (9.9e-12 s measured), which is as near to the closed form
/// (wall_lagrange_test), and the energy after all bounces (4.5e-11 J measured).
void check_wall() {
  const Run bounced = run(test::report_scenario("wall_pendulum", 5, 1e-3), 5);
  const auto& impacts = bounced.evaluation.outcome.impacts;
  CHECK_EQUAL(impacts.size(), std::size_t{5});
  CHECK_EQUAL(impacts.size(), bounced.reference.impacts.size());
  double off = 0;
  for (std::size_t i = 0; i < std::min(impacts.size(), bounced.reference.impacts.size()); ++i) {
    const Impact& wanted = bounced.reference.impacts[i];
    off = std::max(off, std::fabs(impacts[i].t - wanted.t));
    CHECK_NEAR(impacts[i].t, wanted.t, 1e-9);
    CHECK_NEAR(impacts[i].q1, wanted.q1, 1e-7);
    CHECK_NEAR(impacts[i].qd_before, wanted.qd_before, 1e-6);
    CHECK_NEAR(impacts[i].qd_after, wanted.qd_after, 1e-6);
  }
  std::printf("wall: impacts off by %.2g s, energy by %.2g J\n", off, *bounced.metrics[quantity::max_energy_drift]);
  CHECK_BETWEEN(*bounced.metrics[quantity::max_energy_drift], 0, 1e-8);
  double contacts = 0;
  for (const double count : bounced.evaluation.trace.contacts) contacts += count;
  CHECK_EQUAL(contacts, 5.0);  // rows of steps with an impact

  // A lossy wall, and the flag that overrides it.
  Scenario lossy = test::report_scenario("wall_pendulum", 2, 1e-3);
  change_planar(lossy, [](PlanarView& view) { view.wall->restitution = 0.6; });
  const Run half = run(lossy, 2);
  CHECK_BETWEEN(*half.metrics[quantity::max_error_q], 0, 1e-8);
  lossy.ode.bounce = 0.3;
  const Impact first = run(lossy, 2).evaluation.outcome.impacts.front();
  CHECK_NEAR(-first.qd_after / first.qd_before, 0.3, 1e-10);
}

/// At equal work far better than dWorldStep: the count of evaluations stands for the time (odeval-accurate-cost).
void check_gain() {
  const double ode = run(test::report_scenario("double_pendulum", 2, 1e-4), 2, "ode-step-double")
                         .metrics[quantity::max_error_q]
                         .value();
  const double accurate =
      run(test::report_scenario("double_pendulum", 2, 4e-4), 2).metrics[quantity::max_error_q].value();
  std::printf("dWorldStep h = 1e-4: %.3g rad, accurate h = 4e-4: %.3g rad: %.3g x\n", ode, accurate, ode / accurate);
  CHECK(ode / accurate > 1e6);
}

/// A box that slides on level ground at an angle to its sides stops where Coulomb's law says: the cone is round, and
/// the moment of sticking is found: 1e-12 m off measured, with a margin of a hundred. ODE's pyramid is 0.1 m and more
/// off at the last two angles.
void check_friction() {
  for (const double angle : {0.0, 0.3, 0.78539816339744831}) {
    Description slide;
    slide.problem = &test::problem("friction_slide");
    slide.bodies = {{.mass_kg = 2,
                     .size_m = {0.4, 0.4, 0.1},
                     .position_m = {0, 0, 0.05},
                     .velocity_m_s = {2 * std::cos(angle), 2 * std::sin(angle), 0}}};
    slide.ground = GroundTable{.friction = 0.3};
    Scenario scenario = test::report_scenario("friction_slide", 1, 1e-3);
    put_bodies(scenario, slide);
    const Run stopped = run(scenario, 1);
    std::printf("box thrown at %g rad: off by %.2g m\n", angle, *stopped.metrics[quantity::max_error_position]);
    CHECK(!stopped.evaluation.outcome.diverged);
    CHECK_BETWEEN(*stopped.metrics[quantity::max_error_position], 0, 1e-10);
    CHECK_BETWEEN(*stopped.metrics[quantity::rest_time], 0.678, 0.682);  // u / (mu g) = 0.680 s, on a grid of 1 ms
  }
}

/// Both orders take every scenario file, friction, motors, stops and controllers included, but those whose joints start
/// open: these joints are springs there, and are kept closed here.
void check_scenarios() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  for (const std::string& name : scenario_names(catalogue::scenario_folder())) {
    Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names);
    scenario.duration_s = 20 * scenario.step_s;
    scenario.sample_s.reset();
    for (const char* method : {"ode-rk4-double", "ode-rk8-double"}) {
      const Features asked = features_of(scenario);
      const Features refused = asked - catalogue::find_method(method).can;
      const Features open = asked.has(Feature::open_joints) ? Features{Feature::open_joints} : Features();
      CHECK_EQUAL(name + ", " + method + ": " + listed(refused), name + ", " + method + ": " + listed(open));
      if (!refused.empty()) continue;
      const catalogue::Evaluator evaluator(scenario);
      CHECK(!evaluator.make(catalogue::find_method(method))->run(Recorder()).diverged);
    }
  }
}

}  // namespace

int main() {
  check_order();
  check_order_8();
  check_double_pendulum();
  check_wall();
  check_friction();
  check_scenarios();
  check_gain();
  return test::verdict();
}
