// Contacts with a softness of their own, in ODE and in Bullet: how deep things lie, how long a bounce lasts, and what
// the reference makes of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "catalogue/self_converged.hpp"
#include "measure/body_trace.hpp"
#include "reference/tree/contact_points.hpp"
#include "tests/check.hpp"
#include "tests/contract/moved.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using test::moved;
using test::on_a_floor;

constexpr double g = 9.81;
constexpr double radius_m = 0.1;

/// A way of stepping, and what its arithmetic leaves of lengths of 0.1 m: QuickStep's relaxation leaves 0.3 of an error
/// in each of 20 iterations, single precision rounds heights by 1e-8 m, which a spring of 1 kN/m and a mass of 1 kg let
/// grow some times.
struct Stepper {
  const char* method;
  double rounding_m;
};
constexpr std::array all{Stepper{"ode-step-double", 1e-12},         Stepper{"ode-quickstep-double", 1e-9},
                         Stepper{"ode-step-single", 1e-6},          Stepper{"ode-quickstep-single", 1e-6},
                         Stepper{"bullet-hinge-double", 1e-12},     Stepper{"bullet-hinge-single", 1e-6},
                         Stepper{"bullet-multibody-double", 1e-12}, Stepper{"bullet-multibody-single", 1e-6}};

bool is_here(const Stepper& stepper) {
  const auto row = std::ranges::find(catalogue::methods(), stepper.method, &catalogue::Method::name);
  return row->make != nullptr;
}
bool is_ode(const Stepper& stepper) { return std::string_view(stepper.method).starts_with("ode"); }

Body ball(const char* name, double x, double mass_kg) {
  return {.shape = Sphere{2 * radius_m}, .mass_kg = mass_kg, .position_m = {x, 0, radius_m}, .name = name};
}

Contact sprung(const char* name, const Spring& spring) { return {.first = name, .second = "floor", .spring = spring}; }

// Rest -------------------------------------------------------------------------------------------------------------

/// Of one scene, balls that lie in ways of their own. At rest a row says cfm F = erp depth / h with F = m g, whatever
/// the step: with a spring that is m g / kp.
void balls_sink_by_their_weight(const Stepper& stepper) {
  Scenario scenario = on_a_floor(2);
  scenario.ode.erp = 0.4;
  scenario.ode.cfm = 2e-3;
  scenario.mechanism.bodies = {ball("hard", -1, 1), ball("soft", 0, 2), ball("numbers", 1, 1), ball("world", 2, 1)};
  const Softness numbers{0.3, 1e-2};
  scenario.mechanism.contacts = {sprung("hard", {2000, 80}),
                                 sprung("soft", {600, 50}),
                                 {.first = "floor", .second = "numbers", .softness = numbers},
                                 {}};
  const Motion motion = moved(scenario, stepper.method);
  const auto end = motion[motion.size() - 1];
  const auto depth = [&](std::size_t i) { return radius_m - end.bodies[i].position[2]; };
  CHECK_NEAR(depth(0), g / 2000, stepper.rounding_m);
  CHECK_NEAR(depth(1), 2 * g / 600, stepper.rounding_m);
  CHECK_NEAR(depth(2), scenario.step_s * numbers.cfm * g / numbers.erp, stepper.rounding_m);
  if (is_ode(stepper))
    CHECK_NEAR(depth(3), scenario.step_s * scenario.ode.cfm * g / scenario.ode.erp, stepper.rounding_m);
  if (is_ode(stepper)) {
    // The same spring at another step, of which ERP and CFM are others.
    scenario.step_s = 2e-3;
    const Motion longer = moved(scenario, stepper.method);
    CHECK_NEAR(radius_m - longer[longer.size() - 1].bodies[0].position[2], g / 2000, stepper.rounding_m);
  }
}

