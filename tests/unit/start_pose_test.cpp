// Joints that start elsewhere than they are drawn: where the bodies then are, and how fast, in closed form.
#include <cmath>
#include <numbers>
#include <string>

#include "model/rotation_vector.hpp"
#include "odeval/ways.hpp"
#include "tests/check.hpp"
#include "tests/scenario_text.hpp"

namespace {

using namespace odeval;
using test::read;
using test::refused;
using test::replaced;

// Places of about 1 m are products of a few turns: some units in the last place.
constexpr double rounding = 1e-14;

const std::string head = "problem = \"mechanism\"\nduration = 1\n";

std::string body(const std::string& name, const std::string& position, const std::string& more = "") {
  return "[[bodies]]\nname = \"" + name + "\"\nmass = 1\nsize = [0.3, 0.2, 0.1]\nposition = " + position + "\n" + more;
}
std::string joint(const std::string& kind, const std::string& parent, const std::string& child,
                  const std::string& more) {
  return "[[joints]]\nkind = \"" + kind + "\"\nparent = \"" + parent + "\"\nchild = \"" + child + "\"\n" + more;
}

Rotation attitude(const Body& body) { return rotation_of_vector(rotation_vector(body.attitude)); }

double apart(const Rotation& a, const Rotation& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::fmax(most, std::fabs(a[k] - b[k]));
  return most;
}

const Vec3 x{1, 0, 0};
const Vec3 y{0, 1, 0};
const Vec3 z{0, 0, 1};

void a_pendulum() {
  const std::string text = head + body("bob", "[1, 0, 0]", "turn = [0, 0, 0.3]\n") +
                           joint("hinge", "world", "bob", "axis = [0, 0, 2]\nq = 0.5\nqd = 2\n");
  const Body bob = read(text).mechanism.bodies[0];
  CHECK_NEAR(distance(bob.position_m, {std::cos(0.5), std::sin(0.5), 0}), 0, rounding);
  CHECK_NEAR(apart(attitude(bob), rotation_about(z, 0.8)), 0, rounding);
  CHECK_NEAR(distance(bob.spin_rad_s, {0, 0, 2}), 0, rounding);
  CHECK_NEAR(distance(bob.velocity_m_s, {-2 * std::sin(0.5), 2 * std::cos(0.5), 0}), 0, rounding);
  // What the file gives the body is taken along.
  const std::string fast =
      replaced(replaced(text, "qd = 2\n", ""), "turn =", "velocity = [0, 2, 0]\nspin = [0, 0, 2]\nturn =");
  CHECK_NEAR(distance(read(fast).mechanism.bodies[0].velocity_m_s, bob.velocity_m_s), 0, rounding);
}

// A table that turns carries an arm on a hinge, and the arm a hand that slides on it.
void a_tree() {
  const std::string text =
      head + body("table", "[0, 0, 0]", "spin = [0, 0, 3]\n") +
      body("arm", "[1, 0, 0]", "velocity = [0, 3, 0]\nspin = [0, 0, 3]\n") +
      body("hand", "[2, 0, 0]", "velocity = [0, 6, 0]\nspin = [0, 0, 3]\n") +
      joint("hinge", "world", "table", "axis = [0, 0, 1]\n") +
      joint("hinge", "table", "arm", "anchor = [0.5, 0, 0]\naxis = [0, 0, 1]\nq = 0.4\nqd = -1\n") +
      joint("slider", "arm", "hand", "anchor = [1.5, 0, 0]\naxis = [1, 0, 0]\nq = 0.2\nqd = 0.7\n");
  const Mechanism made = read(text).mechanism;
  const Vec3 along{std::cos(0.4), std::sin(0.4), 0};
  const Vec3 across{-std::sin(0.4), std::cos(0.4), 0};
  const Vec3 hinge{0.5, 0, 0};
  CHECK((made.bodies[0].spin_rad_s == Vec3{0, 0, 3}));
  CHECK_NEAR(distance(made.bodies[1].position_m, hinge + 0.5 * along), 0, rounding);
  CHECK_NEAR(distance(made.bodies[1].spin_rad_s, 2.0 * z), 0, rounding);
  // The table takes the hinge along at 1.5 m/s, and the arm turns at 3 - 1 rad/s.
  CHECK_NEAR(distance(made.bodies[1].velocity_m_s, Vec3{0, 1.5, 0} + 1.0 * across), 0, rounding);
  CHECK_NEAR(distance(made.bodies[2].position_m, hinge + 1.7 * along), 0, rounding);
  CHECK_NEAR(distance(made.bodies[2].velocity_m_s, Vec3{0, 1.5, 0} + 3.4 * across + 0.7 * along), 0, rounding);
  for (const Joint& each : made.joints) {
    CHECK(misfit_of(made, each).speed_m_s < rounding && misfit_of(made, each).spin_rad_s < rounding);
  }
  CHECK_NEAR(distance(std::get<SliderJoint>(made.joints[2].kind).axis, along), 0, rounding);
  // Told from the other side: the child hangs on the world, and the parent on it.
  const Mechanism back =
      read(replaced(replaced(text, "parent = \"table\"\nchild = \"arm\"", "parent = \"arm\"\nchild = \"table\""),
                    "q = 0.4\nqd = -1", "q = -0.4\nqd = 1"))
          .mechanism;
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK_NEAR(distance(made.bodies[i].position_m, back.bodies[i].position_m), 0, rounding);
    CHECK_NEAR(distance(made.bodies[i].velocity_m_s, back.bodies[i].velocity_m_s), 0, rounding);
  }
}

