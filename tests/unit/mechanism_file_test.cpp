// Files of mechanisms: what becomes of their bodies and joints, and what is refused.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/check.hpp"
#include "tests/scenario_text.hpp"

namespace {

using namespace odeval;
using test::read;
using test::refused;
using test::replaced;

// A turntable, a forearm on a hinge that turns with it, a hand on a universal joint, and a ball that flies.
const std::string arm = R"(problem = "mechanism"
duration = 1
[[bodies]]
name = "table"
mass = 2
size = [0.2, 0.2, 0.2]
spin = [0, 0, 2]
[[bodies]]
name = "forearm"
mass = 1
size = [1, 0.1, 0.1]
position = [0.5, 0, 0]
velocity = [0, 1, 0]
spin = [0, 0, 2]
inertia = [0.1, 0.2, 0.25, 0.01, 0.02, 0.03]
[[bodies]]
mass = 0.5
size = [0.2, 0.2, 0.2]
position = [1, 0, 0]
velocity = [0, 2, 0]
spin = [0, 0, 2]
[[bodies]]
name = "ball"
shape = "sphere"
mass = 0.5
size = [0.2, 0.2, 0.2]
[[joints]]
kind = "hinge"
parent = "world"
child = "table"
axis = [0, 0, 5]
[[joints]]
kind = "hinge"
parent = "table"
child = "forearm"
axis = [0, 3, 4]
[[joints]]
kind = "universal"
parent = "forearm"
child = "body3"
anchor = [1, 0, 0]
axis = [0, 2, 0]
axis2 = [0, 1e-7, 3]
)";

void what_becomes_of_it() {
  const Mechanism mechanism = read(arm).mechanism;
  CHECK_EQUAL(mechanism.bodies.size(), 4u);
  CHECK_EQUAL(mechanism.bodies[1].name, "forearm");
  CHECK_EQUAL(mechanism.bodies[2].name, "body3");
  CHECK(!mechanism.bodies[0].inertia_kgm2);
  const std::array<double, 9> tensor{0.1, 0.01, 0.02, 0.01, 0.2, 0.03, 0.02, 0.03, 0.25};
  CHECK(mechanism.bodies[1].inertia_kgm2 == tensor);
  CHECK_EQUAL(mechanism.joints.size(), 3u);
  CHECK_EQUAL(mechanism.joints[0].first, 0u);
  CHECK(!mechanism.joints[0].second);
  CHECK_EQUAL(mechanism.joints[1].first, 0u);  // the parent
  CHECK_EQUAL(mechanism.joints[1].second.value(), 1u);
  CHECK_EQUAL(mechanism.joints[1].carried(), 1u);
  CHECK_NEAR(distance(std::get<HingeJoint>(mechanism.joints[1].kind).axis, {0, 0.6, 0.8}), 0, 1e-15);
  const auto& universal = std::get<UniversalJoint>(mechanism.joints[2].kind);
  CHECK((universal.axis1 == Vec3{0, 1, 0}));
  CHECK((universal.axis2 == Vec3{0, 0, 1}));  // at right angles to the other
  CHECK((universal.anchor_m == Vec3{1, 0, 0}));
}

// On the world the child is the joint's first body, and `axis2`, which it carries, the first axis.
void a_universal_joint_on_the_world() {
  std::string text = replaced(arm, "kind = \"hinge\"", "kind = \"universal\"");
  text = replaced(text, "axis = [0, 0, 5]", "axis = [1, 0, 0]\naxis2 = [0, 0, 1]");
  const Mechanism mechanism = read(text).mechanism;
  const auto& universal = std::get<UniversalJoint>(mechanism.joints[0].kind);
  CHECK((universal.axis1 == Vec3{0, 0, 1}));
  CHECK((universal.axis2 == Vec3{1, 0, 0}));
}

