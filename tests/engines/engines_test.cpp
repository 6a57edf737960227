// MuJoCo, Bullet, DART and Simbody, those that this build has: the double pendulum by errors that other programs found,
// a free box by numbers that were published, trees of bodies beside the reference, loads, what blows up, what is told.
//
//   engines_test [METHOD...]   of those alone
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/engines/beside_ode.hpp"
#include "tests/engines/random_trees.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"
#ifdef ODEVAL_WITH_TREES
#include "reference/tree/tree_reference.hpp"
#endif

namespace {

using namespace odeval;

struct Known {
  std::string_view method;
  std::array<double, 3> errors;  // rad, until 1, 3 and 5 s at h = 1 ms, every 10 ms
  double digits;                 // to which they were told
};

// Programs that have nothing of odeval, around each library alone, gave these. Semi-implicit Euler in joint coordinates
// is the same motion whoever takes it.
constexpr std::array<double, 3> semi_implicit{6.82e-3, 0.161, 1.03};
constexpr std::array<double, 3> runge_kutta{5.9e-10, 6.2e-9, 4.5e-8};
constexpr double three_digits = 0.005;
constexpr double two_digits = 0.05;
constexpr Known known[] = {
    {"mujoco-euler", semi_implicit, three_digits},
    {"mujoco-implicit", {8.0e-3, 0.18, 1.1}, two_digits},
    {"mujoco-rk4", runge_kutta, two_digits},
    {"bullet-hinge-double", {4.7e-3, 8.9e-3, 5.0e-2}, two_digits},
    {"bullet-multibody-double", semi_implicit, three_digits},
    {"bullet-multibody-rk4-double", runge_kutta, two_digits},
    {"dart-step", semi_implicit, three_digits},
    {"simbody-semi-explicit", semi_implicit, three_digits},
};

std::vector<std::string> asked;  // empty: all

void double_pendulum() {
  Scenario scenario = test::report_scenario("double_pendulum", 5, 1e-3);
  scenario.sample_s = 1e-2;
  catalogue::Evaluator evaluator(scenario);
  for (const catalogue::Method* const method : test::engines(asked)) {
    const auto found = std::ranges::find(known, method->name, &Known::method);
    if (found == std::end(known)) continue;
    const Known& row = *found;
    const catalogue::Evaluation run = evaluator.evaluate(*method);
    std::array<double, 3> errors{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double until = std::array{1.0, 3.0, 5.0}[k];
      errors[k] = evaluator.measure(run, until)[quantity::max_error_q].value();
    }
    std::printf("%s: %.3g, %.3g, %.3g rad\n", row.method.data(), errors[0], errors[1], errors[2]);
    for (std::size_t k = 0; k < 3; ++k) CHECK_NEAR(errors[k] / row.errors[k], 1, row.digits);
  }
}

/// Gazebo's benchmark "boxes", as its authors' files have it for 1 ms: largest changes of the angular momentum and of
/// the energy within 10 s, of what they were at the start. Its Simbody takes two steps of ours in one.
void published_box() {
  struct Row {
    std::string_view method;
    double step_s, momentum, energy;
  };
  constexpr Row published[] = {{"bullet-hinge-double", 1e-3, 0.0124515, 0.0135785},
                               {"simbody-semi-explicit", 5e-4, 0.00643788, 0.00623412}};
  constexpr double momentum = 3.41765;  // N m s
  constexpr double energy = 368.546;    // J
  for (const catalogue::Method* const method : test::engines(asked)) {
    const auto row = std::ranges::find(published, method->name, &Row::method);
    if (row == std::end(published)) continue;
    Scenario scenario;
    scenario.duration_s = 10;
    scenario.gravity = 9.8;
    scenario.step_s = row->step_s;
    scenario.sample_s = 1e-3;
    scenario.mechanism.bodies = {
        {.shape = Box{{0.1, 0.4, 0.9}}, .mass_kg = 10, .velocity_m_s = {-2, 2, 8}, .spin_rad_s = {0.1, 5, 0.1}}};
    catalogue::Evaluator evaluator(scenario);
    const Metrics metrics = evaluator.measure(evaluator.evaluate(*method), scenario.duration_s);
    const double of_momentum = metrics[quantity::max_angular_momentum_drift].value() / momentum;
    const double of_energy = metrics[quantity::max_energy_drift].value() / energy;
    std::printf("box in %s: %.6g, %.6g\n", row->method.data(), of_momentum, of_energy);
    // Theirs took one step more, of 10000: 5e-4 off of Simbody, 1e-4 of Bullet.
    CHECK_NEAR(of_momentum / row->momentum, 1, 1e-3);
    CHECK_NEAR(of_energy / row->energy, 1, 1e-3);
  }
}

#ifdef ODEVAL_WITH_TREES

// ---- Trees of bodies beside the reference

constexpr double row_spacing_s = 0.05;

SampleGrid rows_of(double h) { return {h, std::lround(row_spacing_s / h), 11}; }

bool is_single(const catalogue::Method& method) { return method.name.ends_with("-single"); }

/// The first row shows what was given: speeds of the joints are those of the bodies, each in the world.
void begins_as_given(const catalogue::Method& method, const Motion& motion, const Reference& reference) {
  const double rounding = is_single(method) ? 1e-5 : 1e-11;  // of a dozen rad/s or m/s
  double most = 0;
  for (std::size_t i = 0; i < reference.trace.bodies.size(); ++i) {
    const BodyState& body = motion[0].bodies[i];
    const BodyColumns& wanted = reference.trace.bodies[i];
    for (std::size_t d = 0; d < 3; ++d) {
      most = std::fmax(most, std::fabs(body.velocity[d] - wanted.velocity[d][0]));
      most = std::fmax(most, std::fabs(body.spin[d] - wanted.spin[d][0]));
    }
  }
  CHECK_BETWEEN(most, 0, rounding);
}

/// Of bodies' places and attitudes over the run, m or rad.
double error(const catalogue::Method& method, Scenario scenario, const Reference& reference, double h) {
  scenario.step_s = h;
  const test::Recorded run = test::recorded(method.make, scenario, rows_of(h));
  begins_as_given(method, run.motion, reference);
  double most = 0;
  for (std::size_t k = 0; k < run.motion.size(); ++k) {
    for (std::size_t i = 0; i < scenario.mechanism.bodies.size(); ++i) {
      const BodyState& body = run.motion[k].bodies[i];
      const BodyColumns& wanted = reference.trace.bodies[i];
      for (std::size_t d = 0; d < 3; ++d) most = std::fmax(most, std::fabs(body.position[d] - wanted.position[d][k]));
      for (std::size_t d = 0; d < 9; ++d) most = std::fmax(most, std::fabs(body.rotation[d] - wanted.rotation[d][k]));
    }
  }
  return run.motion.size() == 11 ? most : std::numeric_limits<double>::quiet_NaN();
}

void tree(Scenario scenario) {
  // Ten iterations, Bullet's own, let six bodies fly apart at any step; with a thousand nothing of them is left to see.
  scenario.bullet.iterations = 1000;
  const Reference reference = reference::solve_tree(scenario, rows_of(row_spacing_s));
  std::map<std::string, double> coarse_errors;  // by method
  for (const catalogue::Method* const method : test::engines(asked)) {
    const auto at_rtol = [&](double rtol) {
      scenario.rtol = rtol;
      return error(*method, scenario, reference, row_spacing_s);
    };
    const auto at_step = [&](double h) { return error(*method, scenario, reference, h); };
    const bool first = method->order == 1;
    const double coarse = method->order == 0 ? at_rtol(1e-6) : at_step(first ? 4e-4 : 1e-3);
    coarse_errors[std::string(method->name)] = coarse;
    if (is_single(*method)) {  // whose rounding hides an order: as far off as in double precision
      const std::string name(method->name);
      const auto other = coarse_errors.find(name.substr(0, name.size() - 6) + "double");
      std::printf("%s in %s: %.3g\n", scenario.name.c_str(), name.c_str(), coarse);
      if (other != coarse_errors.end()) CHECK_NEAR(coarse / other->second, 1, 0.2);
      continue;
    }
    const double fine = method->order == 0 ? at_rtol(1e-9) : at_step(first ? 2e-4 : 2.5e-4);
    std::printf("%s in %s: %.3g -> %.3g\n", scenario.name.c_str(), std::string(method->name).c_str(), coarse, fine);
    if (first) {
      CHECK_BETWEEN(std::log2(coarse / fine), 0.9, 1.1);
    } else {
      // A thousandth of the tolerance: two orders of magnitude, since each step keeps well below it. A quarter of the
      // step: first order at least, which is what Bullet's Runge-Kutta has where a tree flies; MuJoCo's has second.
      // Below 1e-9 the rounding of all these steps has its part.
      CHECK(fine < coarse / (method->order == 0 ? 100 : 3.5) || fine < 1e-9);
      CHECK_BETWEEN(fine, 0, method->name == "bullet-multibody-rk4-double" ? 1e-3 : 1e-5);
    }
  }
}

/// Motors beside springs, torques and controllers, with forces that they come to: where an engine has motors.
void motors(unsigned seed) {
  Scenario scenario = test::random_tree(seed, true);
  scenario.bullet.iterations = 1000;
  test::Random draw(seed + 2000);
  for (Joint& joint : scenario.mechanism.joints) {
    if (joint.loaded()) joint.motor = Motor{draw.within(-1, 1), draw.within(0.2, 2)};
  }
  const Reference reference = reference::solve_tree(scenario, rows_of(row_spacing_s));
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario) || is_single(*method)) continue;
    const double coarse = error(*method, scenario, reference, 2e-4);
    const double fine = error(*method, scenario, reference, 1e-4);
    std::printf("%s with motors in %s: %.3g -> %.3g\n", scenario.name.c_str(), std::string(method->name).c_str(),
                coarse, fine);
    CHECK_BETWEEN(std::log2(coarse / fine), 0.8, 1.25);  // a motor comes to its limit anywhere in a step; 0.98 to 1.12
  }
}

