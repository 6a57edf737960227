// ODE with what no scenario file can say yet: motors, stops, inertia tensors, contacts between named things.
#include <fmt/format.h>

#include <array>
#include <numbers>
#include <string>

#include "measure/body_trace.hpp"
#include "model/read_scenario.hpp"
#include "tests/check.hpp"
#include "tests/contract/moved.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using test::moved;

constexpr double step_s = 1e-3;

/// An engine, and what its arithmetic leaves of numbers of order 1: QuickStep's relaxation takes away 0.7 of an error
/// in each of its 20 iterations, where rows do not act on one another; in single precision positions that round by 1e-7
/// come back as velocities by ERP / h = 200.
struct Stepper {
  const char* method;
  double rounding;
};
constexpr Stepper direct{"ode-step-double", 1e-13};
constexpr std::array steppers{direct, Stepper{"ode-quickstep-double", 2e-10}, Stepper{"ode-step-single", 1e-4}};

/// Nothing but joints and contacts acts, and those without softness.
Scenario weightless(int steps) {
  Scenario scenario;
  scenario.name = "weightless";
  scenario.step_s = step_s;
  scenario.duration_s = steps * step_s;
  scenario.gravity = 0;
  scenario.ode.cfm = 0;
  return scenario;
}

// A wheel: a box that turns about an axis through its centre, so that the hinge's rows have nothing to do. The axis is
// one of its own, and looks along -y for the sign's sake.
constexpr Vec3 wheel_axis{0, -1, 0};
const Body wheel{.shape = Box{{0.3, 0.1, 0.4}}, .mass_kg = 2};
const double wheel_moment = 2 * (0.3 * 0.3 + 0.4 * 0.4) / 12;  // kg m²

Scenario turning_wheel(int steps, double spin_rad_s) {
  Scenario scenario = weightless(steps);
  scenario.mechanism.bodies = {wheel};
  scenario.mechanism.bodies[0].spin_rad_s = spin_rad_s * wheel_axis;
  scenario.mechanism.joints = {{.kind = HingeJoint{{0, 0, 0}, wheel_axis}, .second = {}}};
  return scenario;
}

/// Of body `i` about the hinge's axis, rad/s.
double rate(const Motion& motion, std::size_t k, std::size_t i = 0) {
  return dot(motion[k].bodies[i].spin, wheel_axis);
}

/// The same, rad, within half a turn: where its own x axis points.
double angle(const Motion& motion, std::size_t k, std::size_t i = 0) {
  const Vec3 x = axis_of(motion[k].bodies[i].rotation, 0);
  return std::atan2(dot(x, cross(wheel_axis, {1, 0, 0})), x[0]);
}

// Motors -----------------------------------------------------------------------------------------------------------

/// With torque to spare the speed is there after one step, and stays: up from rest, and down from above.
void a_strong_motor_has_its_speed_in_a_step(const Stepper& stepper) {
  for (const double start : {0.0, 5.0}) {
    Scenario scenario = turning_wheel(20, start);
    scenario.mechanism.joints[0].motor = Motor{3, 1e6};
    const Motion motion = moved(scenario, stepper.method);
    CHECK_NEAR(rate(motion, 0), start, stepper.rounding);
    for (std::size_t k = 1; k < motion.size(); ++k) CHECK_NEAR(rate(motion, k), 3, 3 * stepper.rounding);
    CHECK(angle(motion, 20) > 0);
  }
}

/// With little torque the speed grows, or falls, by T h / I a step until it is there.
void a_weak_motor_keeps_within_its_torque(const Stepper& stepper) {
  constexpr double torque = 4;
  const double gain = torque * step_s / wheel_moment;  // 0.096 rad/s: 3 rad/s take 31.25 steps
  for (const double wanted : {3.0, -3.0}) {
    Scenario scenario = turning_wheel(50, 0);
    scenario.mechanism.joints[0].motor = Motor{wanted, torque};
    const Motion motion = moved(scenario, stepper.method);
    for (std::size_t k = 0; k < motion.size(); ++k) {
      const double speed = std::fmin(static_cast<double>(k) * gain, 3);
      CHECK_NEAR(rate(motion, k), std::copysign(speed, wanted), 3 * stepper.rounding);
    }
  }
}