void every_kind() {
  for (const char* kind : {"ball", "fixed"}) {
    const std::string text = replaced(replaced(arm, "kind = \"hinge\"\nparent = \"table\"",
                                               std::string("kind = \"") + kind + "\"\nparent = \"table\""),
                                      "axis = [0, 3, 4]\n", "");
    CHECK_EQUAL(read(text).mechanism.joints[1].kind.index(), std::string(kind) == "ball" ? 0u : 4u);
  }
  const std::string slides =
      replaced(arm, "kind = \"hinge\"\nparent = \"table\"", "kind = \"slider\"\nparent = \"table\"");
  CHECK_NEAR(distance(std::get<SliderJoint>(read(slides).mechanism.joints[1].kind).axis, {0, 0.6, 0.8}), 0, 1e-15);
}

void summaries_tell_all() {
  const Definition all = read(arm).definition;
  const auto has = [&](const char* key) {
    return std::ranges::any_of(all, [&](const auto& setting) { return setting.first == key; });
  };
  for (const char* key : {"bodies.0.name", "bodies.1.inertia", "joints.0.kind", "joints.1.parent", "joints.1.child",
                          "joints.2.anchor", "joints.2.axis2"}) {
    CHECK(has(key));
  }
  CHECK(!has("bodies.0.inertia"));
  CHECK(!has("joints.1.axis2"));
}

void refuses(const std::string& what, const std::string& with, const std::string& message) {
  refused(replaced(arm, what, with), message);
}

const std::string more =
    "[[joints]]\nkind = \"pu\"\nparent = \"forearm\"\nchild = \"ball\"\nanchor = [1, 1, 0]\n"
    "axis = [1, 0, 0]\naxis2 = [0, 2, 0]\naxis3 = [0, 1e-8, 3]\n"
    "[[joints]]\nkind = \"hinge2\"\nparent = \"body3\"\nchild = \"ball\"\nanchor = [1, 1, 1]\n"
    "axis = [0, 0, 1]\naxis2 = [0, 1, 0]\nsuspension = [500, 20]\n"
    "[[joints]]\nkind = \"pr\"\nparent = \"world\"\nchild = \"body3\"\naxis = [0, 0, 1]\naxis2 = [0, 1, 0]\n"
    "[[joints]]\nkind = \"piston\"\nparent = \"world\"\nchild = \"ball\"\naxis = [0, 0, 1]\n"
    "[[struts]]\nparent = \"world\"\nchild = \"ball\"\nfrom = [0, 0, 4]\nto = [0, 0, 1]\n"
    "stiffness = 100\ndamping = 2\n";

// The joints of the arm and these close loops.
void loops_and_more_kinds() {
  std::string text = replaced(arm, "velocity = [0, 1, 0]", "velocity = [0, 0, 0]");
  text = replaced(text, "spin = [0, 0, 2]\ninertia", "spin = [0, 0, 0]\ninertia");
  text = text.substr(0, text.find("[[joints]]"));
  for (std::size_t at; (at = text.find("spin")) != std::string::npos;) text.erase(at, text.find('\n', at) - at + 1);
  for (std::size_t at; (at = text.find("velocity")) != std::string::npos;) text.erase(at, text.find('\n', at) - at + 1);
  const Mechanism mechanism = read(text + more).mechanism;
  const auto& pu = std::get<SlidingUniversalJoint>(mechanism.joints[0].kind);
  CHECK((pu.way == Vec3{1, 0, 0}));
  CHECK((pu.axis1 == Vec3{0, 1, 0}));
  CHECK((pu.axis2 == Vec3{0, 0, 1}));  // at right angles to the other
  const auto& wheel = std::get<Hinge2Joint>(mechanism.joints[1].kind);
  CHECK_EQUAL(wheel.stiffness, 500.0);
  CHECK_EQUAL(wheel.damping, 20.0);
  CHECK(std::holds_alternative<SlidingHingeJoint>(mechanism.joints[2].kind));
  CHECK(!mechanism.joints[3].second);
  const Strut& strut = mechanism.struts.at(0);
  CHECK_EQUAL(strut.first, 3u);
  CHECK(!strut.second);
  CHECK((strut.first_end_m == Vec3{0, 0, 1}));
  CHECK_EQUAL(strut.rest_m, 3.0);  // as long as it is

  const auto wrong = [&](const char* what, const char* with, const char* message) {
    refused(replaced(text + more, what, with), message);
  };
  wrong("suspension = [500, 20]\n", "", "joints.1.suspension is missing; kind hinge2 needs it");
  wrong("suspension = [500, 20]", "suspension = [0, 0]",
        "joints.1.suspension = [0, 0]: must have a stiffness or a damping above 0");
  wrong("axis3 = [0, 1e-8, 3]", "axis3 = [0, 1, 3]", "joints.0.axis3 = [0, 1, 3]: must be at right angles to axis2");
  wrong("kind = \"piston\"", "kind = \"piston\"\nsuspension = [1, 1]",
        "joints.3.suspension has no meaning for kind piston; remove it");
  wrong("parent = \"body3\"\nchild = \"ball\"", "parent = \"world\"\nchild = \"ball\"",
        "joints.1.parent = world: must be a body for kind hinge2");
  wrong("kind = \"piston\"\nparent = \"world\"\nchild = \"ball\"\naxis = [0, 0, 1]",
        "kind = \"plane2d\"\nparent = \"body3\"\nchild = \"ball\"",
        "joints.3.parent = body3: must be the world for kind plane2d");
  wrong("from = [0, 0, 4]", "from = [0, 0, 1]", "struts.0.to = [0, 0, 1]: is where the other end is");
  wrong("[[struts]]\nparent = \"world\"", "[[struts]]\nparent = \"wall\"",
        "struts.0.parent = wall: is the name of no body");
}

