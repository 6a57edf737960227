// Joints that start elsewhere than they are drawn: where the bodies then are, and how fast, in closed form.
#include <cmath>
#include <cstdio>
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

// ---- Loops

/// A four-bar in the plane z = 0: a crank of 0.3 m at (0, 0), a rocker of 0.5 m at (0.6, 0), a coupler of 0.6 m between
/// their ends, drawn with the crank at 60 degrees.
struct FourBar {
  double crank = std::numbers::pi / 3;
  double coupler = 0;
  double rocker = 0;
  double coupler_rate = 0;
  double rocker_rate = 0;

  /// Freudenstein's: the rocker's end lies on two circles, of the two the upper.
  explicit FourBar(double at, double rate = 0) : crank(at) {
    const double px = 0.3 * std::cos(at);
    const double py = 0.3 * std::sin(at);
    const double dx = 0.6 - px;
    const double dy = -py;
    const double d2 = dx * dx + dy * dy;
    const double along = (0.36 - 0.25 + d2) / (2 * d2);
    const double up = std::sqrt(0.36 / d2 - along * along);
    const double bx = px + along * dx - up * dy;
    const double by = py + along * dy + up * dx;
    coupler = std::atan2(by - py, bx - px);
    rocker = std::atan2(by, bx - 0.6);
    rocker_rate = rate * 0.3 * std::sin(at - coupler) / (0.5 * std::sin(rocker - coupler));
    coupler_rate = -rate * 0.3 * std::sin(at - rocker) / (0.6 * std::sin(coupler - rocker));
  }
};

std::string digits(double number) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", number);
  return text;
}

std::string bar(const std::string& name, const Vec3& from, double length_m, double angle, const char* mass = "1") {
  return "[[bodies]]\nname = \"" + name + "\"\nmass = " + mass + "\nsize = [" + digits(length_m) +
         ", 0.02, 0.02]\nposition = [" + digits(from[0] + length_m / 2 * std::cos(angle)) + ", " +
         digits(from[1] + length_m / 2 * std::sin(angle)) + ", 0]\nturn = [0, 0, " + digits(angle) + "]\n";
}

std::string pin(const std::string& name, const std::string& parent, const std::string& child, const Vec3& at,
                const std::string& more = "") {
  return joint(
      "hinge", parent, child,
      "name = \"" + name + "\"\nanchor = [" + digits(at[0]) + ", " + digits(at[1]) + ", 0]\naxis = [0, 0, 1]\n" + more);
}

std::string four_bar(const std::string& crank, const std::string& rocker = "", const std::string& coupler = "") {
  const FourBar drawn(std::numbers::pi / 3);
  const Vec3 a{0.3 * std::cos(drawn.crank), 0.3 * std::sin(drawn.crank), 0};
  const Vec3 b{0.6 + 0.5 * std::cos(drawn.rocker), 0.5 * std::sin(drawn.rocker), 0};
  return head + bar("crank", {0, 0, 0}, 0.3, drawn.crank) + bar("coupler", a, 0.6, drawn.coupler) +
         bar("rocker", {0.6, 0, 0}, 0.5, drawn.rocker) + pin("drive", "world", "crank", {0, 0, 0}, crank) +
         pin("elbow", "crank", "coupler", a, coupler) + pin("knee", "coupler", "rocker", b) +
         pin("foot", "rocker", "world_foot", {0.6, 0, 0}, rocker);
}

/// With the rocker on the world.
std::string closed(std::string text) {
  return replaced(text, "parent = \"rocker\"\nchild = \"world_foot\"", "parent = \"world\"\nchild = \"rocker\"");
}

double angle_of(const Body& body) { return rotation_vector(body.attitude)[2]; }

