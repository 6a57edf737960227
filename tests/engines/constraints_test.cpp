// What the engines beside ODE hold by constraints, where they can: contacts with restitution and friction, stops,
// loops. Each beside a closed form or the reference of trees, at one step and at a quarter of it.
//
//   constraints_test [METHOD...]   of those alone
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/engines/beside_ode.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

std::vector<std::string> asked;  // empty: all

Scenario shipped(const std::string& name) {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names);
}

/// Rows that all steps share.
constexpr double spacing_s = 0.02;

struct Errors {
  double position;              // m, or of a link in a plane rad
  std::optional<double> force;  // N, of joints, at samples without contact, where the reference knows it
  std::size_t impacts;
};

/// Softness goes with the step where an engine has it: only so does the motion come to that of rigid bodies.
Errors errors_at(Scenario scenario, const catalogue::Method& method, double h) {
  scenario.step_s = h;
  scenario.sample_s = spacing_s;
  scenario.rtol = h * h;
  scenario.mujoco.time_constant_s = 10 * h;
  scenario.bullet.iterations = 200;
  catalogue::Evaluator evaluator(scenario);
  const catalogue::Evaluation run = evaluator.evaluate(method);
  CHECK(!run.outcome.diverged);
  const Metrics metrics = evaluator.measure(run, scenario.duration_s);
  const quantity::Id error = scenario.planar ? quantity::max_error_q : quantity::max_error_position;
  return {metrics[error].value_or(NAN), metrics[quantity::max_reaction_error], run.outcome.impacts.size()};
}

struct Case {
  const char* name;
  Scenario scenario;
  double small;        // m or rad: below that an error is none that a quarter of the step would have to make less
  double at_most;      // of the error at a quarter of the step
  double force = 0;    // N, likewise of forces of joints; 0: not looked at, since what is soft has others for a while
  bool rigid = false;  // not for an engine whose stops are springs
};

constexpr double step_s = 1e-3;

bool is_soft(const catalogue::Method& method) { return method.name.starts_with("mujoco"); }

/// A sample shows the mean of its last step, half a step old: first order, 0.12 to 0.27 of the error at a quarter of
/// the step. Below is rounding: a place of 1 m that is off by half a digit is taken back by ERP within a step, a force
/// of ERP m / h² times that, in single precision 0.2 N a row of a joint.
void check_forces(const catalogue::Method& method, const Errors& coarse, const Errors& fine, double at_most) {
  const double rounding = method.name.ends_with("-single") ? 1 : 1e-8;
  CHECK(fine.force.value() < 0.35 * coarse.force.value() || fine.force.value() < rounding);
  CHECK_BETWEEN(fine.force.value(), 0, std::max(at_most, rounding));
}

/// A quarter of the step is a quarter of the error, where a contact begins anywhere in a step: 0.07 to 0.46 found.
void converges(const Case& what) {
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, what.scenario) || (what.rigid && is_soft(*method))) continue;
    const Errors coarse = errors_at(what.scenario, *method, step_s);
    const Errors fine = errors_at(what.scenario, *method, step_s / 4);
    std::printf("%s in %s: %.3g -> %.3g, %.3g -> %.3g N, %zu impacts\n", what.name, std::string(method->name).c_str(),
                coarse.position, fine.position, coarse.force.value_or(NAN), fine.force.value_or(NAN), fine.impacts);
    CHECK(fine.position < 0.6 * coarse.position || fine.position < what.small);
    CHECK_BETWEEN(fine.position, 0, what.at_most);
    if (what.force > 0) check_forces(*method, coarse, fine, what.force);
  }
}

/// A load on a joint at the origin that is thrown up to one end of the joint's way and falls or turns to the other.
Scenario with_stop(JointKind kind, double restitution) {
  Scenario scenario;
  scenario.name = "stop";
  scenario.duration_s = 0.8;
  Body body{.shape = Box{{0.2, 0.1, 0.1}}, .mass_kg = 2, .position_m = {0.4, 0, 0.1}, .velocity_m_s = {0, 0, 3.2}};
  if (std::holds_alternative<HingeJoint>(kind)) {
    body.spin_rad_s = {0, -5, 0};
    body.velocity_m_s = cross(body.spin_rad_s, body.position_m);
  }
  scenario.mechanism.bodies = {body};
  scenario.mechanism.joints = {{.kind = kind, .first = 0, .second = {}, .stop = Stop{-0.3, 0.4, restitution}}};
  return scenario;
}