void bad_bodies() {
  refuses("name = \"table\"", "name = \"forearm\"", "bodies.1.name = forearm: is the name of bodies.0 as well");
  refuses("name = \"table\"", "name = \"body3\"", "bodies.2.name = body3: is the name of bodies.0 as well");
  refuses("name = \"table\"", "name = \"world\"", "bodies.0.name = world: is what nothing moves; name it otherwise");
  for (const char* name : {"\"\"", "\"two words\"", "7", "\"a.b\"", "\"12345678901234567890123456789012345678901\""}) {
    refuses("name = \"table\"", std::string("name = ") + name, "bodies.0.name = ");
  }
  const std::string inertia = "inertia = [0.1, 0.2, 0.25, 0.01, 0.02, 0.03]";
  for (const char* tensor :
       {"[0.1, 0.2, 0.31, 0, 0, 0]",                                     // more than the other two together
        "[0.1, 0.2, 0.25, 0.2, 0, 0]",                                   // a negative moment
        "[0, 0, 0, 0, 0, 0]",                                            // none
        "[0, 0.2, 0.2, 0, 0, 0]",                                        // a line
        "[-0.1, 0.2, 0.25, 0, 0, 0]", "[0.2, 0.2, 0.2, 0, 0, 0.15]"}) {  // 0.35 is above 0.2 + 0.05
    refuses(inertia, std::string("inertia = ") + tensor, "bodies.1.inertia = ");
  }
  refuses(inertia, "inertia = [0.1, 0.2, 0.25]", "bodies.1.inertia = [0.1, 0.2, 0.25]: must be a list of 6 numbers");
  refuses(inertia, "inertia = [0.1, 0.2, nan, 0, 0, 0]", "bodies.1.inertia.2 = nan: must be a number");
  // A plate, whose one moment is the sum of the others, is a body.
  CHECK(
      read(replaced(arm, inertia, "inertia = [0.1, 0.2, 0.3, 0, 0, 0]")).mechanism.bodies[1].inertia_kgm2.has_value());
}