void a_four_bar() {
  // A crank that goes round, past both ends of the rocker's way.
  for (const double q : {0.5, -1.0, 2.5, 6.0}) {
    const Scenario made = read(closed(four_bar("q = " + digits(q) + "\nqd = 3\n")));
    const std::vector<Body>& bodies = made.mechanism.bodies;
    const FourBar wanted(std::numbers::pi / 3 + q, 3);
    // Newton's method leaves rounding, of angles of a few rad.
    constexpr double left = 1e-12;
    const auto same = [](double a, double b) { return std::remainder(a - b, 2 * std::numbers::pi); };
    CHECK_NEAR(same(angle_of(bodies[0]), wanted.crank), 0, left);
    CHECK_NEAR(same(angle_of(bodies[1]), wanted.coupler), 0, left);
    CHECK_NEAR(same(angle_of(bodies[2]), wanted.rocker), 0, left);
    CHECK_NEAR(bodies[0].spin_rad_s[2], 3, left);
    CHECK_NEAR(bodies[1].spin_rad_s[2], wanted.coupler_rate, 1e-11);
    CHECK_NEAR(bodies[2].spin_rad_s[2], wanted.rocker_rate, 1e-11);
    for (const Joint& each : made.mechanism.joints) CHECK(misfit_of(made.mechanism, each).speed_m_s < left);
    const auto told = std::ranges::find(made.definition, "closed_at_start.joint", &Definition::value_type::first);
    CHECK(told != made.definition.end());
  }
  // Where the other joints then stand, counted as their stops and springs are.
  const std::string held = closed(four_bar("q = 0.5\n", "stops = [-0.2, 1]\n")) +
                           "[[springs]]\njoint = \"elbow\"\nstiffness = 10\nrest = 0.3\n";
  const FourBar before(std::numbers::pi / 3);
  const FourBar after(std::numbers::pi / 3 + 0.5);
  const double foot = after.rocker - before.rocker;
  const double elbow = after.coupler - before.coupler - 0.5;
  const Scenario stopped = read(held);
  CHECK_NEAR(stopped.mechanism.joints[3].stop->low, -0.2 - foot, 1e-12);
  CHECK_NEAR(stopped.mechanism.joints[3].stop->high, 1 - foot, 1e-12);
  CHECK_NEAR(stopped.mechanism.joints[1].springs[0].rest, -(0.3 - elbow), 1e-12);
  const auto columns = std::ranges::find(stopped.definition, "closed_at_start.q", &Definition::value_type::first);
  const auto& q = std::get<std::vector<double>>(columns->second);
  CHECK(q.size() == 4 && q[0] == 0.5);
  CHECK_NEAR(q[1], elbow, 1e-12);
  CHECK_NEAR(q[3], foot, 1e-12);
  refused(replaced(held, "[-0.2, 1]", "[-0.2, 0.1]"), "joints.3.stops must have 0.2");
  // By its rocker, which the crank then follows: the same mechanism.
  const FourBar there(std::numbers::pi / 3 + 0.5);
  const double rocker = there.rocker - FourBar(std::numbers::pi / 3).rocker;
  const Mechanism led = read(closed(four_bar("", "q = " + digits(rocker) + "\n"))).mechanism;
  CHECK_NEAR(angle_of(led.bodies[0]), there.crank, 1e-12);
}