/// Three bars and four hinges, unequal, that fall from rest.
Scenario four_bar() {
  Scenario scenario;
  scenario.name = "four_bar";
  scenario.duration_s = 0.6;
  const Vec3 y{0, 1, 0};
  const auto bar = [](Vec3 from, Vec3 to) {
    const Vec3 along = to - from;
    return Body{.shape = Box{{length(along), 0.05, 0.05}},
                .mass_kg = 1,
                .position_m = 0.5 * (from + to),
                .attitude = Vec3{0, -std::atan2(along[2], along[0]), 0}};
  };
  const Vec3 a{0, 0, 0};
  const Vec3 b{0.2, 0, 0.5};
  const Vec3 c{0.9, 0, 0.7};
  const Vec3 d{1, 0, 0};
  scenario.mechanism.bodies = {bar(a, b), bar(b, c), bar(c, d)};
  scenario.mechanism.joints = {{.kind = HingeJoint{a, y}, .first = 0, .second = {}},
                               {.kind = HingeJoint{b, y}, .first = 1, .second = 0},
                               {.kind = HingeJoint{c, y}, .first = 2, .second = 1},
                               {.kind = HingeJoint{d, y}, .first = 2, .second = {}}};
  return scenario;
}

#ifdef ODEVAL_WITH_TREES

/// Bars that no plane holds, so that the loop leaves no force undecided: two hinges, a universal joint and a ball
/// joint, which closes it and whose force tables show beside the middle bar.
Scenario spatial_loop() {
  Scenario scenario = four_bar();
  scenario.name = "spatial_loop";
  scenario.duration_s = 0.4;
  Mechanism& mechanism = scenario.mechanism;
  const std::vector<Joint> hinges = mechanism.joints;
  const auto at = [](const Joint& joint) { return std::get<HingeJoint>(joint.kind).anchor_m; };
  const Vec3 tilted{0.28, 0.96, 0};
  mechanism.joints = {{.kind = HingeJoint{at(hinges[0]), tilted}, .first = 0, .second = {}},
                      {.kind = UniversalJoint{at(hinges[1]), {0, 1, 0}, {0, 0, 1}}, .first = 1, .second = 0},
                      {.kind = BallJoint{at(hinges[2])}, .first = 2, .second = 1},
                      hinges[3]};
  return scenario;
}

/// The same with its middle bar in two halves, which the joint that closes the loop welds together.
Scenario welded_loop() {
  Scenario scenario = spatial_loop();
  scenario.name = "welded_loop";
  Mechanism& mechanism = scenario.mechanism;
  const Body whole = mechanism.bodies[1];
  Body half = whole;
  half.mass_kg = whole.mass_kg / 2;
  std::get<Box>(half.shape).sides_m[0] /= 2;
  const auto at = [](const Joint& joint) { return anchor_m(joint.kind); };
  mechanism.bodies[1] = half;
  mechanism.bodies[1].position_m = 0.5 * (at(mechanism.joints[1]) + whole.position_m);
  mechanism.bodies.push_back(half);
  mechanism.bodies[3].position_m = 0.5 * (at(mechanism.joints[2]) + whole.position_m);
  mechanism.joints[2].second = 3;
  mechanism.joints.push_back({.kind = FixedJoint{whole.position_m}, .first = 1, .second = 3});
  return scenario;
}

/// One that a hinge closes: the loop leaves no force undecided, and one motion.
Scenario hinged_loop() {
  Scenario scenario = four_bar();
  scenario.name = "hinged_loop";
  scenario.duration_s = 0.4;
  std::vector<Joint>& joints = scenario.mechanism.joints;
  joints[1].kind = BallJoint{anchor_m(joints[1].kind)};
  joints[3].kind = UniversalJoint{anchor_m(joints[3].kind), {0, 1, 0}, {0, 0, 1}};
  return scenario;
}

#endif

Scenario without_erp(Scenario scenario) {
  scenario.bullet.erp = 0;
  return scenario;
}

Scenario shortened(Scenario scenario, double duration_s) {
  scenario.duration_s = duration_s;
  return scenario;
}

