// Contacts of one shape of a body: only that shape touches that way, in ODE and under the accurate step.
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "measure/body_trace.hpp"
#include "tests/check.hpp"
#include "tests/contract/moved.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using test::moved;
using test::on_a_floor;

constexpr double g = 9.81;

constexpr double height_m = 0.2;  // of a centre of mass above the floor

/// A way of stepping, by what part of itself it may miss a loss of speed or a speed after an impact, and the lever by
/// which friction moves load from foot to foot.
struct Stepper {
  const char* method;
  double slides;
  double bounces;
  double lever_m;
};
// In ODE the load settles on the feet within some steps, as far as CFM lets them sink; QuickStep leaves the part of it
// that 20 iterations do not reach. dWorldStep bounds friction by the loads of before friction acts (dSolveLCP sets
// these bounds once), in which it has no lever. An impact without weight is exact to the arithmetic
// (ode_mechanisms_test.cpp).
constexpr std::array steppers{
    Stepper{"ode-step-double", 2e-3, 1e-12, 0}, Stepper{"ode-quickstep-double", 2e-2, 2e-10, height_m},
    Stepper{"ode-step-single", 2e-3, 1e-4, 0}, Stepper{"ode-rk4-double", 1e-6, 1e-9, height_m}};

// Friction by shape ------------------------------------------------------------------------------------------------

constexpr double mu = 0.3;
constexpr double speed_m_s = 2;

/// On three feet, one ahead and two behind, which bear it by a third each where nothing rubs.
Body sled() {
  Body body{.shape = Box{{1.4, 1, 0.4}},
            .mass_kg = 3,
            .position_m = {0, 0, height_m},
            .velocity_m_s = {speed_m_s, 0, 0},
            .inertia_kgm2 = std::array<double, 9>{0.3, 0, 0, 0, 0.5, 0, 0, 0, 0.6},
            .name = "sled"};
  body.several = {{Sphere{0.2}, {{0.6, 0, -0.1}}, "ahead"},
                  {Sphere{0.2}, {{-0.3, 0.4, -0.1}}, "left"},
                  {Sphere{0.2}, {{-0.3, -0.4, -0.1}}, "right"}};
  return body;
}

/// The speed at the end, beside that of a deceleration.
void slides_at(const Stepper& stepper, const std::vector<Contact>& contacts, double deceleration) {
  constexpr double time_s = 0.25;
  Scenario scenario = on_a_floor(time_s);
  scenario.mechanism.bodies = {sled()};
  scenario.mechanism.contacts = contacts;
  const Motion motion = moved(scenario, stepper.method);
  const double lost = speed_m_s - motion[motion.size() - 1].bodies[0].velocity[0];
  std::printf("%-22s lost %.6f of %.6f m/s\n", stepper.method, lost, deceleration * time_s);
  CHECK_NEAR(lost, deceleration * time_s, stepper.slides * deceleration * time_s);
}

Contact of_foot(const char* foot, double friction) {
  return {.friction = Friction{friction}, .first = std::string("sled") + foot, .second = "floor"};
}

/// The feet that rub bear another part of the weight, since their friction turns the sled over: with its lever and
/// those of the feet's loads, 0.6 m ahead and 0.3 m behind, of which the sum of moments is 0.
void feet_rub_as_they_are_told(const Stepper& stepper) {
  const double ahead = mu * 0.3 / (0.9 - stepper.lever_m * mu) * g;
  const double behind = mu * 0.6 / (0.9 + stepper.lever_m * mu) * g;
  slides_at(stepper, {of_foot(".ahead", mu), of_foot(".left", 0), of_foot(".right", 0)}, ahead);
  slides_at(stepper, {of_foot(".ahead", 0), of_foot(".left", mu), of_foot(".right", mu)}, behind);
  // The body's name stands for the shapes that no contact before it names.
  slides_at(stepper, {of_foot(".ahead", mu), of_foot("", 0)}, ahead);
  slides_at(stepper, {of_foot(".ahead", 0), of_foot("", mu)}, behind);
  slides_at(stepper, {of_foot("", mu), of_foot(".ahead", 0)}, mu * g);  // the first that names a foot
  slides_at(stepper, {of_foot(".ahead", mu), {.friction = Friction{0}}}, ahead);
}