/// A box lies on four points, each of which is a spring.
void a_box_lies_on_four_springs(const Stepper& stepper) {
  Scenario scenario = on_a_floor(2);
  scenario.mechanism.bodies = {{.shape = Box{{0.4, 0.6, 0.2}}, .mass_kg = 4, .position_m = {0, 0, 0.1}, .name = "box"}};
  scenario.mechanism.contacts = {sprung("box", {500, 40})};
  const Motion motion = moved(scenario, stepper.method);
  CHECK_NEAR(0.1 - motion[motion.size() - 1].bodies[0].position[2], 4 * g / (4 * 500), 10 * stepper.rounding_m);
}

/// Three feet bear a third of the weight each, and each sinks into the floor by its own spring. The body leans by 8e-4
/// rad for that, which moves its weight by 1.6e-4 m of 0.9 m.
void feet_sink_as_they_are_told(const Stepper& stepper) {
  Scenario scenario = on_a_floor(2);
  Body body{.shape = Box{{1.4, 1, 0.4}},
            .mass_kg = 3,
            .position_m = {0, 0, 0.2},
            .inertia_kgm2 = std::array<double, 9>{0.3, 0, 0, 0, 0.5, 0, 0, 0, 0.6},
            .name = "sled"};
  body.several = {{Sphere{0.2}, {{0.6, 0, -0.1}}, "ahead"},
                  {Sphere{0.2}, {{-0.3, 0.4, -0.1}}, "left"},
                  {Sphere{0.2}, {{-0.3, -0.4, -0.1}}, "right"}};
  scenario.mechanism.bodies = {body};
  scenario.mechanism.contacts = {sprung("sled.ahead", {1e4, 300}), sprung("sled", {4e4, 400})};
  const Motion motion = moved(scenario, stepper.method);
  const BodyState& end = motion[motion.size() - 1].bodies[0];
  const auto depth = [&](std::size_t i) {
    return radius_m - (end.position + turned(end.rotation, body.several[i].place.position_m))[2];
  };
  CHECK_NEAR(depth(0), g / 1e4, 3e-4 * g / 1e4 + stepper.rounding_m);
  CHECK_NEAR(depth(1), g / 4e4, 3e-4 * g / 4e4 + stepper.rounding_m);
  CHECK_NEAR(depth(2), g / 4e4, 3e-4 * g / 4e4 + stepper.rounding_m);
}

// Bounces ----------------------------------------------------------------------------------------------------------

Scenario falling_ball(double step_s, const Spring& spring, double gravity) {
  Scenario scenario = on_a_floor(0.3);
  scenario.step_s = step_s;
  scenario.gravity = gravity;
  scenario.mechanism.bodies = {ball("ball", 0, 1)};
  scenario.mechanism.bodies[0].velocity_m_s = {0, 0, -0.5};
  scenario.mechanism.contacts = {sprung("ball", spring)};
  return scenario;
}

/// Step by step the one row by hand: v + cfm F = erp depth / h, of a force that pushes and does not pull. What [ode]
/// says of bounces is for contacts without a spring.
void every_step_is_that_of_the_row(const Stepper& stepper) {
  const Spring spring{1500, 4};
  Scenario scenario = falling_ball(1e-3, spring, g);
  scenario.ode.bounce = 0.9;
  const Motion motion = moved(scenario, stepper.method);
  const double h = scenario.step_s;
  const Softness softness = softness_of(spring, h);
  double z = radius_m, v = -0.5, worst = 0, deepest = 0;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    worst = std::fmax(worst, std::fabs(motion[k].bodies[0].position[2] - z));
    const double depth = radius_m - z;
    deepest = std::fmax(deepest, depth);
    v -= h * g;
    if (depth >= 0) v += h * std::fmax(0, (softness.erp * depth / h - v) / (softness.cfm + h));
    z += h * v;
  }
  std::printf("%-24s rows by hand: %.3g m apart, %.3g m deep\n", stepper.method, worst, deepest);
  CHECK_NEAR(worst, 0, 10 * stepper.rounding_m);
  CHECK_BETWEEN(deepest, 0.005, 0.04);  // beyond 4 cm Bullet mends depths apart from velocities
}