/// Below a stop of MuJoCo's at 0, struck at 1 m/s at t = 0: a spring and damper of the time constant T, by half of
/// critical damping for the restitution e^(-2 pi / sqrt 27), at critical damping for none; they let go when they would
/// pull. {way, m; speed, m/s}.
std::array<double, 2> on_soft_stop(double restitution, double T, double t) {
  const bool bounces = restitution > 0;
  const double swing = std::sqrt(0.75) / T;
  const double let_go = bounces ? 2 * std::numbers::pi / 3 / swing : 2 * T;
  const double s = std::fmin(t, let_go);
  const double way = bounces ? -std::exp(-s / (2 * T)) * std::sin(swing * s) / swing : -s * std::exp(-s / T);
  const double speed =
      bounces ? -std::exp(-s / (2 * T)) * std::cos(swing * s) - way / (2 * T) : -std::exp(-s / T) * (1 - s / T);
  return {way + (t - s) * speed, speed};
}

/// A first-order step and the beginning of the contact within one leave a step's way, 2 h v, and of the speed 2 h / T.
/// Where nothing bounces MuJoCo's impedance rises from 0.9 to 0.95 within the first millimetre w: there and back the
/// damper 2 / T lacks 5 %, 2 (w / T) 5 % of the speed; the way by that times T.
void soft_stop(double restitution) {
  constexpr double T = 0.05;
  Scenario scenario = with_stop(SliderJoint{{0, 0, 0}, {0, 0, 1}}, restitution);
  scenario.gravity = 0;
  scenario.mechanism.bodies.front().velocity_m_s = {0, 0, -1};
  scenario.mechanism.joints.front().stop->low = 0;
  scenario.mujoco.time_constant_s = T;
  scenario.step_s = 1e-4;
  const SampleGrid grid{scenario.step_s, 10, 301};
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!is_soft(*method)) continue;
    const test::Recorded run = test::recorded(method->make, scenario, grid);
    const double start = scenario.mechanism.bodies.front().position_m[2];
    std::array<double, 2> most{};
    for (std::size_t k = 0; k < run.motion.size(); ++k) {
      const auto [way, speed] = on_soft_stop(restitution, T, grid.time(static_cast<long>(k)));
      const BodyState& body = run.motion[k].bodies[0];
      most = {std::fmax(most[0], std::fabs(body.position[2] - start - way)),
              std::fmax(most[1], std::fabs(body.velocity[2] - speed))};
    }
    std::printf("soft stop, restitution %.3g, in %s: %.3g m, %.3g m/s\n", restitution,
                std::string(method->name).c_str(), most[0], most[1]);
    CHECK_EQUAL(run.motion.size(), 301U);
    // Stiffness 1 / T², damping twice the ratio over T: critical, or half of it. What bounces has one impedance.
    const Told told = method->make(scenario, grid)->told();
    const auto tells = [&](const char* option, std::string_view value) {
      const std::pair<std::string, std::variant<double, std::int64_t, std::string>> row{option, std::string(value)};
      return std::ranges::find(told, row) != told.end();
    };
    CHECK(tells("stop_b0d0_solimp", restitution > 0 ? "0.95 0.95 0.001 0.5 2" : "0.9 0.95 0.001 0.5 2"));
    CHECK(restitution > 0 || tells("stop_b0d0_solref", "-400 -40"));
    const double softer = restitution > 0 ? 0 : 0.1 * 1e-3 / T;
    CHECK_BETWEEN(most[0], 0, 2 * scenario.step_s + softer * T);
    CHECK_BETWEEN(most[1], 0, 2 * scenario.step_s / T + softer);
  }
}