/// A controller that looks once a step is one that looks always, but for the step.
void sampled_controllers() {
  Scenario scenario = test::random_tree(5, true);
  scenario.bullet.iterations = 1000;
  scenario.rtol = 1e-9;
  const Reference reference = reference::solve_tree(scenario, rows_of(row_spacing_s));
  for (Joint& joint : scenario.mechanism.joints) {
    for (Controller& controller : joint.controllers) controller.sampled = true;
  }
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (is_single(*method)) continue;
    const double coarse = error(*method, scenario, reference, 2e-3);
    const double fine = error(*method, scenario, reference, 1e-3);
    std::printf("sampled in %s: %.3g -> %.3g\n", std::string(method->name).c_str(), coarse, fine);
    CHECK_BETWEEN(std::log2(coarse / fine), 0.9, 1.1);
  }
}

#endif

/// A spring that no explicit step of 10 ms follows: the run ends early and says when. (Of a slider: Bullet lets no body
/// turn by more than a quarter in a step, so that a hinge would never end.)
void what_blows_up_says_so() {
  Scenario scenario;
  scenario.duration_s = 5;
  scenario.step_s = 1e-2;
  scenario.mechanism.bodies = {{.shape = Box{{0.1, 0.2, 0.3}}, .mass_kg = 1, .position_m = {0, 0, -0.5}}};
  scenario.mechanism.joints = {{.kind = SliderJoint{{}, {0, 1, 0}}, .first = 0, .second = {}}};
  scenario.mechanism.joints[0].springs = {{.stiffness = 1e9, .rest = 0.1}};
  const SampleGrid grid{1e-2, 1, 501};
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (method->order == 0) continue;  // it goes by small steps
    const test::Recorded run = test::recorded(method->make, scenario, grid);
    std::printf("%s: %s\n", std::string(method->name).c_str(), run.outcome.reason.c_str());
    CHECK(run.outcome.diverged);
    CHECK(run.motion.size() < 501);
    CHECK(run.outcome.reason.find(" in the step from t = ") != std::string::npos);
  }
}