struct Bounce {
  double lasts_s;
  double gives_back;  // speed after over speed before
};
Bounce bounce_at(const Stepper& stepper, double step_s, const Spring& spring) {
  const Motion motion = moved(falling_ball(step_s, spring, 0), stepper.method);
  const std::size_t last = motion.size() - 1;
  const BodyState& end = motion[last].bodies[0];
  const double speed = end.velocity[2];
  return {static_cast<double>(last) * step_s - (end.position[2] - radius_m) / speed, speed / 0.5};
}

/// Without a damper half a period, pi sqrt(m / kp), after which it leaves with its speed. The row is backward Euler's:
/// each step takes (1 + w² h²)^(-1/2) of the swing and turns its phase by atan(w h).
void a_bounce_lasts_half_a_period(const Stepper& stepper) {
  const double kp = 1000;
  const double w = std::sqrt(kp);
  const double wanted_s = std::numbers::pi / w;
  std::array<double, 2> lost{};
  for (const std::size_t k : {0U, 1U}) {
    const double h = k == 0 ? 1e-3 : 5e-4;
    const Bounce bounce = bounce_at(stepper, h, {kp, 0});
    lost[k] = 1 - bounce.gives_back;
    std::printf("%-24s h %g: lasts %.6f s of %.6f, gives back %.4f\n", stepper.method, h, bounce.lasts_s, wanted_s,
                bounce.gives_back);
    CHECK_NEAR(bounce.lasts_s, wanted_s, h / 5);
    CHECK_NEAR(bounce.gives_back, std::exp(-std::numbers::pi * w * h / 2), w * h * w * h);
  }
  CHECK_BETWEEN(lost[1] / lost[0], 0.48, 0.54);  // first order, with 2 to 4 % of the second
  // With a damper of half the critical one it leaves sooner and slower: where spring and damper cancel.
  const Bounce damped = bounce_at(stepper, 1e-4, {kp, w});
  CHECK_NEAR(damped.gives_back, std::exp(-std::numbers::pi * 2 / 3 / std::sqrt(3.0)), 0.01);
}

// What the reference makes of it -----------------------------------------------------------------------------------

/// The half sine and the straight way after it, within what the limit of ODE's runs states.
void the_limit_is_the_spring() {
  const double w = std::sqrt(1000.0);
  Scenario scenario = falling_ball(1e-3, {1000, 0}, 0);
  CHECK(catalogue::provider_of(scenario).solve == &catalogue::self_converged);
  const SampleGrid grid{1e-3, 1, 301};
  const Reference reference = catalogue::self_converged(scenario, grid);
  double part = 0, off = 0;
  for (std::size_t k = 1; k < reference.trace.rows(); ++k) {
    const double t = static_cast<double>(k) * 1e-3;
    const double up = w * t < std::numbers::pi ? -0.5 / w * std::sin(w * t) : 0.5 * (t - std::numbers::pi / w);
    const double apart = std::fabs(reference.trace.bodies[0].position[2][k] - radius_m - up);
    off = std::fmax(off, apart);
    part = std::fmax(part, apart / reference.uncertainty_position[k]);
  }
  std::printf("limit: %.3g m off, %.3g of what is stated\n", off, part);
  CHECK_BETWEEN(off, 0, 1e-4);
  CHECK_BETWEEN(part, 0, 1);
}