/// A ball on an arm that goes round on a rough ground. What the arm's joint gives is told, what the ground gives is
/// what is left of the momentum: the two about the centre have to turn the ball as it turns.
void forces_beside_contacts() {
  constexpr double radius = 0.1;
  const Vec3 anchor{0, 0, 0};
  Scenario scenario;
  scenario.name = "round";
  scenario.duration_s = 0.4;
  scenario.step_s = step_s / 4;
  scenario.mechanism.bodies = {{.shape = Sphere{2 * radius},
                                .mass_kg = 1,
                                .position_m = {0.5, 0, -0.2},
                                .velocity_m_s = {0, 1, 0},
                                .spin_rad_s = {0, 0, 2},
                                .name = "ball"}};
  scenario.mechanism.joints = {{.kind = BallJoint{anchor}, .first = 0, .second = {}}};
  scenario.mechanism.obstacles = {{HalfSpace{{0, 0, 1}, -0.3}, "ground"}};
  scenario.mechanism.contacts = {{.friction = Friction{0.3}, .first = "ball", .second = "ground"}};
  const double moment = scenario.mechanism.bodies[0].uniform_moments_kgm2()[0];
  const double h = scenario.step_s;
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    double most = 0;
    double pressed = 0;
    int touching = 0;
    for (std::size_t k = 400; k < run.motion.size(); ++k) {  // the first 0.1 s a soft ground swings
      const auto before = run.motion[k - 1].bodies[0];
      const auto after = run.motion[k].bodies[0];
      const Vec3 centre = 0.5 * (before.position + after.position);
      const Vec3 arm = run.motion[k].joints[0].force;
      const Vec3 ground = (1 / h) * (after.velocity - before.velocity) + Vec3{0, 0, scenario.gravity} - arm;
      const Vec3 turning = (moment / h) * (after.spin - before.spin);
      const Vec3 left = turning - cross(anchor - centre, arm) - cross(Vec3{0, 0, -radius}, ground);
      most = std::fmax(most, length(left));
      pressed = std::fmax(pressed, ground[2]);
      if (run.motion[k].contacts > 0) ++touching;
    }
    std::printf("on rough ground in %s: %.3g N m, %.3g N, %d steps\n", std::string(method->name).c_str(), most, pressed,
                touching);
    CHECK_EQUAL(run.motion.size(), 1601U);
    CHECK(touching > 600);
    // Of first order in the step, the most of mujoco-rk4, whose forces are those of its last stage: 0.022 found.
    // Without the friction it is 1.5.
    CHECK_BETWEEN(most, 0, 0.05);
  }
}

/// Whoever is pushed off the ground within a step is told to have touched it in that step.
void pushes_are_contacts(const std::string& name) {
  Scenario scenario = shortened(shipped(name), 1);
  scenario.step_s = step_s;
  scenario.sample_s = step_s;
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    CHECK_EQUAL(run.motion.size(), 1001U);
    // A speed of some m/s, rounded.
    const double rounding = method->name.ends_with("-single") ? 1e-5 : 1e-12;
    int pushed = 0;
    int untold = 0;
    for (std::size_t k = 1; k < run.motion.size(); ++k) {
      const double gained = run.motion[k].bodies[0].velocity[2] - run.motion[k - 1].bodies[0].velocity[2];
      if (std::fabs(gained + scenario.gravity * step_s) < rounding) continue;
      ++pushed;
      if (run.motion[k].contacts == 0) ++untold;
    }
    std::printf("%s in %s: pushed in %d steps, %d of them without a contact\n", name.c_str(),
                std::string(method->name).c_str(), pushed, untold);
    CHECK(pushed > 0);
    CHECK_EQUAL(untold, 0);
  }
}

/// Two balls that hang from one point and lean on each other while they swing. What one gives the other goes through
/// its centre: the arm's force alone turns the ball.
void forces_between_bodies() {
  Scenario scenario;
  scenario.name = "leaning";
  scenario.duration_s = 0.4;
  scenario.step_s = step_s / 4;
  const Vec3 spin{2, 0, 0};
  for (const double side : {-1.0, 1.0}) {
    const Vec3 place{0.1 * side, 0, -0.5};
    const std::string name = side < 0 ? "left" : "right";
    scenario.mechanism.bodies.push_back({.shape = Sphere{0.2},
                                         .mass_kg = 1,
                                         .position_m = place,
                                         .velocity_m_s = cross(spin, place),
                                         .spin_rad_s = spin,
                                         .name = name});
    const std::size_t number = scenario.mechanism.bodies.size() - 1;
    scenario.mechanism.joints.push_back({.kind = BallJoint{}, .first = number, .second = {}});
  }
  scenario.mechanism.contacts = {{.first = "left", .second = "right"}};
  const double moment = scenario.mechanism.bodies[0].uniform_moments_kgm2()[0];
  const double h = scenario.step_s;
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    CHECK_EQUAL(run.motion.size(), 1601U);
    for (std::size_t i = 0; i < 2; ++i) {
      double most = 0;
      double pressed = 0;
      for (std::size_t k = 400; k < run.motion.size(); ++k) {  // the first 0.1 s a soft contact swings
        const auto before = run.motion[k - 1].bodies[i];
        const auto after = run.motion[k].bodies[i];
        const Vec3 centre = 0.5 * (before.position + after.position);
        const Vec3 arm = run.motion[k].joints[i].force;
        const Vec3 other = (1 / h) * (after.velocity - before.velocity) + Vec3{0, 0, scenario.gravity} - arm;
        most = std::fmax(most, length((moment / h) * (after.spin - before.spin) + cross(centre, arm)));
        pressed = std::fmax(pressed, (i == 0 ? -1 : 1) * other[0]);
      }
      std::printf("leaning in %s: %.3g N m, %.3g N\n", std::string(method->name).c_str(), most, pressed);
      // Of first order in the step. At rest 9.81 N / 5 press, whose arm is 0.5 m: left out of the sum they are 1 N m.
      CHECK_BETWEEN(most, 0, 0.05);
      CHECK(pressed > 1.9);
    }
  }
}