/// Between two bodies the first turns forwards and the second backwards, by as much momentum.
void a_motor_turns_the_first_against_the_second(const Stepper& stepper) {
  Scenario scenario = turning_wheel(10, 0);
  scenario.mechanism.bodies.push_back(wheel);
  scenario.mechanism.bodies[1].mass_kg = 6;  // three times the moment
  scenario.mechanism.joints[0].second = 1;
  scenario.mechanism.joints[0].motor = Motor{4, 1e6};
  const Motion motion = moved(scenario, stepper.method);
  for (std::size_t k = 1; k < motion.size(); ++k) {
    CHECK_NEAR(rate(motion, k, 0), 3, 4 * stepper.rounding);
    CHECK_NEAR(rate(motion, k, 1), -1, 4 * stepper.rounding);
  }
}

// Stops ------------------------------------------------------------------------------------------------------------

/// Bounces back with its restitution in the first step that begins beyond the stop, which is a step's way at most.
void a_stop_bounces(const Stepper& stepper) {
  for (const double direction : {1.0, -1.0}) {
    Scenario scenario = turning_wheel(200, 2 * direction);
    scenario.mechanism.joints[0].stop = Stop{-0.2503, 0.1507, 0.75};
    const Motion motion = moved(scenario, stepper.method);
    const double end = direction > 0 ? 0.1507 : 0.2503;
    std::size_t beyond = 0;
    while (beyond + 1 < motion.size() && direction * angle(motion, beyond) < end) ++beyond;
    CHECK_EQUAL(beyond, static_cast<std::size_t>(std::ceil(end / (2 * step_s))));
    CHECK_BETWEEN(direction * angle(motion, beyond) - end, 0, 2 * step_s);
    for (std::size_t k = 0; k <= beyond; ++k) CHECK_NEAR(rate(motion, k), 2 * direction, 2 * stepper.rounding);
    for (std::size_t k = beyond + 1; k < motion.size(); ++k) {
      CHECK_NEAR(rate(motion, k), -1.5 * direction, 2 * stepper.rounding);
    }
  }
}

constexpr double pressing_torque = 5;  // N m

/// How far a wheel at 2 rad/s is beyond its stop in each step, from the first one on.
std::vector<double> beyond_stop(const Stepper& stepper, double direction, bool driven) {
  constexpr double end = 0.1507;
  Scenario scenario = turning_wheel(200, 2 * direction);
  Joint& hinge = scenario.mechanism.joints[0];
  hinge.stop = Stop{-end, end, 0};
  if (driven) hinge.motor = Motor{2 * direction, pressing_torque};
  const Motion motion = moved(scenario, stepper.method);
  std::vector<double> beyond;
  for (std::size_t k = 76; k < motion.size(); ++k) beyond.push_back(direction * angle(motion, k) - end);
  CHECK(direction * angle(motion, 75) < end);
  CHECK_BETWEEN(beyond[0], 0, 2 * step_s);
  return beyond;
}

/// Without restitution it holds, by the ERP's part a step of what is beyond: with a motor that presses, all of it dies
/// away; else the wheel leaves with the speed of the first such step, as a stop does not pull.
void a_stop_holds(const Stepper& stepper) {
  constexpr double erp = 0.2;
  // ODE turns by 2 atan(h w / 2) instead of h w: 1e-11 of an angle of 4e-4, a hundred times.
  const double most = 1e-9 + stepper.rounding;
  // Single precision's rounding may lift the wheel off its stop, and the motor has a step for itself: 1.2e-4 rad.
  const bool lifts = stepper.rounding > 1e-6;
  const double lifted = lifts ? pressing_torque * step_s * step_s / wheel_moment : 0;
  for (const double direction : {1.0, -1.0}) {
    const std::vector<double> pressed = beyond_stop(stepper, direction, true);
    const std::vector<double> left = beyond_stop(stepper, direction, false);
    for (std::size_t k = 0; k < pressed.size(); ++k) {
      CHECK_NEAR(pressed[k], pressed[0] * std::pow(1 - erp, static_cast<double>(k)), most + lifted);
      CHECK_NEAR(left[k], left[0] * (1 - erp * static_cast<double>(k)), most);
    }
  }
}

