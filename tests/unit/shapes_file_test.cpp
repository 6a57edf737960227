// Files of bodies with shapes, masses and centres of their own: what becomes of them, and what is refused.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "tests/check.hpp"
#include "tests/scenario_text.hpp"

namespace {

using namespace odeval;
using test::read;
using test::refused;
using test::replaced;

/// The moments of a solid of revolution about z, as discs: the middle of each in the place of its thickness, which of
/// 10000 leaves less than 1e-7.
Vec3 moments_of_discs(double length, double mass, double (*radius)(double z)) {
  constexpr int discs = 10000;
  double volume = 0, along = 0, across = 0;
  for (int k = 0; k < discs; ++k) {
    const double z = length * ((k + 0.5) / discs - 0.5);
    const double square = radius(z) * radius(z);
    volume += square;
    along += square * square / 2;
    across += square * (square / 4 + z * z);
  }
  return {mass * across / volume, mass * across / volume, mass * along / volume};
}

void masses_of_bars() {
  const auto straight = [](double) { return 0.15; };
  const auto round = [](double z) {
    const double beyond = std::fmax(0, std::fabs(z) - 0.25);
    return std::sqrt(std::fmax(0, 0.15 * 0.15 - beyond * beyond));
  };
  const Vec3 cylinder = moments_of_discs(0.8, 3, straight);
  const Vec3 capsule = moments_of_discs(0.8, 3, round);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK_NEAR(uniform_moments_kgm2(Cylinder{0.3, 0.8}, 3)[k], cylinder[k], 1e-7);
    CHECK_NEAR(uniform_moments_kgm2(Capsule{0.3, 0.8}, 3)[k], capsule[k], 1e-7);
  }
}

// A ball of 2 kg, with another of 1 kg fastened 0.3 m off along its x, which is the world's y, and a bar without mass.
const std::string dumbbell = R"(problem = "mechanism"
duration = 1
[[bodies]]
name = "dumbbell"
shape = "sphere"
mass = 2
size = [0.1, 0.1, 0.1]
position = [0, 0, 1]
turn = [0, 0, 1.5707963267948966]
velocity = [1, 0, 0]
spin = [0, 0, 2]
[[bodies.shapes]]
shape = "sphere"
mass = 1
size = [0.2, 0.2, 0.2]
position = [0.3, 0, 0]
[[bodies.shapes]]
shape = "capsule"
size = [0.05, 0.05, 0.4]
position = [0.15, 0, 0]
turn = [0, 1.5707963267948966, 0]
[[joints]]
kind = "hinge"
parent = "world"
child = "dumbbell"
anchor = [0, 0.5, 0]
axis = [0, 0, 1]
)";

void several_shapes() {
  const Body body = read(dumbbell).mechanism.bodies[0];
  CHECK_EQUAL(body.mass_kg, 3.0);
  CHECK_NEAR(body.position_m[0], 0, 1e-15);
  CHECK_NEAR(body.position_m[1], 0.1, 1e-15);
  CHECK_NEAR(body.velocity_m_s[0], 1 - 2 * 0.1, 1e-15);
  const std::array<double, 9>& inertia = body.inertia_kgm2.value();
  const double about_x = 2 * 0.1 * 0.1 / 10 + 1 * 0.2 * 0.2 / 10;
  const double across = about_x + 2.0 / 3 * 0.3 * 0.3;  // reduced mass times distance squared
  const std::array<double, 9> wanted{about_x, 0, 0, 0, across, 0, 0, 0, across};
  for (std::size_t k = 0; k < 9; ++k) CHECK_NEAR(inertia[k], wanted[k], 1e-16);
  CHECK_EQUAL(body.parts().size(), 3u);
  CHECK_NEAR(body.parts()[0].place.position_m[0], -0.1, 1e-15);
  CHECK_NEAR(body.parts()[2].place.position_m[0], 0.05, 1e-15);
  CHECK_NEAR(std::fabs(axis_of(body.parts()[2].place.rotation, 2)[0]), 1, 1e-15);
  CHECK(std::holds_alternative<Capsule>(body.parts()[2].shape));
  // The same of a body without a shape of its own, whose mass and inertia are said.
  std::string text = replaced(dumbbell, "shape = \"sphere\"\nmass = 2\nsize = [0.1, 0.1, 0.1]",
                              "shape = \"none\"\nmass = 2\ninertia = [0.002, 0.002, 0.002, 0, 0, 0]");
  const Body bare = read(text).mechanism.bodies[0];
  CHECK_EQUAL(bare.parts().size(), 2u);
  CHECK_EQUAL(bare.mass_kg, 3.0);
  CHECK_NEAR(bare.position_m[1], 0.1, 1e-15);
  for (std::size_t k = 0; k < 9; ++k) CHECK_NEAR(bare.inertia_kgm2.value()[k], wanted[k], 1e-16);
  CHECK_NEAR(bare.parts()[0].place.position_m[0], 0.2, 1e-15);
  // The box about the centre of mass that holds them: the ball that is 0.2 m off reaches the farthest, with its radius.
  CHECK_NEAR(sides_m(body.shape)[0], 2 * (0.2 + 0.1), 1e-15);
  CHECK_NEAR(sides_m(body.shape)[2], 0.2, 1e-15);
}

