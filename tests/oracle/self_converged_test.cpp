// ODE's own limit as the reference: of what rubs, and beside the located impacts of what does not.
#include "catalogue/self_converged.hpp"

#include <algorithm>
#include <cmath>

#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

/// A box on a horizontal rail through it, which a floor below carries as well and brakes: it slides to a halt.
Scenario braked(double friction) {
  Scenario scenario;
  scenario.name = scenario.file = "braked";
  scenario.named = true;
  scenario.duration_s = 0.8;
  scenario.mechanism.bodies = {Body{.shape = Box{{0.2, 0.2, 0.2}},
                                    .mass_kg = 2,
                                    .position_m = {0, 0, 0.1},
                                    .velocity_m_s = {1, 0, 0},
                                    .name = "box"},
                               Body{.shape = Sphere{0.1}, .mass_kg = 1, .position_m = {0, 3, 0}, .name = "bob"}};
  scenario.mechanism.joints = {{.kind = HingeJoint{{0, 3, 1}, {1, 0, 0}}, .first = 1, .second = {}}};
  scenario.mechanism.obstacles = {{HalfSpace{}, "floor"}};
  scenario.mechanism.contacts = {{.friction = Friction{friction}, .first = "box", .second = "floor"}};
  scenario.ode.cfm = 1e-7;
  return scenario;
}

// Comes to rest after v / (mu g) = 0.51 s, v^2 / (2 mu g) = 0.255 m on. A friction cone along the world's axes is none
// here: it slides along one.
void what_rubs() {
  const Scenario scenario = braked(0.2);
  catalogue::Evaluator evaluator(scenario);
  const Reference& reference = evaluator.reference();
  std::printf("%s: %.6g m, uncertain by %.3g m\n", reference.origin.c_str(),
              reference.trace.bodies[0].position[0].back(), reference.uncertainty_position.back());
  CHECK(reference.origin.starts_with("self-converged: dWorldStep's own limit"));
  CHECK(reference.origin.find("ERP and CFM as springs") != std::string::npos);
  const double wanted = 1 / (2 * 0.2 * scenario.gravity);
  CHECK_NEAR(reference.trace.bodies[0].position[0].back(), wanted, reference.uncertainty_position.back() + 1e-5);
  CHECK_BETWEEN(reference.uncertainty_position.back(), 0, 2e-4);
  CHECK_EQUAL(reference.uncertainty_position.size(), reference.trace.rows());
  CHECK(std::ranges::is_sorted(reference.uncertainty_turn));
  Scenario numbers = scenario;
  numbers.definition.emplace_back("limit", std::string("numbers"));
  CHECK(catalogue::Evaluator(numbers).reference().origin.find("as numbers") != std::string::npos);
}

// Where the reference of trees finds that a body comes to rest, ODE's own limit takes its place and says why.
void what_rests() {
  Scenario scenario = braked(0.2);
  scenario.mechanism.contacts[0].friction.reset();
  scenario.mechanism.bodies[0].position_m[2] = 0.12;
  const Reference reference = catalogue::Evaluator(scenario).reference();
  CHECK(reference.origin.find("self-converged") == 0);
  CHECK(reference.origin.find("body 'box' comes to rest on what it touches") != std::string::npos);
}

// With restitution 1 impacts are located: there the limit has to be that reference, within what both state.
void the_limit_is_the_located_motion() {
  Scenario scenario = braked(0.2);
  scenario.mechanism.contacts[0] = {.restitution = 1, .first = "bob", .second = "wall"};
  scenario.mechanism.obstacles = {{HalfSpace{{0, 1, 0}, 2.6}, "wall"}};
  scenario.mechanism.bodies[1].velocity_m_s = {0, -2, 0};
  scenario.mechanism.bodies[1].spin_rad_s = {-2, 0, 0};
  scenario.duration_s = 0.4;
  scenario.step_s = 2e-4;
  scenario.ode.cfm = 0;
  const SampleGrid grid = sample_grid(scenario);
  const Reference located = reference::provider_for(scenario).solve(scenario, grid);
  const Reference own = catalogue::self_converged(scenario, grid);
  double largest_part = 0, off = 0;
  for (std::size_t k = 0; k < own.trace.rows(); ++k) {
    const double apart = std::fabs(own.trace.bodies[1].position[1][k] - located.trace.bodies[1].position[1][k]);
    off = std::fmax(off, apart);
    largest_part = std::fmax(largest_part, apart / (own.uncertainty_position[k] + 1e-12));
  }
  std::printf("limit: %.3g m from the located motion, %.3g of what it states (%.3g m)\n", off, largest_part,
              own.uncertainty_position.back());
  CHECK_BETWEEN(largest_part, 0, 1);
  CHECK_BETWEEN(off, 0, 2e-3);
}