// Inertia ----------------------------------------------------------------------------------------------------------

/// R diag(m) R^T
std::array<double, 9> turned_tensor(const Rotation& r, const Vec3& moments) {
  std::array<double, 9> tensor{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) tensor[3 * i + j] += r[3 * i + k] * moments[k] * r[3 * j + k];
    }
  }
  return tensor;
}

/// A box that starts turned, and a ball that does not, whose tensor is that box's in the world: the same tumbling, seen
/// from other axes.
void a_tensor_tumbles_as_the_turned_box() {
  Scenario scenario = weightless(1000);
  const Vec3 turn{0.4, -1.1, 0.7};
  const Body box{.shape = Box{{0.2, 0.5, 0.9}},
                 .mass_kg = 3,
                 .attitude = turn,
                 .velocity_m_s = {0.1, 0.2, 0.3},
                 .spin_rad_s = {2, -1, 1.5}};
  scenario.mechanism.bodies = {box};
  const Motion wanted = moved(scenario, direct.method);
  const Rotation start = wanted[0].bodies[0].rotation;
  const Trace wanted_trace = body_trace(scenario, sample_grid(scenario), wanted);

  Body& other = scenario.mechanism.bodies[0];
  other.shape = Sphere{0.5};
  other.attitude = Vec3{};
  other.inertia_kgm2 = turned_tensor(start, box.uniform_moments_kgm2());
  CHECK(std::fabs((*other.inertia_kgm2)[1]) > 0.01 && std::fabs((*other.inertia_kgm2)[2]) > 0.01 &&
        std::fabs((*other.inertia_kgm2)[5]) > 0.01);  // a full one
  const Motion motion = moved(scenario, direct.method);
  const Trace trace = body_trace(scenario, sample_grid(scenario), motion);

  // A thousand steps that round by 1e-16 of numbers of order 1, and a tumbling that lets them grow some times.
  constexpr double rounding = 1e-12;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const BodyState& a = motion[k].bodies[0];
    const BodyState& b = wanted[k].bodies[0];
    CHECK_NEAR(distance(a.position, b.position), 0, rounding);
    CHECK_NEAR(distance(a.spin, b.spin), 0, rounding);
    for (std::size_t axis = 0; axis < 3; ++axis) {  // an axis of the box, as the other body carries it along
      CHECK_NEAR(distance(turned(a.rotation, axis_of(start, axis)), axis_of(b.rotation, axis)), 0, rounding);
    }
    CHECK_NEAR(trace.kinetic[k], wanted_trace.kinetic[k], rounding);
    CHECK_NEAR(trace.angular_momentum_drift[k], wanted_trace.angular_momentum_drift[k], rounding);
  }
  CHECK(distance(motion[1000].bodies[0].spin, motion[0].bodies[0].spin) > 0.5);  // or nothing tumbled
}

// Contacts between named things ------------------------------------------------------------------------------------

Body ball(const char* name, double x, double speed) {
  return {.shape = Sphere{0.2}, .mass_kg = 1, .position_m = {x, 0, 0}, .velocity_m_s = {speed, 0, 0}, .name = name};
}

/// Speeds at the end of three equal balls in a row, of which the first comes with 1 m/s, and the most contacts.
struct Row {
  std::array<double, 3> speeds;
  double contacts;
};