/// The tensor of a heavy box that is turned in its body: by a third of a turn about (1, 1, 1), which lays its x, y and
/// z along the body's y, z and x, and by 30 degrees about z.
void turned_shapes() {
  const auto inertia_of = [](const Vec3& turn) {
    std::array<char, 100> text{};
    std::snprintf(text.data(), text.size(), "turn = [%.17g, %.17g, %.17g]\n", turn[0], turn[1], turn[2]);
    return read(std::string(
                    "problem = \"mechanism\"\nduration = 1\n[[bodies]]\nname = \"b\"\n[[bodies.shapes]]\nmass = 3\n"
                    "size = [0.1, 0.2, 0.4]\n") +
                text.data())
        .mechanism.bodies[0]
        .inertia_kgm2.value();
  };
  const double x = 3 * (0.04 + 0.16) / 12, y = 3 * (0.01 + 0.16) / 12, z = 3 * (0.01 + 0.04) / 12;
  constexpr double third = 2 * std::numbers::pi / 3 / std::numbers::sqrt3;
  const std::array<std::array<double, 9>, 2> wanted{
      {{z, 0, 0, 0, x, 0, 0, 0, y},
       {(3 * x + y) / 4, (x - y) * std::sqrt(3) / 4, 0, (x - y) * std::sqrt(3) / 4, (x + 3 * y) / 4, 0, 0, 0, z}}};
  const std::array turned{inertia_of({third, third, third}), inertia_of({0, 0, std::numbers::pi / 6})};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 0; k < 9; ++k) CHECK_NEAR(turned[i][k], wanted[i][k], 1e-16);  // rounding of 0.05 and less
  }
}

void check_same(const Body& a, const Body& b) {
  CHECK_NEAR(a.mass_kg, b.mass_kg, 1e-15);
  CHECK_NEAR(distance(a.position_m, b.position_m), 0, 1e-15);
  CHECK_NEAR(distance(a.velocity_m_s, b.velocity_m_s), 0, 1e-15);
  for (std::size_t k = 0; k < 9; ++k) CHECK_NEAR(a.inertia_kgm2.value()[k], b.inertia_kgm2.value()[k], 1e-16);
  const std::vector<Part> parts = a.parts();
  CHECK_EQUAL(parts.size(), b.parts().size());
  for (std::size_t i = 0; i < std::min(parts.size(), b.parts().size()); ++i) {
    CHECK_NEAR(distance(parts[i].place.position_m, b.parts()[i].place.position_m), 0, 1e-15);
    CHECK_EQUAL(parts[i].shape.index(), b.parts()[i].shape.index());
  }
}

const std::string sphere_of_its_own = "shape = \"sphere\"\nmass = 2\nsize = [0.1, 0.1, 0.1]\n";

// The ball of 2 kg as a table of its own: the body says nothing of a shape, and its shapes have all the mass.
void shapes_have_all_of_it() {
  const std::string text = replaced(replaced(dumbbell, sphere_of_its_own, ""), "[[bodies.shapes]]\n",
                                    "[[bodies.shapes]]\n" + sphere_of_its_own + "[[bodies.shapes]]\n");
  check_same(read(text).mechanism.bodies[0], read(dumbbell).mechanism.bodies[0]);
}