// Balls that touch from the start and that one drives into the others: ODE's LCP gives up, and its runs drive them
// apart with speeds that grow as the step gets shorter, which an extrapolation took for a limit of metres, "± 0.02 m".
void what_ode_complains_of() {
  Scenario scenario = braked(0.2);
  scenario.gravity = 0;
  scenario.mechanism.joints.clear();
  scenario.mechanism.bodies.clear();
  for (int i = 0; i < 3; ++i) {
    scenario.mechanism.bodies.push_back({.shape = Sphere{0.1},
                                         .mass_kg = i < 2 ? 1.0 : 2.0,
                                         .position_m = {0.1 * i, 0, 0},
                                         .velocity_m_s = {i == 0 ? 1.0 : 0.0, 0, 0},
                                         .name = std::string(1, static_cast<char>('a' + i))});
  }
  scenario.mechanism.contacts = {{.restitution = 0.7, .first = "a", .second = "b"},
                                 {.restitution = 0.7, .first = "a", .second = "c"},
                                 {.restitution = 0.7, .first = "b", .second = "c"}};
  scenario.ode.cfm = 1e-10;
  CHECK_THROWS(catalogue::self_converged(scenario, sample_grid(scenario)), UserError,
               "there is no reference: ODE's own run at h/1");
  CHECK_THROWS(catalogue::self_converged(scenario, sample_grid(scenario)), UserError, "the first: LCP internal error");
}

// Two pendulums, one on the other, fall from where they lie: chaos, which steps of 10 ms lose within seconds.
void what_does_not_converge() {
  Scenario scenario = braked(0.2);
  scenario.mechanism.bodies[1].position_m = {0, 4, 1};
  scenario.mechanism.bodies.push_back({.shape = Sphere{0.1}, .mass_kg = 1, .position_m = {0, 5, 1}, .name = "second"});
  scenario.mechanism.joints.push_back({.kind = HingeJoint{{0, 4, 1}, {1, 0, 0}}, .first = 2, .second = 1});
  scenario.step_s = 1e-2;
  scenario.duration_s = 0.4;
  const std::string words = "does not fall with the step";
  CHECK(catalogue::self_converged(scenario, sample_grid(scenario)).origin.find(words) == std::string::npos);
  scenario.duration_s = 20;
  const Reference lost = catalogue::self_converged(scenario, sample_grid(scenario));
  std::printf("%s: ± %.3g m\n", lost.origin.c_str(), lost.uncertainty_position.back());
  const std::size_t from = lost.origin.find(words + " from t = ");
  CHECK(from != std::string::npos);
  if (from == std::string::npos) return;
  CHECK_BETWEEN(std::stod(lost.origin.substr(from + (words + " from t = ").size())), 1, 19);
}

void what_can_not() {
  Scenario scenario = braked(0.2);
  CHECK(catalogue::can_self_converge(scenario));
  scenario.mechanism.joints[0].controllers = {{.kp = 1, .sampled = true}};
  CHECK(!catalogue::can_self_converge(scenario));
  CHECK_THROWS(catalogue::provider_of(scenario), UserError, "there is no reference for these bodies");
}

}  // namespace

int main() {
  what_rubs();
  what_rests();
  the_limit_is_the_located_motion();
  what_ode_complains_of();
  what_does_not_converge();
  what_can_not();
  return test::verdict();
}