Row three_in_a_row(const std::vector<Contact>& contacts, const Stepper& stepper) {
  Scenario scenario = weightless(900);
  scenario.mechanism.bodies = {ball("a", -0.4, 1), ball("b", 0, 0), ball("c", 0.4, 0)};
  scenario.mechanism.contacts = contacts;
  const Motion motion = moved(scenario, stepper.method);
  Row row{};
  for (std::size_t k = 0; k < motion.size(); ++k) row.contacts = std::max(row.contacts, motion[k].contacts);
  for (std::size_t i = 0; i < 3; ++i) row.speeds[i] = motion[900].bodies[i].velocity[0];
  return row;
}

void check_row(const Row& row, const std::array<double, 3>& wanted, const Stepper& stepper) {
  for (std::size_t i = 0; i < 3; ++i) CHECK_NEAR(row.speeds[i], wanted[i], stepper.rounding);
  CHECK_EQUAL(row.contacts, wanted[0] == 1 ? 0.0 : 1.0);
}

/// Of equal masses the first keeps (1 - e) / 2 of its speed and the second has (1 + e) / 2.
void contacts_are_between_whom_they_name(const Stepper& stepper) {
  check_row(three_in_a_row({}, stepper), {1, 0, 0}, stepper);
  // From one to the next, to the last.
  check_row(three_in_a_row({{.restitution = 1}}, stepper), {0, 0, 1}, stepper);
  // The second goes through the third, whichever way the rule names them.
  check_row(three_in_a_row({{.restitution = 1, .first = "a", .second = "b"}}, stepper), {0, 1, 0}, stepper);
  check_row(three_in_a_row({{.restitution = 0.5, .first = "b", .second = "a"}}, stepper), {0.25, 0.75, 0}, stepper);
  check_row(three_in_a_row({{.restitution = 1, .first = "c", .second = "a"}}, stepper), {0, 0, 1}, stepper);
  // The first rule that names them both.
  check_row(three_in_a_row({{.restitution = 0.5, .first = "a", .second = "b"}, {.restitution = 1}}, stepper),
            {0.25, 0, 0.75}, stepper);
  check_row(three_in_a_row({{.restitution = 1}, {.restitution = 0.5, .first = "a", .second = "b"}}, stepper), {0, 0, 1},
            stepper);
}

/// What stands still has a name as well: one ball falls on the ground, the other through it.
void a_ground_is_there_for_whom_it_is_named(const Stepper& stepper) {
  Scenario scenario = weightless(600);
  scenario.mechanism.bodies = {ball("a", -1, 0), ball("b", 1, 0)};
  for (Body& body : scenario.mechanism.bodies) {
    body.position_m[2] = 0.3;
    body.velocity_m_s[2] = -1;
  }
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  scenario.mechanism.contacts = {{.restitution = 0.5, .first = "a", .second = "ground"}};
  const Motion motion = moved(scenario, stepper.method);
  CHECK_NEAR(motion[600].bodies[0].velocity[2], 0.5, stepper.rounding);
  CHECK_NEAR(motion[600].bodies[1].velocity[2], -1, stepper.rounding);
}

/// Bodies that a joint connects pass through each other, whatever the rules.
void joined_bodies_do_not_touch(const Stepper& stepper) {
  Scenario scenario = weightless(10);
  scenario.mechanism.bodies = {ball("a", -0.05, 0), ball("b", 0.05, 0)};  // overlap
  scenario.mechanism.contacts = {{.restitution = 1}};
  CHECK_EQUAL(moved(scenario, stepper.method)[5].contacts, 1.0);
  scenario.mechanism.joints = {{.kind = BallJoint{}, .first = 0, .second = 1}};
  CHECK_EQUAL(moved(scenario, stepper.method)[5].contacts, 0.0);
}