// The same mass and inertia said of the body's centre of mass, a third of 0.3 m along its x.
void a_centre_beside_the_shapes() {
  const double round = 2 * 0.1 * 0.1 / 10 + 1 * 0.2 * 0.2 / 10;
  const double across = round + 2.0 / 3 * 0.3 * 0.3;
  std::string text = replaced(dumbbell, "mass = 2\n",
                              "mass = 3\ncentre = [0.1, 0, 0]\ninertia = [" + std::to_string(round) + ", " +
                                  std::to_string(across) + ", " + std::to_string(across) + ", 0, 0, 0]\n");
  text = replaced(text, "mass = 1\n", "");
  check_same(read(text).mechanism.bodies[0], read(dumbbell).mechanism.bodies[0]);
  // Of one shape, too: it stands where `position` is.
  std::string alone = text.substr(0, text.find("[[bodies.shapes]]"));
  const Body body = read(alone).mechanism.bodies[0];
  CHECK_EQUAL(body.parts().size(), 1u);
  CHECK_NEAR(body.parts()[0].place.position_m[0], -0.1, 1e-15);
  CHECK_NEAR(body.position_m[1], 0.1, 1e-15);
  CHECK_NEAR(body.velocity_m_s[0], 1 - 2 * 0.1, 1e-15);
  CHECK_NEAR(sides_m(body.shape)[0], 2 * (0.1 + 0.05), 1e-15);
  // And the file that a definition makes says it again.
  const auto said = read(alone).definition;
  CHECK(std::ranges::any_of(said, [](const auto& setting) { return setting.first == "bodies.0.centre"; }));
}

void bad_shapes() {
  const auto wrong = [](const char* what, const char* with, const char* message) {
    refused(replaced(dumbbell, what, with), message);
  };
  wrong("size = [0.2, 0.2, 0.2]", "size = [0.2, 0.2, 0.3]",
        "bodies.0.shapes.0.size = [0.2, 0.2, 0.3]: must be the diameter, three");
  wrong("size = [0.05, 0.05, 0.4]", "size = [0.05, 0.05, 0.05]",
        "bodies.0.shapes.1.size = [0.05, 0.05, 0.05]: must be the diameter, twice, and the length with both ends");
  wrong("\"capsule\"\nsize = [0.05,", "\"cylinder\"\nsize = [0.06,",
        "bodies.0.shapes.1.size = [0.06, 0.05, 0.4]: must be the diameter");
  wrong("\"capsule\"", "\"cone\"", "bodies.0.shapes.1.shape = 'cone': must be one of box, sphere, cylinder, capsule");
  wrong("shape = \"sphere\"\nmass = 2", "shape = \"none\"\nmass = 2", "bodies.0.size has no meaning for shape none");
  wrong("shape = \"sphere\"\nmass = 2\nsize = [0.1, 0.1, 0.1]", "shape = \"none\"\nmass = 2",
        "bodies.0.inertia is missing; it must be a list of 6 numbers from -1e9 to 1e9 kg m², of a mass "
        "without a shape");
  refused(
      "problem = \"mechanism\"\nduration = 1\n[[bodies]]\nmass = 1\nshape = \"none\"\ninertia = [1, 1, 1, 0, 0, 0]\n",
      "bodies.0.shape must not be none for a body without [[bodies.shapes]]");
  wrong("size = [0.1, 0.1, 0.1]\n", "", "bodies.0.size is missing; it must be");
  wrong("\"capsule\"", "\"none\"", "bodies.0.shapes.1.shape = 'none': must be one of box, sphere, cylinder, capsule");
  wrong("mass = 1\n", "mass = -1\n", "bodies.0.shapes.0.mass = -1: must be a number from 0 to");
  wrong("size = [0.2, 0.2, 0.2]\n", "", "bodies.0.shapes.0.size is missing");
  refused(replaced(replaced(dumbbell, "position = [0, 0, 1]", "position = [0, 0, 0]"),
                   "kind = \"hinge\"\nparent = \"world\"\nchild = \"dumbbell\"\nanchor = [0, 0.5, 0]\naxis = [0, 0, 1]",
                   "kind = \"plane2d\"\nparent = \"world\"\nchild = \"dumbbell\""),
          "bodies.0.shapes.0.mass = 1: must be 0 for a body that kind plane2d holds by its centre");
  refused(
      "problem = \"free_box\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [1, 1, 1]\n[[bodies.shapes]]\n"
      "size = [1, 1, 1]\n",
      "bodies.0.shapes has no meaning for free_box; remove it");
  refused(
      "problem = \"bouncing_ball\"\nduration = 1\n[ground]\n[[bodies]]\nshape = \"capsule\"\nmass = 1\nsize = [1, 1, "
      "2]\n",
      "bodies.0.shape = capsule: must be box or sphere on a [ground]");
  wrong("\"capsule\"\nsize = [0.05, 0.05, 0.4]", "\"sphere\"\nsize = [0.4, 0.4, 0.4]",
        "bodies.0.shapes.1.turn has no effect on a sphere; remove it");
  wrong("\"capsule\"", "\"plane\"", "bodies.0.shapes.1.shape = plane: is of no body: ODE's planes stand still; write");
  wrong("shape = \"sphere\"\nmass = 2", "shape = \"plane\"\nmass = 2", "bodies.0.shape = plane: is of no body");
  refused(dumbbell + "[[shapes]]\nbody = \"dumbbell\"\nsize = [1, 1, 1]\n",
          "shapes is no table of a file; the shapes of a body are tables [[bodies.shapes]] below it");
  refused("problem = \"mechanism\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [1, 1, 1]\nshapes = 1\n",
          "bodies.0.shapes = 1: must be tables [[bodies.shapes]]");
}