/// A rod from (1, 0, 0) on a joint at (1, 0, 0), to the world or to a body that stands there.
Mechanism rod(const std::string& kind, bool on_world, const std::string& more) {
  return read(head + body("rod", "[1.5, 0.2, 0]") + body("stand", "[0, 0, 1]") +
              joint(kind, on_world ? "world" : "stand", "rod", "anchor = [1, 0, 0]\n" + more))
      .mechanism;
}

// The turn in the child comes first of what acts on its points: R(axis, q1) R(axis2, q2).
void crossed_axes() {
  const Vec3 hinge{1, 0, 0};
  const Vec3 lever{0.5, 0.2, 0};
  for (const bool on_world : {true, false}) {
    const Mechanism made = rod("universal", on_world, "axis = [0, 0, 1]\naxis2 = [0, 1, 0]\nq = [0.5, 0.7]\n");
    const Rotation turn = rotation_about(z, 0.5) * rotation_about(y, 0.7);
    CHECK_NEAR(distance(made.bodies[0].position_m, hinge + turned(turn, lever)), 0, rounding);
    CHECK_NEAR(apart(attitude(made.bodies[0]), turn), 0, rounding);
    const auto& cross = std::get<UniversalJoint>(made.joints[0].kind);
    CHECK_NEAR(distance(on_world ? cross.axis2 : cross.axis1, z), 0, rounding);
    CHECK_NEAR(distance(on_world ? cross.axis1 : cross.axis2, turned(turn, y)), 0, rounding);
  }
  const Mechanism wheel =
      rod("hinge2", false, "axis = [0, 0, 1]\naxis2 = [0, 1, 0]\nsuspension = [1, 1]\nq = [0.5, 0.7]\nqd = [2, 3]\n");
  const Rotation turn = rotation_about(z, 0.5) * rotation_about(y, 0.7);
  CHECK_NEAR(distance(wheel.bodies[0].position_m, hinge + turned(turn, lever)), 0, rounding);
  CHECK_NEAR(distance(wheel.bodies[0].spin_rad_s, 2.0 * z + 3.0 * turned(rotation_about(z, 0.5), y)), 0, rounding);
}

// A way lies in the parent, and comes first; on the world it lies in the child, and comes last.
void ways_and_turns() {
  const Vec3 hinge{1, 0, 0};
  const Vec3 lever{0.5, 0.2, 0};
  const Rotation about_z = rotation_about(z, 0.7);
  const Rotation about_both = rotation_about(z, 0.7) * rotation_about(y, 0.3);
  for (const bool on_world : {true, false}) {
    const Vec3 way = 0.4 * x;
    const auto check = [&](const Mechanism& made, const Rotation& turn) {
      const Vec3 wanted = on_world ? hinge + turned(turn, lever + way) : hinge + way + turned(turn, lever);
      CHECK_NEAR(distance(made.bodies[0].position_m, wanted), 0, rounding);
      CHECK_NEAR(apart(attitude(made.bodies[0]), turn), 0, rounding);
    };
    check(rod("piston", false, "axis = [1, 0, 0]\nq = [0.4, 0.7]\n"), rotation_about(x, 0.7));
    check(rod("pr", on_world, "axis = [1, 0, 0]\naxis2 = [0, 0, 1]\nq = [0.4, 0.7]\n"), about_z);
    check(rod("pu", on_world, "axis = [1, 0, 0]\naxis2 = [0, 0, 1]\naxis3 = [0, 1, 0]\nq = [0.4, 0.7, 0.3]\n"),
          about_both);
  }
  const Mechanism piston = rod("piston", true, "axis = [1, 0, 0]\nq = [0.4, 0.7]\nqd = [2, 3]\n");
  CHECK_NEAR(distance(piston.bodies[0].position_m, hinge + 0.4 * x + turned(rotation_about(x, 0.7), lever)), 0,
             rounding);
  CHECK_NEAR(distance(piston.bodies[0].spin_rad_s, 3.0 * x), 0, rounding);
  const Mechanism plate = rod("plane2d", true, "q = [0.1, 0.2, 0.6]\nqd = [1, 2, 3]\n");
  CHECK_NEAR(distance(plate.bodies[0].position_m, {1.6, 0.4, 0}), 0, rounding);
  CHECK_NEAR(distance(plate.bodies[0].velocity_m_s, {1, 2, 0}), 0, rounding);
  CHECK_NEAR(apart(attitude(plate.bodies[0]), rotation_about(z, 0.6)), 0, rounding);
}