void bad_joints() {
  refuses("parent = \"table\"", "parent = \"tabel\"",
          "joints.1.parent = tabel: is the name of no body (nearest: 'table')");
  refuses("child = \"body3\"", "child = \"hand\"", "joints.2.child = hand: is the name of no body");
  refuses("child = \"table\"", "child = \"world\"", "joints.0.child = world: carries and is not carried");
  refuses("child = \"forearm\"", "child = \"table\"", "joints.1.child = table: is its parent as well");
  refuses("child = \"forearm\"", "child = \"forearm\"\naxis3 = [0, 0, 1]",
          "joints.1.axis3 has no meaning for kind hinge; remove it");
  refuses("kind = \"universal\"", "kind = \"cardan\"", "joints.2.kind = 'cardan': is not known (nearest: ");
  refuses("kind = \"universal\"\n", "", "joints.2.kind is missing; it must be one of ball, hinge, slider");
  refuses("parent = \"table\"\n", "", "joints.1.parent is missing; it must be a name");
  refuses("child = \"forearm\"\n", "", "joints.1.child is missing; it must be a name");
  refuses("axis = [0, 3, 4]", "axis = [0, 0, 0]", "joints.1.axis = [0, 0, 0]: must have a direction");
  refuses("axis2 = [0, 1e-7, 3]", "axis2 = [0, 0, 0]", "joints.2.axis2 = [0, 0, 0]: must have a direction");
  refuses("axis2 = [0, 1e-7, 3]", "axis2 = [0, 1, 1]", "joints.2.axis2 = [0, 1, 1]: must be at right angles to axis");
  refuses("axis = [0, 3, 4]", "axis2 = [0, 3, 4]", "joints.1.axis2 has no meaning for kind hinge; remove it");
  refuses("kind = \"hinge\"\nparent = \"table\"", "kind = \"ball\"\nparent = \"table\"",
          "joints.1.axis has no meaning for kind ball; remove it");
  CHECK_EQUAL(read(arm.substr(0, arm.find("[[joints]]"))).mechanism.joints.size(), 0u);  // all fly
  refused(arm.substr(0, arm.find("[[bodies]]")) + arm.substr(arm.find("[[joints]]")), "bodies = 0 tables");
  refused(arm + "[joint]\nkind = \"ball\"\n", "joint has no meaning for mechanism; remove it");
  refused(arm + "[ground]\n", "ground has no meaning for mechanism; remove it");
}

void bad_starts() {
  refuses("velocity = [0, 1, 0]", "velocity = [0, 1.5, 0]",
          "joints.1 does not allow the velocity and spin with which bodies.1 'forearm' starts beside 'table': they "
          "part by 0.5 m/s");
  CHECK_THROWS(read(replaced(arm, "spin = [0, 0, 2]\ninertia", "spin = [1, 0, 2]\ninertia")), UserError, "and 1 rad/s");
  refused(R"(problem = "mechanism"
duration = 1
[[bodies]]
mass = 1
size = [1, 1, 1]
[[joints]]
kind = "fixed"
parent = "world"
child = "body1"
)",
          "joints leave nothing that can move");
}

// ---- What drives, stops and loads joints

// The turntable hangs on the world, the forearm on the turntable: what is told of the child against the parent counts
// the other way round there.
const std::string driven = replaced(replaced(arm, "axis = [0, 0, 5]", R"(axis = [0, 0, 5]
name = "base"
stops = [-0.5, 1]
stop_restitution = 0.3
motor = {velocity = 2, force = 7})"),
                                    "axis = [0, 3, 4]", R"(axis = [0, 3, 4]
stops = [-0.25, 2]
motor = {velocity = 3, force = 5})") +
                           R"([[springs]]
joint = "joint2"
stiffness = 10
damping = 0.5
rest = 0.2
[[torques]]
joint = "joint2"
constant = 1
amplitude = 2
frequency = 3
phase = 0.5
times = [0, 1]
values = [0, 4]
[[controllers]]
joint = "joint2"
kp = 6
kd = 0.6
target = 0.7
[[controllers]]
joint = "base"
kp = 8
sampling = "continuous"
target = 0.1
)";

