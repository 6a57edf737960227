// Bodies of a mechanism that strike planes and each other: the reference beside the references that know of one impact
// at a time, and what it does not follow.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "catalogue/confirmation.hpp"
#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "reference/planar/reference_solution.hpp"
#include "reference/tree/contact_points.hpp"
#include "reference/tree/tree_reference.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

template <std::size_t N>
std::array<double, N> row(const std::array<Column, N>& columns, std::size_t k) {
  std::array<double, N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = columns[i][k];
  return values;
}

/// A ball that slides along a vertical rail and falls onto a floor, through which the rail goes.
Scenario ball_on_rail(double restitution) {
  Scenario scenario;
  scenario.name = scenario.file = "ball";
  scenario.duration_s = 3;
  scenario.mechanism.bodies = {Body{.shape = Sphere{0.2}, .mass_kg = 2, .position_m = {0, 0, 1.1}, .name = "ball"}};
  scenario.mechanism.joints = {{.kind = SliderJoint{{0, 0, 0}, {0, 0, 1}}, .second = {}}};
  scenario.mechanism.obstacles = {{HalfSpace{}, "floor"}};
  scenario.mechanism.contacts = {{.restitution = restitution}};
  return scenario;
}

/// The same of a capsule that lies on its side, both ends of which strike at once.
Scenario capsule_on_rail(double restitution) {
  Scenario scenario = ball_on_rail(restitution);
  scenario.mechanism.bodies[0].shape = Capsule{0.2, 0.7};
  scenario.mechanism.bodies[0].attitude = Vec3{0, std::numbers::pi / 2, 0};
  return scenario;
}

/// The same of a ball 0.3 m below the body's centre, beside a box that is higher, all turned.
Scenario several_on_rail(double restitution) {
  Scenario scenario = ball_on_rail(restitution);
  Body& body = scenario.mechanism.bodies[0];
  body.attitude = Vec3{0, std::numbers::pi / 2, 0};
  body.inertia_kgm2 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  body.several = {{Sphere{0.2}, {{0.3, 0, 0}}}, {Box{{0.2, 0.4, 0.1}}, {{0.2, 0.5, 0}}}};
  body.shape = Box{{0.8, 1.4, 0.2}};
  scenario.mechanism.obstacles[0].shape = HalfSpace{{0, 0, 1}, -0.3};
  return scenario;
}

/// The same, of which each shape touches in a way of its own: the ball bounces, the box does not, and another box that
/// lies 0.4 m lower touches nothing. A table that names what one before it does counts for nothing.
Scenario named_shapes_on_rail(double restitution) {
  Scenario scenario = several_on_rail(restitution);
  std::vector<Part>& parts = scenario.mechanism.bodies[0].several;
  parts[0].name = "foot";
  parts[1].name = "arm";
  parts.insert(parts.begin(), Part{Box{{0.2, 0.4, 0.1}}, {{0.7, 0, 0}}, "ghost"});
  scenario.mechanism.contacts = {{.restitution = 0, .first = "floor", .second = "ball.arm"},
                                 {.restitution = restitution, .first = "ball.foot", .second = "floor"},
                                 {.restitution = 1, .first = "floor", .second = "ball.foot"}};
  return scenario;
}

/// The same, held by a second rail beside the first: a loop, of which the other rail implies everything.
Scenario ball_on_two_rails(double restitution) {
  Scenario scenario = ball_on_rail(restitution);
  scenario.mechanism.joints.push_back({.kind = SliderJoint{{1, 0, 0}, {0, 0, 1}}, .second = {}});
  return scenario;
}

// Falls 1 m, bounces with 0.8 of its speed: parabolas one after the other.
void a_ball_on_a_floor(const Scenario& scenario) {
  const SampleGrid grid{0.01, 1, 301};
  const Reference reference = reference::solve_tree(scenario, grid);
  const double g = scenario.gravity;
  double begin = 0, height = 1, speed = 0;
  double worst = 0, part = 0;
  for (std::size_t k = 0; k < 301; ++k) {
    const double t = grid.time(static_cast<long>(k));
    for (;;) {
      const double lands = (speed + std::sqrt(speed * speed + 2 * g * height)) / g;
      if (t < begin + lands) break;
      begin += lands;
      speed = 0.8 * (g * lands - speed);
      height = 0;
    }
    const double since = t - begin;
    const double wanted = 0.1 + height + speed * since - g / 2 * since * since;
    const double off = std::fabs(reference.trace.bodies[0].position[2][k] - wanted);
    worst = std::fmax(worst, off);
    part = std::fmax(part, off / (reference.uncertainty_position[k] + 1e-15));
  }
  std::printf("ball: %.3g m off, %.3g of what is stated\n", worst, part);
  CHECK_BETWEEN(worst, 0, 1e-9);
  CHECK_BETWEEN(part, 0, 1);
}