/// An ERP and a CFM are numbers of ODE's: without friction the true motion is that of a hard floor. With friction it is
/// ODE's own limit, in which they stay the spring that they are at h, or numbers.
void numbers_are_of_a_hard_floor() {
  Scenario scenario = on_a_floor(1);
  scenario.mechanism.bodies = {ball("ball", 0, 1)};
  scenario.mechanism.bodies[0].position_m[2] = 1;
  const Softness softness{0.3, 1e-2};
  scenario.mechanism.contacts = {{.restitution = 0.5, .first = "ball", .second = "floor", .softness = softness}};
  CHECK(catalogue::provider_of(scenario).solve != &catalogue::self_converged);
  CHECK(reference::contact_points(scenario.mechanism).has_value());
  scenario.mechanism.contacts[0].spring = Spring{1000, 10};
  CHECK(!reference::contact_points(scenario.mechanism).has_value());
  scenario.mechanism.contacts[0].spring.reset();

  scenario.mechanism.bodies[0].position_m[2] = radius_m;
  scenario.mechanism.contacts[0].friction = Friction{0.1};
  scenario.mechanism.obstacles.push_back({HalfSpace{{1, 0, 0}, -5}, "wall"});  // or there is a closed form
  CHECK(catalogue::provider_of(scenario).solve == &catalogue::self_converged);
  const SampleGrid grid{1e-3, 10, 101};
  const auto depth = [](const Reference& limit) { return radius_m - limit.trace.bodies[0].position[2].back(); };
  const double at_h = 1e-3 * softness.cfm * g / softness.erp;
  CHECK_NEAR(depth(catalogue::self_converged(scenario, grid)), at_h, 1e-9);
  scenario.definition = {{"limit", std::string("numbers")}};
  const Reference numbers = catalogue::self_converged(scenario, grid);  // h cfm m g / erp goes to 0
  std::printf("numbers: %.3g m deep, +- %.3g\n", depth(numbers), numbers.uncertainty_position.back());
  CHECK_NEAR(depth(numbers), 0, numbers.uncertainty_position.back());
  CHECK_BETWEEN(depth(numbers), 0, at_h / 4);
}

// Who does it ------------------------------------------------------------------------------------------------------

void others_say_that_they_do_not() {
  Scenario scenario = falling_ball(1e-3, {1000, 10}, g);
  CHECK_EQUAL(listed(features_of(scenario) - Features{Feature::space, Feature::ground}),
              "contacts with kp and kd of their own");
  Scenario numbers = scenario;
  numbers.mechanism.contacts[0] = {.softness = Softness{0.2, 1e-4}};
  CHECK_EQUAL(listed(features_of(numbers) - Features{Feature::space, Feature::ground}),
              "contacts with erp and cfm of their own");
  for (const catalogue::Method& method : catalogue::methods()) {
    const bool plain = method.name.starts_with("ode-step") || method.name.starts_with("ode-quick");
    const bool bullet = method.name.starts_with("bullet") && method.name.find("rk4") == method.name.npos;
    CHECK_EQUAL(catalogue::does(method, scenario), plain || bullet);
    CHECK_EQUAL(catalogue::does(method, numbers), plain || bullet);
  }
}

/// A setting of the world acts where contacts have none of their own.
void settings_of_the_world() {
  const catalogue::Method& ode = catalogue::find_method("ode-step-double");
  const auto read_keys = [&](const Scenario& scenario) {
    std::string keys;
    for (const char* key : {"ode.erp", "ode.cfm", "ode.kp", "ode.bounce"}) {
      if (catalogue::reads(ode, key, scenario)) keys += std::string(keys.empty() ? "" : " ") + key;
    }
    return keys;
  };
  Scenario scenario = falling_ball(1e-3, {1000, 10}, g);
  CHECK_EQUAL(read_keys(scenario), "");
  scenario.mechanism.contacts[0].friction = Friction{0.1};
  CHECK_EQUAL(read_keys(scenario), "ode.cfm ode.kp");
  scenario.mechanism.contacts = {{.softness = Softness{0.2, 1e-4}}};
  CHECK_EQUAL(read_keys(scenario), "ode.bounce");
  scenario.mechanism.contacts.push_back({});
  CHECK_EQUAL(read_keys(scenario), "ode.erp ode.cfm ode.kp ode.bounce");
}

}  // namespace

int main() {
  for (const Stepper& stepper : all) {
    if (!is_here(stepper)) continue;
    balls_sink_by_their_weight(stepper);
    every_step_is_that_of_the_row(stepper);
    a_bounce_lasts_half_a_period(stepper);
    if (!is_ode(stepper)) continue;  // bodies of several shapes, and Bullet looks for a box's points by tilting it
    a_box_lies_on_four_springs(stepper);
    feet_sink_as_they_are_told(stepper);
  }
  the_limit_is_the_spring();
  numbers_are_of_a_hard_floor();
  others_say_that_they_do_not();
  settings_of_the_world();
  return test::verdict();
}