void bad_masses() {
  const auto wrong = [](const char* what, const char* with, const char* message) {
    refused(replaced(dumbbell, what, with), message);
  };
  wrong("mass = 2\n", "", "bodies.0.mass is missing; it must be a number from 1e-06 to 1e6 kg");
  wrong("mass = 2\n", "inertia = [1, 1, 1, 0, 0, 0]\n", "bodies.0.mass is missing");
  wrong("mass = 2\n", "mass = 2\ncentre = [0.1, 0, 0]\n", "bodies.0.centre needs an inertia: a uniform solid has");
  wrong("mass = 2\n", "mass = 2\ncentre = [0.1, 0]\n", "bodies.0.centre = [0.1, 0]: must be a list of 3 numbers");
  const std::string bare = replaced(dumbbell, sphere_of_its_own, "");
  CHECK_EQUAL(read(bare).mechanism.bodies[0].mass_kg, 1.0);
  refused(replaced(bare, "mass = 1\n", ""), "bodies.0.mass is missing; it must be a number from 1e-06 to 1e6 kg, or");
  refused(replaced(bare, "mass = 1\n", "mass = 1e-9\n"), "bodies.0.mass is missing");
  refused(replaced(bare, "name = \"dumbbell\"\n", "name = \"dumbbell\"\ninertia = [1, 1, 1, 0, 0, 0]\n"),
          "bodies.0.mass is missing; it must be a number from 1e-06 to 1e6 kg, of an inertia");
  const std::string box = "problem = \"free_box\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [1, 1, 1]\n";
  refused(box + "centre = [1, 0, 0]\ninertia = [1, 1, 1, 0, 0, 0]\n", "bodies.0.inertia has no meaning for free_box");
  refused(replaced(box, "mass = 1\n", ""), "bodies.0.mass is missing");
}

// The flag that is at fault is blamed, not the file: of one number of a list, of a shape that another size is of.
void flags_are_blamed() {
  const auto blames = [](const char* key, const char* value, const std::string& message) {
    CHECK_THROWS(read(dumbbell, {{key, value, "--set"}}), UserError,
                 "--set " + std::string(key) + "=" + value + ": " + message);
  };
  blames("bodies.0.shapes.0.size.2", "0.3", "bodies.0.shapes.0.size must be the diameter, three times, for a sphere");
  blames("bodies.0.shapes.0.size", "[1, 1, 2]", "bodies.0.shapes.0.size must be the diameter");
  blames("bodies.0.size.0", "0.3", "bodies.0.size must be the diameter, three times, for a sphere");
  blames("bodies.0.shapes.1.shape", "sphere", "bodies.0.shapes.1.shape needs another size: must be the diameter");
  blames("bodies.0.shapes.0.turn", "[0, 0, 1]", "bodies.0.shapes.0.turn has no effect on a sphere; remove it");
  blames("bodies.0.shapes.2.size", "[1, 1, 1]", "the scenario has no 'bodies.0.shapes.2.size'");
  blames("bodies.0.shapes.1.shape", "plane", "bodies.0.shapes.1.shape is of no body");
  blames("joints.0.axis.2", "0", "joints.0.axis must have a direction");
  blames("shapes", "1", "shapes is no table of a file");
}

}  // namespace

int main() {
  masses_of_bars();
  several_shapes();
  turned_shapes();
  shapes_have_all_of_it();
  a_centre_beside_the_shapes();
  bad_shapes();
  bad_masses();
  flags_are_blamed();
  return test::verdict();
}