/// A ball that rolls on level ground, askew to the axes and spinning about the vertical, goes on as it began: friction
/// of a coefficient takes nothing from it. One that slides there loses mu g of its speed along the slide, until it
/// rolls: of 3 m/s for 0.29 s.
void on_level_ground(double slip) {
  constexpr double radius = 0.1;
  constexpr double mu = 0.3;
  Scenario scenario;
  scenario.name = "level";
  scenario.duration_s = 0.2;
  scenario.step_s = step_s / 4;
  scenario.mujoco.elliptic = true;  // a pyramid has more along its edges
  const Vec3 along{0.6, 0.8, 0};
  const double rolling = 2;
  scenario.mechanism.bodies = {{.shape = Sphere{2 * radius},
                                .mass_kg = 1,
                                .position_m = {0, 0, radius},
                                .velocity_m_s = (rolling + slip) * along,
                                .spin_rad_s = (rolling / radius) * cross(Vec3{0, 0, 1}, along) + Vec3{0, 0, 3},
                                .name = "ball"}};
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  scenario.mechanism.contacts = {{.friction = Friction{mu}, .first = "ball", .second = "ground"}};
  const double t = scenario.duration_s;
  const Vec3 wanted = (rolling + slip - (slip > 0 ? mu * scenario.gravity * t : 0)) * along;
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    if (slip > 0 && method->name == "dart-step") continue;  // its pyramid has no setting; the slide is along its axis
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    const auto end = run.motion[run.motion.size() - 1].bodies[0];
    Vec3 off = end.velocity - wanted;
    off[2] = 0;
    std::printf("on level ground, slip %g, in %s: %.3g m/s, %.3g rad/s\n", slip, std::string(method->name).c_str(),
                length(off), std::fabs(end.spin[2] - 3));
    CHECK_BETWEEN(length(off), 0, 0.02);
    CHECK_BETWEEN(std::fabs(end.spin[2] - 3), 0, 0.02);
  }
}

/// Without forces what moves goes on, however slow and for however long, and however fast: nothing sleeps, no speed has
/// a limit. 3 s of steps of 10 ms; a slider and a free body.
void goes_on(double speed_m_s) {
  Scenario scenario;
  scenario.name = "goes_on";
  scenario.duration_s = 3;
  scenario.step_s = 1e-2;
  scenario.gravity = 0;
  const Body body{.shape = Box{{0.1, 0.2, 0.3}}, .mass_kg = 1, .velocity_m_s = {0, speed_m_s, 0}};
  scenario.mechanism.bodies = {body, body};
  scenario.mechanism.joints = {{.kind = SliderJoint{{}, {0, 1, 0}}, .first = 0, .second = {}}};
  for (const catalogue::Method* const method : test::engines(asked)) {
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    const double rounding =
        method->name.ends_with("-single") ? 1e-4 : 1e-9;  // 300 roundings of a sum, each half a digit
    for (const auto& state : run.motion[run.motion.size() - 1].bodies) {
      CHECK_NEAR(state.position[1] / (speed_m_s * scenario.duration_s), 1, rounding);
    }
  }
}