// A plane away from the origin: a ball that falls on it turns round where it lies, as far as a step goes; what stands
// on the plane touches nothing.
void a_raised_plane_is_where_it_says() {
  Scenario scenario = weightless(100);
  scenario.mechanism.bodies = {
      {.shape = Sphere{0.2}, .mass_kg = 1, .position_m = {0, 0, 0.8505}, .velocity_m_s = {0, 0, -1}, .name = "ball"}};
  scenario.mechanism.obstacles = {{HalfSpace{{0, 0, 1}, 0.7}, "ground"}, {FixedBox{{5, 0, 1}, {1, 1, 1}}, "box"}};
  scenario.mechanism.contacts = {{.restitution = 1}};
  scenario.impact_views = {{.normal = {0, 0, 1}}};
  const catalogue::Method& row = catalogue::find_method("ode-step-double");
  const test::Recorded run = test::recorded(row.make, scenario, sample_grid(scenario));
  double lowest = 1;
  for (std::size_t k = 0; k < run.motion.size(); ++k) lowest = std::min(lowest, run.motion[k].bodies[0].position[2]);
  CHECK_NEAR(lowest, 0.7995, 1e-12);  // half a step below where it touches
  CHECK_EQUAL(run.outcome.impacts.size(), std::size_t{1});
  for (const Impact& impact : run.outcome.impacts) CHECK_NEAR(impact.t, 0.051, 1e-12);
  double contacts = 0;
  for (std::size_t k = 0; k < run.motion.size(); ++k) contacts += run.motion[k].contacts;
  CHECK_BETWEEN(contacts, 1, 3);  // the ball's alone
  const Trace trace = body_trace(scenario, sample_grid(scenario), run.motion);
  CHECK_NEAR(*std::ranges::max_element(trace.penetration), 0.0005, 1e-12);
}

/// A cube in the plane turns about z, and a spring counts that turn, whichever of its sides lies below.
void a_plane_counts_turns_on_every_side() {
  constexpr double half = std::numbers::pi, stiffness = 2, rest = 0.3, side = 0.2;
  const double fast = std::sqrt(stiffness / (side * side / 6));  // rad/s, of 1 kg
  const double t = 0.2;
  const double wanted = rest * fast * std::sin(fast * t) + std::cos(fast * t);  // rad/s, from 1 rad/s at 0
  for (const Vec3& attitude :
       {Vec3{}, Vec3{half, 0, 0}, Vec3{0, half, 0}, Vec3{half / 2, 0, 0}, Vec3{0, half / 2, 0}, Vec3{2, 0, 2}}) {
    Scenario scenario = weightless(200);
    scenario.mechanism.bodies = {
        {.shape = Box{{side, side, side}}, .mass_kg = 1, .attitude = attitude, .spin_rad_s = {0, 0, 1}}};
    Joint plane{.kind = PlaneJoint{}, .first = 0, .second = {}};
    plane.drives = {{.motion = 2, .number = 3, .springs = {{.stiffness = stiffness, .damping = 0, .rest = rest}}}};
    scenario.mechanism.joints = {plane};
    const Motion motion = moved(scenario, "ode-step-double");
    // Half a step of the greatest acceleration, fast² (rest + 1 / fast): 0.054; the scheme itself is 0.003 off.
    CHECK_NEAR(motion[200].bodies[0].spin[2], wanted, 0.054);
  }
}

// Two boxes, one on the other, that slide in directions at right angles: friction acts along the way that one slides on
// the other, which neither goes by itself.
void friction_acts_along_what_both_do() {
  Scenario scenario = weightless(50);
  scenario.gravity = 10;
  scenario.ode.cfm = 1e-6;  // four corners share one load
  scenario.ode.friction_axes = FrictionAxes::sliding;
  const auto box = [](double z, const Vec3& velocity, const char* name) {
    return Body{
        .shape = Box{{1, 1, 0.2}}, .mass_kg = 1, .position_m = {0, 0, z}, .velocity_m_s = velocity, .name = name};
  };
  scenario.mechanism.bodies = {box(0.1, {0, 1, 0}, "lower"), box(0.3, {1, 0, 0}, "upper")};
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  scenario.mechanism.contacts = {{.friction = Friction{0}, .first = "lower", .second = "ground"},
                                 {.friction = Friction{0.2}, .first = "lower", .second = "upper"}};
  const Motion motion = moved(scenario, direct.method);
  const Vec3 gained = motion[motion.size() - 1].bodies[1].velocity - Vec3{1, 0, 0};
  const double wanted = 0.2 * 10 * 0.05 / std::sqrt(2.0);  // mu g t, at 45 degrees; 1 % for the settling of the load
  CHECK_NEAR(gained[0], -wanted, 0.01 * wanted);
  CHECK_NEAR(gained[1], wanted, 0.01 * wanted);
}