// The report's box that swings against a wall, whose two lower corners strike at once.
void the_wall_pendulum() {
  const Scenario planar = test::report_scenario("wall_pendulum", 3, 1e-3);
  Scenario space = planar;
  space.planar.reset();
  space.mechanism.obstacles = {{HalfSpace{{1, 0, 0}, planar.planar->wall->face_m}, "wall"}};
  const SampleGrid grid{0.01, 1, 301};
  const Reference wanted = reference::solve_reference(planar, grid);
  const Reference tree = reference::solve_tree(space, grid);
  CHECK(wanted.impacts.size() >= 2);  // else nothing is compared
  const PlanarFrame& frame = planar.planar->frame;
  double worst = 0, part = 0;
  for (std::size_t k = 0; k < tree.trace.rows(); ++k) {
    const Vec3 along = turned(row(tree.trace.bodies[0].rotation, k), frame.along_body);
    const double angle = std::atan2(dot(along, frame.up), dot(along, frame.horizontal));
    const double off = std::fabs(std::remainder(angle - wanted.trace.q[0][k], 2 * std::numbers::pi));
    worst = std::fmax(worst, off);
    part = std::fmax(part, off / (tree.uncertainty_turn[k] + wanted.uncertainty_q[k]));
  }
  std::printf("wall: %zu impacts, %.3g rad apart, %.3g of what both state\n", wanted.impacts.size(), worst, part);
  CHECK_BETWEEN(worst, 0, 1e-9);
  CHECK_BETWEEN(part, 0, 1);
}

Scenario cradle() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& quantity : quantities) names.metrics.emplace_back(quantity.name);
  return read_scenario(find_scenario("newtons_cradle", catalogue::scenario_folder()), {}, names);
}

// What the first ball had the last one has; a second formulation says so as well.
void a_cradle() {
  Scenario scenario = cradle();
  scenario.duration_s = 0.8;
  scenario.step_s = 2e-3;
  catalogue::Evaluator evaluator(scenario);
  const Reference& reference = evaluator.reference();
  std::printf("cradle: %s\n", reference.origin.c_str());
  // The bob's way down is 1 - cos 0.4 = 0.0789 m, less the sinking of the others, 2 mm aside, by 2e-6 m.
  double highest = 0;
  for (std::size_t k = 0; k < reference.trace.rows(); ++k) {
    highest = std::fmax(highest, reference.trace.bodies[4].position[2][k]);
  }
  const double until_here = reference.trace.bodies[4].position[2].back();
  CHECK_NEAR(reference.trace.bodies[0].position[2].back(), 0, 1e-5);
  CHECK(until_here > 0.04 && highest <= 1 - std::cos(0.4) + 1e-9);
  const catalogue::Evaluation run = evaluator.evaluate(catalogue::find_method("mechanism-cvode"));
  CHECK_BETWEEN(*evaluator.measure(run, 0.8)[quantity::max_energy_drift], 0, 1e-11);  // J of 0.387
  CHECK(reference.origin.find("second formulation") != std::string::npos);
  CHECK_BETWEEN(reference.uncertainty_position.back(), 0, 1e-8);
}

/// The speeds of two that meet in line, by Newton's law.
std::array<double, 2> parted(double m, double v, double other_m, double other_v, double restitution) {
  const double common = (m * v + other_m * other_v) / (m + other_m);
  const double apart = restitution * (v - other_v) / (m + other_m);
  return {common - other_m * apart, common + m * apart};
}