/// Its version, and more than that.
void options_are_told() {
  const Scenario scenario = test::report_scenario("double_pendulum", 1, 1e-3);
  for (const catalogue::Method* const method : test::engines(asked)) {
    const Told told = method->make(scenario, sample_grid(scenario))->told();
    CHECK(told.size() > 2);
    CHECK_EQUAL(told.front().first, "version");
  }
}

void missing_ones_say_what_would_bring_them() {
  for (const catalogue::Method& method : catalogue::methods()) {
    if (!method.tells || method.make != nullptr) continue;
    CHECK_THROWS(catalogue::find_method(method.name), UserError, "is left out: this build has no ");
    const bool dart = method.name.starts_with("dart");  // which alone has to be asked for
    CHECK_EQUAL(method.why_missing.find("install-deps --engines ") != std::string_view::npos, dart);
    CHECK(method.why_missing.find("scripts/install-deps ") != std::string_view::npos);
  }
}

/// What an engine is not given is refused by its name.
void refusals() {
  for (const catalogue::Method* const method : test::engines(asked)) {
    Scenario scenario = test::random_tree(1, false);
    CHECK(catalogue::does(*method, scenario));
    scenario.mechanism.joints[0].opening_m = {0, 0, 1e-3};
    CHECK_THROWS(catalogue::require_does(*method, scenario, "--method"), UserError, "joints that start open");
    Scenario loop = test::random_tree(1, false);
    loop.mechanism.joints.push_back({.kind = BallJoint{}, .first = 3, .second = {}});
    if (!method->can.has(Feature::loops)) {
      CHECK_THROWS(catalogue::require_does(*method, loop, "--method"), UserError, "joints that close loops");
      CHECK_THROWS(method->make(loop, sample_grid(loop)), MachineError, "close a loop");
    }
    Scenario rare = test::random_tree(1, false);
    rare.mechanism.joints[0].kind = PistonJoint{};
    CHECK_THROWS(catalogue::require_does(*method, rare, "--method"), UserError, "joints piston, pr, pu");
    Scenario several = test::random_tree(1, false);
    several.mechanism.joints[0].kind = UniversalJoint{};
    several.mechanism.joints[0].drives = {{.motion = 1, .springs = {{.stiffness = 1}}}};
    CHECK_THROWS(catalogue::require_does(*method, several, "--method"), UserError,
                 "springs, torques and controllers of joints with several motions");
    Scenario strut = test::random_tree(1, false);
    strut.mechanism.struts = {{.second = {}, .stiffness_N_m = 1}};
    CHECK_THROWS(catalogue::require_does(*method, strut, "--method"), UserError, "struts");
  }
}

}  // namespace

int main(int argc, char** argv) {
  asked.assign(argv + 1, argv + argc);
  double_pendulum();
  published_box();
#ifdef ODEVAL_WITH_TREES
  for (unsigned seed = 1; seed <= 20; ++seed) tree(test::random_tree(seed, seed % 4 >= 2));
  sampled_controllers();
  for (const unsigned seed : {2U, 4U, 5U}) motors(seed);
#endif
  what_blows_up_says_so();
  options_are_told();
  missing_ones_say_what_would_bring_them();
  refusals();
  return test::verdict();
}