// The velocities are those of the places, by the difference of two starts; and each joint allows them.
void velocities_of_places() {
  struct Case {
    std::string kind;
    std::string axes;
    std::vector<double> q;
    std::vector<double> qd;
  };
  const std::string three = "axis = [0.6, 0, 0.8]\naxis2 = [0, 0.6, 0.8]\naxis3 = [1, 0.8, -0.6]\n";
  const std::string two = "axis = [0, 0.6, 0.8]\naxis2 = [1, 0.8, -0.6]\n";
  const auto list = [](const std::vector<double>& q, const std::vector<double>& qd, double t) {
    std::string text = "[";
    for (std::size_t k = 0; k < q.size(); ++k) text += (k > 0 ? ", " : "") + std::to_string(q[k] + t * qd[k]);
    return q.size() == 1 ? text.substr(1) : text + "]";
  };
  constexpr double dt = 1e-3;  // written with six digits after the point, as all numbers here are
  for (const Case& each :
       {Case{"hinge", "axis = [1, 2, 3]\n", {0.6}, {2}}, Case{"slider", "axis = [1, 2, 3]\n", {0.6}, {2}},
        Case{"piston", "axis = [1, 2, 3]\n", {0.6, -0.4}, {2, 1}}, Case{"universal", two, {0.6, -0.4}, {2, 1}},
        Case{"pr", two, {0.6, -0.4}, {2, 1}}, Case{"pu", three, {0.6, -0.4, 0.9}, {2, 1, -3}},
        Case{"hinge2", two + "suspension = [1, 1]\n", {0.6, -0.4}, {2, 1}},
        Case{"plane2d", "", {0.6, -0.4, 0.9}, {2, 1, -3}}}) {
    for (const bool on_world : {true, false}) {
      if (on_world ? each.kind == "hinge2" : each.kind == "plane2d") continue;
      const auto at = [&](double t, bool moving) {
        return rod(each.kind, on_world,
                   each.axes + "q = " + list(each.q, each.qd, t) + "\n" +
                       (moving ? "qd = " + list(each.qd, each.qd, 0) + "\n" : ""));
      };
      const Mechanism now = at(0, true);
      const Mechanism before = at(-dt, false);
      const Mechanism after = at(dt, false);
      const Vec3 speed = (1 / (2 * dt)) * (after.bodies[0].position_m - before.bodies[0].position_m);
      // A central difference is off by dt² v''' / 6, with rates of up to 6 rad/s some 1e-5.
      CHECK_NEAR(distance(speed, now.bodies[0].velocity_m_s), 0, 5e-5);
      const Rotation turn = attitude(after.bodies[0]) * transposed(attitude(before.bodies[0]));
      CHECK_NEAR(distance((1 / (2 * dt)) * rotation_vector_of(turn), now.bodies[0].spin_rad_s), 0, 5e-5);
      const Misfit misfit = misfit_of(now, now.joints[0]);
      CHECK(misfit.speed_m_s < rounding && misfit.spin_rad_s < rounding);
    }
  }
}