void what_acts_on_joints() {
  const Mechanism mechanism = read(driven).mechanism;
  const Joint& base = mechanism.joints[0];
  CHECK_EQUAL(base.name, "base");
  CHECK_EQUAL(base.stop->low, -0.5);
  CHECK_EQUAL(base.stop->high, 1.0);
  CHECK_EQUAL(base.stop->restitution, 0.3);
  CHECK_EQUAL(base.motor->speed, 2.0);
  CHECK_EQUAL(base.motor->most, 7.0);
  CHECK(base.controllers.size() == 1 && !base.controllers[0].sampled);
  CHECK_EQUAL(base.controllers[0].target.constant, 0.1);
  CHECK(base.springs.empty() && base.torques.empty());

  const Joint& elbow = mechanism.joints[1];
  CHECK_EQUAL(elbow.name, "joint2");
  CHECK_EQUAL(elbow.stop->low, -2.0);
  CHECK_EQUAL(elbow.stop->high, 0.25);
  CHECK_EQUAL(elbow.stop->restitution, 0.0);
  CHECK_EQUAL(elbow.motor->speed, -3.0);
  CHECK_EQUAL(elbow.motor->most, 5.0);
  CHECK_EQUAL(elbow.springs.at(0).rest, -0.2);
  CHECK(elbow.controllers.at(0).sampled);
  // Of the child at 0.3 rad and 0.4 rad/s, which is the parent at -0.3 rad: each load pulls the other way.
  const double t = 0.25;
  const double torque = 1 + 2 * std::sin(2 * std::numbers::pi * 3 * t + 0.5) + 1;
  CHECK_NEAR(elbow.steady_load(t, -0.3, -0.4), -(torque - 10 * (0.3 - 0.2) - 0.5 * 0.4), 1e-15);
  CHECK_NEAR(elbow.sampled_load(t, -0.3, -0.4), -(6 * (0.7 - 0.3) - 0.6 * 0.4), 1e-15);
  CHECK_NEAR(base.steady_load(t, 0.3, 0.4), 8 * (0.1 - 0.3), 1e-15);

  const Definition all = read(driven).definition;
  for (const char* key :
       {"joints.0.name", "joints.0.stops", "joints.0.stop_restitution", "joints.1.motor.velocity",
        "joints.1.motor.force", "springs.0.joint", "springs.0.stiffness", "springs.0.damping", "springs.0.rest",
        "torques.0.constant", "torques.0.amplitude", "torques.0.frequency", "torques.0.phase", "torques.0.times",
        "torques.0.values", "controllers.0.kp", "controllers.0.kd", "controllers.0.target", "controllers.1.sampling"}) {
    CHECK(std::ranges::any_of(all, [&](const auto& setting) { return setting.first == key; }));
  }
}

// Something of its own on each motion of the universal joint.
const std::string driven_twice = replaced(arm, "axis2 = [0, 1e-7, 3]", R"(axis2 = [0, 1e-7, 3]
stops2 = [-0.5, 1.5]
stop_restitution2 = 0.4
motor = {velocity = 3, force = 5})") +
                                 R"([[springs]]
joint = "joint3"
motion = 2
stiffness = 10
rest = 0.2
[[springs]]
joint = "joint3"
motion = 2
damping = 0.5
[[torques]]
joint = "joint3"
motion = 1
constant = 1
[[controllers]]
joint = "joint3"
motion = 2
kp = 6
target = 0.7
)";