void loops_that_do_not_close() {
  refused(closed(four_bar("", "q = 2\n")),
          "joints.2 closes a loop that can not be closed with q as they are given: its halves stay");
  refused(closed(four_bar("q = 0.1\n", "q = 0.1\n")),
          "joints.2 closes a loop that can not be closed with q as they are given");
  refused(closed(four_bar("qd = 1\n", "qd = 1\n")), "joints.0.qd can not be had beside the other rates of its loop");
  // Nothing that could follow.
  refused(head + body("one", "[0, 0, 1]") + body("two", "[0, 0, 0.5]") +
              joint("hinge", "world", "one", "axis = [0, 1, 0]\nq = 0.3\n") + joint("fixed", "one", "two", "") +
              joint("fixed", "world", "two", "anchor = [0, 0, 0.5]\n"),
          "joints.2 closes a loop that can not be closed with q as they are given: its halves stay");
  // A parallelogram that would lie down in a line on its way.
  const std::string flat = head + bar("crank", {0, 0, 0}, 0.3, 1) + bar("rocker", {0.6, 0, 0}, 0.3, 1) +
                           bar("coupler", {0.3 * std::cos(1.0), 0.3 * std::sin(1.0), 0}, 0.6, 0) +
                           pin("drive", "world", "crank", {0, 0, 0}, "q = -1.5\n") +
                           pin("foot", "world", "rocker", {0.6, 0, 0}) +
                           pin("elbow", "crank", "coupler", {0.3 * std::cos(1.0), 0.3 * std::sin(1.0), 0}) +
                           pin("knee", "coupler", "rocker", {0.6 + 0.3 * std::cos(1.0), 0.3 * std::sin(1.0), 0});
  refused(flat, "joints.3 closes a loop that q leads through a line, or nearly, where it may branch off");
  const Mechanism upright = read(replaced(flat, "q = -1.5", "q = 1")).mechanism;
  CHECK_NEAR(angle_of(upright.bodies[1]), 2, 1e-12);
  CHECK_NEAR(angle_of(upright.bodies[2]), 0, 1e-12);
  std::string all = closed(four_bar("q = 0.1\n", "q = 0.1\n", "q = 0.1\n"));
  all = replaced(all, "name = \"knee\"\n", "name = \"knee\"\nq = 0.1\n");
  refused(all, "joints.3.q is one too many: all other joints of a loop say theirs");
}

// ---- Velocities that do not fit

// Two bodies of 1 kg and 3 kg on a hinge through the centres of both, with spins about it that may differ and
// velocities that may not: what they have together of momentum stays.
void velocities_that_nearly_fit() {
  const auto two = [](const char* speed) {
    return head + body("light", "[0, 0, 0]", std::string("velocity = [2, ") + speed + ", 0]\nspin = [0, 0, 1]\n") +
           replaced(body("heavy", "[0, 0, 0]", "velocity = [2, 0, 0]\n"), "mass = 1", "mass = 3") +
           joint("hinge", "light", "heavy", "axis = [0, 0, 1]\n");
  };
  const Scenario made = read(two("0.012"));
  for (const Body& each : made.mechanism.bodies) {
    CHECK_NEAR(distance(each.velocity_m_s, {2, 0.003, 0}), 0, rounding);
  }
  CHECK_NEAR(distance(made.mechanism.bodies[0].spin_rad_s, {0, 0, 1}), 0, rounding);
  CHECK_NEAR(distance(made.mechanism.bodies[1].spin_rad_s, {0, 0, 0}), 0, rounding);
  const auto told = [&](const char* key) {
    return std::ranges::find(made.definition, key, &Definition::value_type::first)->second;
  };
  CHECK_NEAR(std::get<double>(told("changed_at_start.velocity")), 0.009, rounding);
  CHECK_NEAR(std::get<double>(told("changed_at_start.spin")), 0, rounding);
  CHECK_EQUAL(std::get<std::string>(told("changed_at_start.body")), "light");
  refused(two("0.021"),
          "joints.0 does not allow the velocity and spin with which bodies.1 'heavy' starts beside "
          "'light': they part by 0.021 m/s and 0 rad/s");
  CHECK(std::ranges::none_of(read(two("0")).definition,
                             [](const auto& setting) { return setting.first.starts_with("changed_at_start"); }));
  // On an arm: a rod of 2 kg and 2 m that turns about its end, given 1 % too much at its centre. The end gives, about
  // which it has 8/3 kg m²: (2 * 1 * 2.02 + 2/3 * 2) / (8/3).
  const std::string rod = head +
                          "[[bodies]]\nname = \"rod\"\nmass = 2\nsize = [2, 1e-4, 1e-4]\nposition = [1, 0, 0]\n"
                          "velocity = [0, 2.02, 0]\nspin = [0, 0, 2]\n" +
                          joint("hinge", "world", "rod", "axis = [0, 0, 1]\n");
  CHECK_NEAR(read(rod).mechanism.bodies[0].spin_rad_s[2], (2 * 2.02 + 4.0 / 3) / (8.0 / 3), 1e-8);  // 1e-4 m thick
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
  a_four_bar();
  loops_that_do_not_close();
  velocities_that_nearly_fit();
  what_is_told();
  bad_starts();
  return test::verdict();
}