// Chains as mechanisms ---------------------------------------------------------------------------------------------

/// The file that says of bodies that hang straight down what the chain's generator made of them.
std::string file_of_chain(const Mechanism& chain) {
  std::string text = "problem = \"mechanism\"\nduration = 0.003\n";
  const auto list = [](const Vec3& v) { return fmt::format("[{}, {}, {}]\n", v[0], v[1], v[2]); };
  for (const Body& body : chain.bodies) {
    text += fmt::format("[[bodies]]\nname = \"{}\"\nmass = {}\nsize = ", body.name, body.mass_kg) +
            list(sides_m(body.shape)) + "position = " + list(body.position_m) +
            "velocity = " + list(body.velocity_m_s) + "spin = " + list(body.spin_rad_s);
  }
  for (const Joint& joint : chain.joints) {
    const auto& hinge = std::get<HingeJoint>(joint.kind);
    text += fmt::format("[[joints]]\nkind = \"hinge\"\nparent = \"{}\"\nchild = \"{}\"\n",
                        joint.second ? chain.bodies[joint.first].name : "world", chain.bodies[joint.carried()].name) +
            "anchor = " + list(hinge.anchor_m) + "axis = " + list(hinge.axis);
  }
  return text;
}

/// Written as a mechanism, a chain of 128 links is what the chain's own file makes: to the last bit of every sample.
/// Its steps cost the same as well: 3254929057 instructions of the stepping beside 3254928817, counted by callgrind.
void a_chain_is_a_mechanism_as_well() {
  constexpr std::size_t links = 128;
  Scenario chain = test::report_scenario("chain", 0.003, step_s);
  std::vector<double> q0(links);
  std::vector<double> qd0(links);
  q0[0] = -std::numbers::pi / 2;
  qd0[0] = 1;
  qd0[links - 1] = -2;
  put_planar(chain, {chain.planar->frame, {links, chain.planar->links[0]}, q0, qd0, {}});
  Scenario mechanism = ScenarioFile("chain.toml", file_of_chain(chain.mechanism)).read({}, {});
  mechanism.ode = chain.ode;
  mechanism.gravity = chain.gravity;
  const Motion wanted = moved(chain, direct.method);
  const Motion motion = moved(mechanism, direct.method);
  CHECK_EQUAL(motion.size(), wanted.size());
  bool same = true;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    for (std::size_t i = 0; i < links; ++i) {
      const BodyState& a = motion[k].bodies[i];
      const BodyState& b = wanted[k].bodies[i];
      same = same && a.position == b.position && a.rotation == b.rotation && a.velocity == b.velocity &&
             a.spin == b.spin && motion[k].joints[i].force == wanted[k].joints[i].force;
    }
  }
  CHECK(same);
  CHECK(motion[3].bodies[links - 1].position != motion[0].bodies[links - 1].position);
}

}  // namespace

int main() {
  a_chain_is_a_mechanism_as_well();
  friction_acts_along_what_both_do();
  a_raised_plane_is_where_it_says();
  a_plane_counts_turns_on_every_side();
  for (const Stepper& stepper : steppers) {
    if (!test::in_this_build(stepper.method)) continue;
    std::printf("%s\n", stepper.method);
    a_strong_motor_has_its_speed_in_a_step(stepper);
    a_weak_motor_keeps_within_its_torque(stepper);
    a_motor_turns_the_first_against_the_second(stepper);
    a_stop_bounces(stepper);
    a_stop_holds(stepper);
    contacts_are_between_whom_they_name(stepper);
    a_ground_is_there_for_whom_it_is_named(stepper);
    joined_bodies_do_not_touch(stepper);
  }
  a_tensor_tumbles_as_the_turned_box();
  return test::verdict();
}