void what_acts_on_motions() {
  const Joint joint = read(driven_twice).mechanism.joints[2];
  CHECK(!joint.motor && !joint.stop && !joint.loaded() && joint.driven());
  CHECK_EQUAL(joint.drives.size(), 2u);
  const AxisDrive& first = joint.drives[0];
  CHECK(first.motion == 0 && first.number == 1 && !first.stop && first.springs.empty() && first.controllers.empty());
  CHECK_EQUAL(first.motor->speed, -3.0);  // of the forearm against what it carries
  CHECK_EQUAL(first.motor->most, 5.0);
  CHECK_EQUAL(first.torques.at(0).constant, -1.0);
  const AxisDrive& second = joint.drives[1];
  CHECK(second.motion == 1 && second.number == 2 && !second.motor && second.torques.empty());
  CHECK_EQUAL(second.stop->low, -1.5);
  CHECK_EQUAL(second.stop->high, 0.5);
  CHECK_EQUAL(second.stop->restitution, 0.4);
  CHECK_EQUAL(second.springs.size(), 2u);
  CHECK_EQUAL(second.springs[0].rest, -0.2);
  CHECK_EQUAL(second.springs[1].damping, 0.5);
  CHECK_EQUAL(second.controllers.at(0).target.constant, -0.7);
  CHECK(joint.sampled());  // of one motion as of a hinge: another step is another motion
  CHECK(!read(driven_twice + "sampling = \"continuous\"\n").mechanism.joints[2].sampled());

  const Definition all = read(driven_twice).definition;
  for (const char* key : {"joints.2.stops2", "joints.2.stop_restitution2", "springs.0.motion", "torques.0.motion",
                          "controllers.0.motion"}) {
    CHECK(std::ranges::any_of(all, [&](const auto& setting) { return setting.first == key; }));
  }
  // On the world the joint's first axis is the one that the child carries.
  const std::vector<AxisDrive> on_world =
      read(replaced(driven_twice, "kind = \"hinge\"\nparent = \"world\"",
                    "kind = \"universal\"\naxis2 = [1, 0, 0]\nstops2 = [-0.1, 0.3]\nparent = \"world\""))
          .mechanism.joints[0]
          .drives;
  CHECK_EQUAL(on_world.size(), 1u);
  CHECK(on_world[0].motion == 0 && on_world[0].number == 2);
  CHECK_EQUAL(on_world[0].stop->high, 0.3);
  // Of pu the way stays the first, and its turns change places.
  const std::vector<AxisDrive> pu =
      read(replaced(driven_twice, "kind = \"hinge\"\nparent = \"world\"",
                    "kind = \"pu\"\naxis2 = [1, 0, 0]\naxis3 = [0, 0, 1]\nstops = [-0.2, 0.1]\nstops2 = [-0.1, 0.3]\n"
                    "motor3 = {velocity = 2, force = 1}\nparent = \"world\""))
          .mechanism.joints[0]
          .drives;
  CHECK_EQUAL(pu.size(), 3u);
  CHECK(pu[0].motion == 0 && pu[0].number == 1 && pu[0].stop->high == 0.1);
  CHECK(pu[1].motion == 2 && pu[1].number == 2 && pu[1].stop->high == 0.3);
  CHECK(pu[2].motion == 1 && pu[2].number == 3 && pu[2].motor->speed == 2);
}

void a_signal_over_time() {
  const Signal table{.constant = 1, .times_s = {1, 2, 4}, .values = {2, 10, -10}};
  for (const auto& [t, value] : {std::pair{0.0, 3.0}, {1.0, 3.0}, {1.5, 7.0}, {2.0, 11.0}, {3.0, 1.0}, {9.0, -9.0}}) {
    CHECK_NEAR(table.at(t), value, 1e-14);
  }
}

