// Shapes of bodies as ODE has them: their geoms stand where the scenario says, and their masses are theirs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "engines/ode/module.hpp"
#include "model/read_scenario.hpp"
#include "tests/check.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

/// An engine, and what its numbers of order 1 round by, with a margin of 10 over what its colliders add.
struct Precision {
  const char* method;
  double rounding;
};
constexpr std::array precisions{Precision{"ode-step-double", 1e-14}, Precision{"ode-step-single", 1e-5}};

const std::array<Shape, 4> shapes{Box{{0.3, 0.5, 0.7}}, Sphere{0.4}, Cylinder{0.3, 0.8}, Capsule{0.3, 0.8}};

Vec3 random_direction(std::mt19937& random) {
  const auto number = [&] { return static_cast<double>(random()) / 0x80000000 - 1; };
  for (;;) {
    const Vec3 v{number(), number(), number()};
    const double square = dot(v, v);
    if (square > 0.01 && square < 1) return (1 / std::sqrt(square)) * v;
  }
}

/// The point of a shape that is the farthest along `n`, both along its own axes.
struct Farthest {
  const Vec3& n;

  Vec3 operator()(const Box& box) const {
    const auto& [x, y, z] = box.sides_m;
    return {std::copysign(x / 2, n[0]), std::copysign(y / 2, n[1]), std::copysign(z / 2, n[2])};
  }
  Vec3 operator()(const Sphere& ball) const { return ball.diameter_m / 2 * n; }
  Vec3 operator()(const Cylinder& bar) const {
    const double away = bar.diameter_m / 2 / std::hypot(n[0], n[1]);
    return {away * n[0], away * n[1], std::copysign(bar.length_m / 2, n[2])};
  }
  Vec3 operator()(const Capsule& bar) const {
    return bar.diameter_m / 2 * n + Vec3{0, 0, std::copysign((bar.length_m - bar.diameter_m) / 2, n[2])};
  }
};

/// A bead in the middle, and the shape so far from it that it reaches the farthest to every side that is tried.
Body body_with(const Shape& shape, const Frame& place) {
  Body body{.shape = Box{{4, 4, 4}},
            .mass_kg = 2,
            .position_m = {0.4, -0.3, 1.1},
            .attitude = Vec3{0.5, -1.2, 0.8},
            .inertia_kgm2 = std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1},
            .name = "body"};
  body.several = {{Sphere{0.01}}, {shape, place}};
  return body;
}

/// Whether a body at rest touches what lies below a plane so far along its normal.
bool touches(const Body& body, const Vec3& normal, double offset_m, const Precision& precision) {
  Scenario scenario;
  scenario.name = "shapes";
  scenario.step_s = scenario.duration_s = 1e-3;
  scenario.gravity = 0;
  scenario.mechanism.bodies = {body};
  scenario.mechanism.obstacles = {{HalfSpace{normal, offset_m}, "plane"}};
  scenario.mechanism.contacts = {{.restitution = 0}};
  const catalogue::Method& row = catalogue::find_method(precision.method);
  const Motion motion = test::recorded(row.make, scenario, sample_grid(scenario)).motion;
  double most = 0;
  for (std::size_t k = 0; k < motion.size(); ++k) most = std::max(most, motion[k].contacts);
  return most > 0;
}

/// A plane that just reaches the shape's lowest point is touched, and one just below it is not: from all sides, which
/// tells place, turn and size.
void geoms_stand_where_they_should(const Shape& shape, const Precision& precision) {
  std::mt19937 random(7);
  const Frame place{{0.4, -0.6, 0.5}, rotation_of_vector({-0.9, 0.3, 1.4})};
  const Body body = body_with(shape, place);
  const Frame in_world = Frame{body.position_m, rotation_of_vector(rotation_vector(body.attitude))} * place;
  int tried = 0;
  while (tried < 20) {
    const Vec3 normal = random_direction(random);
    const Vec3 down = turned(transposed(in_world.rotation), -1.0 * normal);
    const Vec3 lowest = in_world.position_m + turned(in_world.rotation, std::visit(Farthest{down}, shape));
    const double height = dot(normal, lowest);
    if (height > dot(normal, body.position_m) - 0.02) continue;  // the bead is lower
    ++tried;
    CHECK(touches(body, normal, height + 10 * precision.rounding, precision));
    CHECK(!touches(body, normal, height - 10 * precision.rounding, precision));
  }
}