// Restitution by shape ---------------------------------------------------------------------------------------------

constexpr double fall_m_s = 2;

/// Two balls on a bar that nothing touches, one above the other, either of them below.
Body dumbbell(bool turned_over) {
  Body body{.shape = Box{{0.2, 0.2, 0.8}},
            .mass_kg = 2,
            .position_m = {0, 0, 0.5},
            .attitude = Vec3{turned_over ? std::numbers::pi : 0, 0, 0},
            .velocity_m_s = {0, 0, -fall_m_s},
            .inertia_kgm2 = std::array<double, 9>{0.2, 0, 0, 0, 0.2, 0, 0, 0, 0.05},
            .name = "dumbbell"};
  body.several = {{Sphere{0.2}, {{0, 0, -0.3}}, "one"}, {Sphere{0.2}, {{0, 0, 0.3}}, "other"}};
  return body;
}

/// The speed upwards 0.05 s after the lower ball came to the floor. Without weight, so that the speed before is known.
double speed_after(const Stepper& stepper, bool turned_over, const std::vector<Contact>& contacts) {
  Scenario scenario = on_a_floor(0.1);
  scenario.gravity = 0;
  scenario.ode.cfm = 0;
  scenario.mechanism.bodies = {dumbbell(turned_over)};
  scenario.mechanism.contacts = contacts;
  const Motion motion = moved(scenario, stepper.method);
  return motion[motion.size() - 1].bodies[0].velocity[2];
}

Contact bounces(const char* shape, double restitution) {
  return {.restitution = restitution, .first = "floor", .second = std::string("dumbbell.") + shape};
}

void shapes_bounce_as_they_are_told(const Stepper& stepper) {
  const std::vector<Contact> both{bounces("one", 0.75), bounces("other", 0.25)};
  CHECK_NEAR(speed_after(stepper, false, both), 0.75 * fall_m_s, stepper.bounces * fall_m_s);
  CHECK_NEAR(speed_after(stepper, true, both), 0.25 * fall_m_s, stepper.bounces * fall_m_s);
  // What no contact names passes through: the upper ball is still above the floor.
  CHECK_NEAR(speed_after(stepper, false, {bounces("other", 0.25)}), -fall_m_s, stepper.bounces * fall_m_s);
  CHECK_NEAR(speed_after(stepper, true, {bounces("one", 0.75)}), -fall_m_s, stepper.bounces * fall_m_s);
}

/// Of two bodies each by one of its shapes, whichever is named first.
void shapes_of_two_bodies_meet(const Stepper& stepper) {
  for (const bool swapped : {false, true}) {
    Scenario scenario = on_a_floor(0.3);
    scenario.gravity = 0;
    scenario.ode.cfm = 0;
    scenario.mechanism.obstacles.clear();
    scenario.mechanism.bodies = {dumbbell(false), dumbbell(false)};
    Body& above = scenario.mechanism.bodies[1];
    above.name = "above";
    above.position_m[2] = 1.4;
    scenario.mechanism.bodies[0].velocity_m_s = {};
    Contact contact{.restitution = 1, .first = "above.one", .second = "dumbbell.other"};
    if (swapped) std::swap(contact.first, contact.second);
    scenario.mechanism.contacts = {contact};
    const Motion struck = moved(scenario, stepper.method);
    CHECK_NEAR(struck[struck.size() - 1].bodies[0].velocity[2], -fall_m_s, stepper.bounces * fall_m_s);
    scenario.mechanism.contacts = {{.restitution = 1, .first = "above.other", .second = "dumbbell.other"}};
    const Motion passed = moved(scenario, stepper.method);
    CHECK_EQUAL(passed[passed.size() - 1].bodies[0].velocity[2], 0.0);
  }
}

}  // namespace

int main() {
  for (const Stepper& stepper : steppers) {
    feet_rub_as_they_are_told(stepper);
    shapes_bounce_as_they_are_told(stepper);
    shapes_of_two_bodies_meet(stepper);
  }
  return test::verdict();
}