// What counts from the drawn joint counts from there still.
void what_acts() {
  const std::string loads =
      "[[springs]]\njoint = \"joint1\"\nstiffness = 10\nrest = 0.2\n"
      "[[controllers]]\njoint = \"joint1\"\nkp = 6\ntarget = 0.7\namplitude = 0.1\nfrequency = 1\n";
  for (const bool on_world : {true, false}) {
    const std::string text = head + body("rod", "[1.5, 0.2, 0]") + body("stand", "[0, 0, 1]") +
                             joint("hinge", on_world ? "world" : "stand", "rod",
                                   "anchor = [1, 0, 0]\naxis = [0, 0, 1]\nq = 0.5\nstops = [0.1, 2]\n") +
                             loads;
    const Joint made = read(text).mechanism.joints[0];
    CHECK_NEAR(made.stop->low, on_world ? -0.4 : -1.5, rounding);
    CHECK_NEAR(made.stop->high, on_world ? 1.5 : 0.4, rounding);
    const double sign = on_world ? 1 : -1;  // of the child at 0.5 + 0.3 rad: the spring at 0.6, the target at 0.1
    CHECK_NEAR(made.steady_load(0, sign * 0.3, 0), sign * -10 * 0.6, rounding);
    CHECK_NEAR(made.sampled_load(0, sign * 0.3, 0), sign * -6 * 0.1, rounding);
    refused(replaced(text, "q = 0.5", "q = 0.05"),
            "joints.0.stops = [0.1, 2]: must be a low and a high end with 0.05, where the joint starts, between them");
    refused(replaced(text, "stops = [0.1, 2]", "stops = [0.1, 3.7]"),
            "joints.0.stops = [0.1, 3.7]: must lie within half a turn of a hinge, between -2.64159 and 3.64159 rad");
  }
  const Joint cross = read(head + body("rod", "[1.5, 0.2, 0]") +
                           joint("universal", "world", "rod",
                                 "axis = [0, 0, 1]\naxis2 = [0, 1, 0]\nq = [0.5, 0.7]\nstops2 = [0.5, 1]\n"))
                          .mechanism.joints[0];
  CHECK_NEAR(cross.drives.at(0).stop->low, -0.2, rounding);
  CHECK_NEAR(cross.drives.at(0).stop->high, 0.3, rounding);
  // Ends of struts go along, and a strut is relaxed as it is drawn.
  const Strut strut =
      read(head + body("rod", "[1, 0, 0]") + joint("hinge", "world", "rod", "axis = [0, 0, 1]\nq = 0.5\n") +
           "[[struts]]\nparent = \"world\"\nchild = \"rod\"\nfrom = [2, 0, 0]\nto = [1, 0, 0]\n"
           "stiffness = 1\n")
          .mechanism.struts[0];
  CHECK_NEAR(distance(strut.first_end_m, {std::cos(0.5), std::sin(0.5), 0}), 0, rounding);
  CHECK((strut.second_end_m == Vec3{2, 0, 0}));
  CHECK_EQUAL(strut.rest_m, 1.0);
}

void what_is_told() {
  const std::string text = head + body("rod", "[1.5, 0.2, 0]") +
                           joint("universal", "world", "rod", "axis = [0, 0, 1]\naxis2 = [0, 1, 0]\nq = [0.5, 0.7]\n");
  const Definition all = read(text).definition;
  const auto said = std::ranges::find(all, "joints.0.q", &Definition::value_type::first);
  CHECK(said != all.end() && std::get<std::vector<double>>(said->second) == (std::vector{0.5, 0.7}));
  CHECK(std::ranges::find(all, "joints.0.qd", &Definition::value_type::first) == all.end());
}

void bad_starts() {
  const auto wrong = [](const std::string& kind, const std::string& more, const std::string& message) {
    refused(head + body("rod", "[1.5, 0.2, 0]") + joint(kind, "world", "rod", more), "joints.0." + message);
  };
  const std::string axis = "axis = [0, 0, 1]\n";
  wrong("hinge", axis + "q = [0.1, 0.2]\n", "q = [0.1, 0.2]: must be one number for kind hinge");
  wrong("hinge", axis + "q = []\n", "q = []: must be one number for kind hinge");
  wrong("hinge", axis + "q = \"half\"\n", "q = 'half': must be a number or a list of numbers from -10000 to 10000");
  wrong("hinge", axis + "qd = nan\n", "qd = nan: must be a number from -1000 to 1000 rad/s or m/s");
  wrong("universal", axis + "q = 0.1\n", "q = 0.1: must be a list of 2 numbers for kind universal: axis, axis2");
  wrong("universal", axis + "q = [0.1, 0.2, 0.3]\n", "q = [0.1, 0.2, 0.3]: must be a list of 2 numbers for kind");
  wrong("universal", axis + "q = [0.1, inf]\n", "q.1 = inf: must be a number from -10000");
  wrong("ball", "q = 0.1\n",
        "q = 0.1: has no meaning for kind ball, whose turns have no order; give bodies.0 'rod' "
        "another turn");
  wrong("ball", "qd = [1, 2, 3]\n",
        "qd = [1, 2, 3]: has no meaning for kind ball, whose turns have no order; give "
        "bodies.0 'rod' another spin");
  wrong("fixed", "q = 0.1\n", "q = 0.1: has no meaning for kind fixed, which leaves nothing that moves; remove it");
}

}  // namespace

int main() {
  a_pendulum();
  a_tree();
  crossed_axes();
  ways_and_turns();
  velocities_of_places();
  what_acts();
  what_is_told();
  bad_starts();
  return test::verdict();
}