void bad_drives() {
  const auto wrong = [](const char* what, const char* with, const char* message) {
    refused(replaced(driven, what, with), message);
  };
  wrong("stops = [-0.5, 1]", "stops = [0.5, 1]", "joints.0.stops = [0.5, 1]: must be a low and a high end with 0");
  wrong("stops = [-0.5, 1]", "stops = [0, 0]", "joints.0.stops = [0, 0]: must be a low and a high end");
  wrong("stops = [-0.5, 1]", "stops = [-4, 1]", "joints.0.stops = [-4, 1]: must lie within half a turn");
  wrong("stops = [-0.5, 1]", "stops = [1]", "joints.0.stops = [1]: must be a list of 2 numbers");
  wrong("stops = [-0.5, 1]\n", "", "joints.0.stops is missing, or stop_restitution is to be removed");
  wrong("stop_restitution = 0.3", "stop_restitution = 1.5", "joints.0.stop_restitution = 1.5: must be a number from 0");
  wrong("{velocity = 2, force = 7}", "{velocity = 2}", "joints.0.motor.force is missing");
  wrong("{velocity = 2, force = 7}", "{velocity = 2, force = -7}", "joints.0.motor.force = -7: must be a number");
  wrong("{velocity = 2, force = 7}", "{velocity = 2, force = 7, power = 3}",
        "joints.0.motor.power = 3: is no known key");
  wrong("motor = {velocity = 2, force = 7}", "motor = 7", "joints.0.motor = 7: must be a table [joints.motor]");
  wrong("name = \"base\"", "name = \"joint2\"", "joints.1.name = joint2: is the name of joints.0 as well");
  wrong("axis2 = [0, 1e-7, 3]", "axis2 = [0, 1e-7, 3]\nmotor3 = {velocity = 2, force = 7}",
        "joints.2.motor3 has no meaning for kind universal");
  wrong("motor = {velocity = 2, force = 7}", "motor2 = {velocity = 2, force = 7}",
        "joints.0.motor2 has no meaning for kind");
  wrong("joint = \"base\"", "joint = \"bass\"",
        "controllers.1.joint = bass: is the name of no joint (nearest: 'base')");
  wrong("joint = \"base\"", "joint = \"joint3\"",
        "controllers.1.motion is missing; it must be from 1 to 2, the number of a motion of joint 'joint3'");
  wrong("stiffness = 10", "stiffness = -10", "springs.0.stiffness = -10: must be a number from 0");
  wrong("stiffness = 10", "attitude = 10", "springs.0.attitude = 10: is no known key (there are joint, ");
  wrong("stiffness = 10", "stifness = 10", "springs.0.stifness = 10: is no known key (nearest: 'springs.0.stiffness')");
  wrong("stiffness = 10\ndamping = 0.5", "damping = 0", "springs.0 does nothing: stiffness and damping are 0");
  const char* const torque = "constant = 1\namplitude = 2\nfrequency = 3\nphase = 0.5\ntimes = [0, 1]\nvalues = [0, 4]";
  for (const char* nothing : {"", "amplitude = 0\nfrequency = 3", "amplitude = 2", "times = [0, 1]\nvalues = [0, 0]"}) {
    wrong(torque, nothing, "torques.0 does nothing: give a constant, an amplitude with a frequency, or values");
  }
  CHECK_EQUAL(read(replaced(driven, torque, "amplitude = 2\nphase = 0.5")).mechanism.joints[1].torques.size(), 1U);
  wrong("kp = 6\nkd = 0.6", "kp = 0", "controllers.0 does nothing: kp and kd are 0");
  wrong("kp = 6\n", "", "controllers.0.kp is missing");
  wrong("sampling = \"continuous\"", "sampling = \"always\"", "controllers.1.sampling = 'always': must be one of step");
  wrong("times = [0, 1]", "times = [1, 1]", "torques.0.times must rise from each to the next");
  wrong("times = [0, 1]", "times = [0]", "torques.0.values = 2 numbers: must be as many as times, 1");
  refused(driven + "[\"joints.motor\"]\nvelocity = 1\n", "joints.motor");
  const std::string box = "problem = \"free_box\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [1, 1, 1]\n";
  refused(box + "[[springs]]\njoint = \"joint1\"\n", "springs has no meaning for free_box; remove it");
}

// ---- What may touch

const std::string touching = driven + R"([[planes]]
name = "wall"
normal = [3e-200, 0, 4e-200]
point = [1, 2, 3]
[[contacts]]
between = ["wall", "ball"]
restitution = 0.5
[[contacts]]
friction = 0.3
)";

void what_touches() {
  const Scenario scenario = read(touching);
  const Mechanism& mechanism = scenario.mechanism;
  const auto& plane = std::get<HalfSpace>(mechanism.obstacles.at(0).shape);
  CHECK_EQUAL(mechanism.obstacles.at(0).name, "wall");
  CHECK_NEAR(distance(plane.normal, {0.6, 0, 0.8}), 0, 1e-15);
  CHECK_NEAR(plane.offset_m, 3, 1e-15);
  const Contact& first = mechanism.contacts.at(0);
  CHECK(first.first == "wall" && first.second == "ball" && first.restitution == 0.5 && !first.friction);
  const Contact& any = mechanism.contacts.at(1);
  CHECK(any.first.empty() && any.second.empty() && any.restitution == 0 && any.friction->limit == 0.3);
  for (const char* key : {"planes.0.name", "planes.0.normal", "planes.0.point", "contacts.0.between.0",
                          "contacts.0.between.1", "contacts.0.restitution", "contacts.1.friction"}) {
    CHECK(std::ranges::any_of(scenario.definition, [&](const auto& setting) { return setting.first == key; }));
  }
}