// Free ones in a row without gravity: three impacts. The reference's own steps look beyond them, to where two centres
// are one point: 1 m/s, 0.3 m and rows of 1 ms.
void balls_in_a_row() {
  constexpr double restitution = 0.7, diameter = 0.1;
  Scenario scenario;
  scenario.name = "row";
  scenario.gravity = 0;
  scenario.duration_s = 1;
  scenario.step_s = 1e-3;
  const auto ball = [](const char* name, double mass, double x, double v) {
    return Body{
        .shape = Sphere{diameter}, .mass_kg = mass, .position_m = {x, 0, 0}, .velocity_m_s = {v, 0, 0}, .name = name};
  };
  scenario.mechanism.bodies = {ball("a", 1, 0, 1), ball("b", 1, 0.3, 0), ball("c", 2, 0.5, 0)};
  scenario.mechanism.contacts = {{.restitution = restitution}};
  const Reference reference = reference::solve_tree(scenario, SampleGrid{1e-3, 1, 1001});
  const double first = 0.2;
  const auto [a1, b1] = parted(1, 1, 1, 0, restitution);
  const double second = first + 0.1 / b1;
  const auto [b2, c2] = parted(1, b1, 2, 0, restitution);
  const double third = second + (b1 - a1) * (second - first) / (a1 - b2);
  const auto [a3, b3] = parted(1, a1, 1, b2, restitution);
  const std::array wanted{first + a1 * (third - first) + a3 * (1 - third),
                          0.3 + b1 * (second - first) + b2 * (third - second) + b3 * (1 - third),
                          0.5 + c2 * (1 - second)};
  for (std::size_t i = 0; i < 3; ++i) CHECK_NEAR(reference.trace.bodies[i].position[0].back(), wanted[i], 1e-12);
}

void what_is_not_followed() {
  Scenario scenario = ball_on_rail(0.5);
  const SampleGrid grid{0.01, 1, 301};
  CHECK_THROWS(reference::solve_tree(scenario, grid), UserError,
               "body 'ball' comes to rest on what it touches: the reference knows of impacts and not of rest");
  scenario.mechanism.bodies[0].position_m[2] = 0.05;
  CHECK_THROWS(reference::solve_tree(scenario, grid), UserError, "at t = 0 body 'ball' lies 0.05 m inside");
  // Its radius over the floor, but for rounding: no overlap of 1e-17 m is told.
  const double radius = std::get<Sphere>(scenario.mechanism.bodies[0].shape).diameter_m / 2;
  scenario.mechanism.bodies[0].position_m[2] = std::nextafter(radius, 0);
  CHECK_THROWS(reference::solve_tree(scenario, grid), UserError, "at t = 0 body 'ball' touches what it does not leave");
  // Boxes with each other, the rim of a cylinder, and anything that rubs.
  CHECK(reference::is_tree(ball_on_rail(0.5)));
  scenario = ball_on_rail(0.5);
  scenario.mechanism.contacts[0].friction = Friction{0.1};
  CHECK(!reference::is_tree(scenario));
  scenario = ball_on_rail(0.5);
  scenario.mechanism.bodies.push_back({.shape = Box{{1, 1, 1}}, .mass_kg = 1, .position_m = {5, 0, 5}, .name = "box"});
  CHECK(!reference::is_tree(scenario));
  scenario.mechanism.bodies[1].shape = Cylinder{1, 1};
  scenario.mechanism.contacts[0] = {.restitution = 0.5, .first = "box", .second = "floor"};
  CHECK(!reference::is_tree(scenario));
  scenario.mechanism.contacts[0] = {.restitution = 0.5, .first = "ball", .second = "floor"};
  CHECK(reference::is_tree(scenario));
}

/// An ERP and a CFM of a contact are numbers of ODE's, of which reference and second formulation know nothing; a spring
/// is another motion.
void softness_of_contacts() {
  Scenario scenario = ball_on_rail(0.8);
  scenario.duration_s = 0.6;
  scenario.mechanism.contacts[0].softness = Softness{0.3, 1e-2};
  CHECK(reference::is_tree(scenario));
  const SampleGrid grid{1e-3, 10, 61};
  Reference reference = reference::solve_tree(scenario, grid);
  const std::string before = reference.origin;
  catalogue::confirm(reference, scenario, grid);
  std::printf("%s\n", reference.origin.substr(before.size()).c_str());
  CHECK(reference.origin.find("a second formulation, the accurate step of order 8") != std::string::npos);
  scenario.mechanism.contacts[0].spring = Spring{1000, 10};
  scenario.mechanism.contacts[0].softness.reset();
  CHECK(!reference::is_tree(scenario));
}

}  // namespace

int main() {
  a_ball_on_a_floor(ball_on_rail(0.8));
  a_ball_on_a_floor(ball_on_two_rails(0.8));
  a_ball_on_a_floor(capsule_on_rail(0.8));
  a_ball_on_a_floor(several_on_rail(0.8));
  a_ball_on_a_floor(named_shapes_on_rail(0.8));
  the_wall_pendulum();
  a_cradle();
  balls_in_a_row();
  what_is_not_followed();
  softness_of_contacts();
  return test::verdict();
}