/// What each can, and in one line what it can not.
void refusals() {
  struct Row {
    std::string_view engine;  // what its methods begin with
    std::string_view can;
  };
  constexpr Row rows[] = {
      {"mujoco", "bouncing_ball friction_slide wall_pendulum cradle loop bounce"},
      {"bullet-hinge", "bouncing_ball friction_slide wall_pendulum cradle loop motor"},
      {"bullet-multibody-rk4", ""},
      {"bullet-multibody", "bouncing_ball friction_slide wall_pendulum cradle motor"},
      {"dart", "bouncing_ball friction_slide wall_pendulum cradle motor"},
      {"simbody", "loop"},
  };
  const std::pair<const char*, Scenario> asked_of[] = {{"bouncing_ball", shipped("bouncing_ball")},
                                                       {"friction_slide", shipped("friction_slide")},
                                                       {"wall_pendulum", shipped("wall_pendulum")},
                                                       {"cradle", shipped("newtons_cradle")},
                                                       {"loop", four_bar()},
                                                       {"bounce", with_stop(SliderJoint{{}, {0, 0, 1}}, 0.5)},
                                                       {"motor", shipped("motor_lift")}};
  for (const catalogue::Method* const method : test::engines(asked)) {
    const auto row = std::ranges::find_if(rows, [&](const Row& one) { return method->name.starts_with(one.engine); });
    for (const auto& [word, scenario] : asked_of) {
      const bool wanted = row->can.find(word) != std::string_view::npos;
      test::report(catalogue::does(*method, scenario) == wanted, __FILE__, __LINE__,
                   std::string(method->name) + ": " + word);
      if (!wanted) CHECK_THROWS(catalogue::require_does(*method, scenario, "--method"), UserError, ", which has ");
    }
    if (!method->name.starts_with("dart")) continue;
    Scenario unlike = shipped("newtons_cradle");
    unlike.mechanism.contacts.push_back({.restitution = 0.5});
    CHECK_THROWS(method->make(unlike, sample_grid(unlike)), UserError, "newtons_cradle.toml: contacts.1: restitution");
  }
}

}  // namespace

int main(int argc, char** argv) {
  asked.assign(argv + 1, argv + argc);
  if (test::engines(asked).empty()) {
    std::puts("constraints_test: skipped, this build has none of the engines beside ODE");
    return 77;
  }
  // Bullet's bounce takes the correction of the overlap with it, at any step; without that correction it is a bounce.
  converges({"ball", without_erp(shortened(shipped("bouncing_ball"), 1.5)), 0, 0.05});
  converges({"wall", without_erp(shortened(shipped("wall_pendulum"), 2)), 5e-3, 0.15});
  // 1 % of friction is 6.8 mm.
  converges({"slide", shipped("friction_slide"), 1.1e-3, 2.5e-3});
#ifdef ODEVAL_WITH_TREES
  // Four impacts one after the other, links of one multibody in Bullet's joint coordinates, each late by up to a step:
  // 4 x 0.25 ms at 1.24 m/s. Springs would overlap, since a gap of 2 mm takes a ball 1.6 ms.
  converges({"cradle", without_erp(shortened(shipped("newtons_cradle"), 1)), 1.25e-3, 1.25e-3, 0, true});
  const SliderJoint slider{{0, 0, 0}, {0, 0, 1}};
  const HingeJoint hinge{{0, 0, 0}, {0, 1, 0}};
  // At 1.5 and then 3.7 m/s, -3.5 and then 5.3 rad/s, a step goes as far as that beyond a stop, and what is late at the
  // first stays so until the second. Without ERP, which throws back from there.
  converges({"slider stops", without_erp(with_stop(slider, 0)), 0, 2e-3, 1e-3, true});
  converges({"hinge stops", without_erp(with_stop(hinge, 0)), 0, 2e-3, 0.4, true});
  converges({"slider bounces", with_stop(slider, 0.5), 0, 0.04});
  converges({"hinge bounces", with_stop(hinge, 0.5), 0, 0.03});
  converges({"loop", four_bar(), 0, 5e-4});
  converges({"spatial loop", spatial_loop(), 0, 5e-4, 0.1});
  converges({"welded loop", welded_loop(), 0, 5e-4, 0.1});
  converges({"hinged loop", hinged_loop(), 0, 5e-4, 0.1});
#endif
  soft_stop(std::exp(-2 * std::numbers::pi / std::sqrt(27.0)));
  soft_stop(0);
  pushes_are_contacts("bouncing_ball");
  pushes_are_contacts("friction_slide");
  forces_beside_contacts();
  forces_between_bodies();
  on_level_ground(0);
  on_level_ground(3);
  goes_on(1e-2);
  goes_on(1e3);
  refusals();
  return test::verdict();
}