void bad_contacts() {
  const auto wrong = [](const char* what, const char* with, const char* message) {
    refused(replaced(touching, what, with), message);
  };
  wrong("normal = [3e-200, 0, 4e-200]", "normal = [0, 0, 0]", "planes.0.normal = [0, 0, 0]: must have a direction");
  wrong("name = \"wall\"", "name = \"ball\"", "planes.0.name = ball: is the name of something else as well");
  wrong("name = \"wall\"\n", "", "planes.0.name is missing");
  wrong("[\"wall\", \"ball\"]", "[\"wall\", \"bell\"]",
        "contacts.0.between.1 = bell: is the name of no body and no plane (nearest: 'ball')");
  wrong("[\"wall\", \"ball\"]", "[\"wall\"]", "contacts.0.between = ['wall']: must be a list of 2 names");
  wrong("[\"wall\", \"ball\"]", "[\"wall\", \"wall\"]", "contacts.0.between = [wall, wall]: must be two");
  wrong("[\"wall\", \"ball\"]", "[\"table\", \"forearm\"]",
        "contacts.0.between = [table, forearm]: hang together by joint 'joint2'");
  wrong("restitution = 0.5", "restitution = 1.5", "contacts.0.restitution = 1.5: must be a number from 0 to 1");
  refused(driven + "[[planes]]\nname = \"wall\"\n", "planes have a meaning only where [[contacts]] say what touches");
  const std::string box = "problem = \"free_box\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [1, 1, 1]\n";
  refused(box + "[[contacts]]\nrestitution = 0.5\n", "contacts has no meaning for free_box; remove it");
}

// What a mechanism says has no meaning elsewhere.
void no_mechanism() {
  const std::string box = "problem = \"free_box\"\nduration = 1\n[[bodies]]\nmass = 1\nsize = [1, 1, 1]\n";
  refused(box + "name = \"a\"\n", "bodies.0.name has no meaning for free_box; remove it");
  refused(box + "inertia = [1, 1, 1, 0, 0, 0]\n", "bodies.0.inertia has no meaning for free_box; remove it");
  refused(box + "[[joints]]\nkind = \"ball\"\nparent = \"world\"\nchild = \"body1\"\n",
          "joints has no meaning for free_box");
  const std::string sprung = replaced(box, "free_box", "spring_joint") + "[joint]\nkind = \"slider\"\n";
  refused(sprung, "joint.kind = 'slider': must be one of ball, hinge");
}

void settings_reach_in() {
  const Scenario turned = read(arm, {{"joints.1.axis", "[0, 1, 0]", "--set"}, {"bodies.1.inertia.2", "0.2", "--set"}});
  CHECK((std::get<HingeJoint>(turned.mechanism.joints[1].kind).axis == Vec3{0, 1, 0}));
  CHECK_EQUAL((*turned.mechanism.bodies[1].inertia_kgm2)[8], 0.2);
  CHECK_THROWS(read(arm, {{"joints.1.parent", "nobody", "--set"}}), UserError,
               "--set joints.1.parent=nobody: joints.1.parent is the name of no body");
}

}  // namespace

int main() {
  what_becomes_of_it();
  a_universal_joint_on_the_world();
  every_kind();
  loops_and_more_kinds();
  summaries_tell_all();
  bad_bodies();
  bad_joints();
  bad_starts();
  what_acts_on_joints();
  what_acts_on_motions();
  a_signal_over_time();
  bad_drives();
  what_touches();
  bad_contacts();
  no_mechanism();
  settings_reach_in();
  return test::verdict();
}