/// One that is the body's only shape lies along the body's z.
void a_bar_alone_lies_along_z() {
  Body bar{.shape = Capsule{0.2, 0.9}, .mass_kg = 1, .position_m = {0, 0, 0.45}, .name = "bar"};
  CHECK(touches(bar, {0, 0, 1}, 1e-12, precisions[0]));
  CHECK(!touches(bar, {0, 0, 1}, -1e-12, precisions[0]));
  bar.shape = Cylinder{0.2, 0.9};
  CHECK(touches(bar, {0, 0, 1}, 1e-12, precisions[0]));
  CHECK(!touches(bar, {0, 0, 1}, -1e-12, precisions[0]));
}

/// What the measurements and the reference take for the moments of a uniform solid is what ODE has.
void masses_are_those_of_the_solids() {
  Scenario scenario;
  for (const Shape& shape : shapes) scenario.mechanism.bodies.push_back({.shape = shape, .mass_kg = 3});
  const Mechanism held = engine_ode::odeval_ode_double().take_back(scenario);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Vec3 wanted = uniform_moments_kgm2(shapes[i], 3);
    const std::array<double, 9>& inertia = held.bodies[i].inertia_kgm2.value();
    CHECK_EQUAL(held.bodies[i].mass_kg, 3.0);
    for (std::size_t k = 0; k < 3; ++k) CHECK_NEAR(inertia[4 * k], wanted[k], 1e-15);
  }
}

/// Of a body on a hinge that starts at rest, whose centre of mass lies beside its shape and its position: after one
/// step ODE has the velocity of the torque at the start, h m g c / (I + m c^2).
void a_centre_swings_about_its_hinge() {
  constexpr double c = 0.35, mass = 2.5, moment = 0.04, h = 1e-3;
  const std::string text = fmt::format(
      "problem = \"mechanism\"\nduration = {0}\nstep = {0}\n"
      "[[bodies]]\nname = \"club\"\nmass = {1}\nsize = [0.1, 0.1, 0.1]\nposition = [0.5, 0, 1]\n"
      "turn = [0, 0, {2}]\ncentre = [0, {3}, 0]\ninertia = [{4}, {4}, {4}, 0, 0, 0]\n"
      "[[joints]]\nkind = \"hinge\"\nparent = \"world\"\nchild = \"club\"\nanchor = [0.5, 0, 1]\n"
      "axis = [0, 1, 0]\n[ode]\ncfm = 0.0\n",
      h, mass, -std::numbers::pi / 2, c, moment);
  const Scenario scenario = ScenarioFile("x.toml", text).read({}, {});
  const catalogue::Method& row = catalogue::find_method("ode-step-double");
  const Motion motion = test::recorded(row.make, scenario, sample_grid(scenario)).motion;
  const double wanted = h * mass * scenario.gravity * c / (moment + mass * c * c);
  CHECK_NEAR(motion[1].bodies[0].spin[1], wanted, 1e-15);
  const Mechanism held = engine_ode::odeval_ode_double().take_back(scenario);
  CHECK_NEAR(held.bodies[0].position_m[0], 0.5 + c, 1e-15);
  CHECK_EQUAL(held.bodies[0].mass_kg, mass);
}

}  // namespace

int main() {
  for (const Precision& precision : precisions) {
    if (!test::in_this_build(precision.method)) continue;
    std::printf("%s\n", precision.method);
    for (const Shape& shape : shapes) geoms_stand_where_they_should(shape, precision);
  }
  a_bar_alone_lies_along_z();
  masses_are_those_of_the_solids();
  a_centre_swings_about_its_hinge();
  return test::verdict();
}
