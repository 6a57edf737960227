// Frames, signs and pairs that the other tests of engines leave out: where turned shapes touch planes, boxes and each
// other, a contact of its own for each pair, stops between bodies that fly, loops that close on the world, impacts as
// they are told. Each beside a closed form.
//
//   frames_test [METHOD...]   of those alone
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/check.hpp"
#include "tests/engines/beside_ode.hpp"
#include "tests/engines/random_trees.hpp"
#include "tests/recorded.hpp"

namespace {

using namespace odeval;

std::vector<std::string> asked;  // empty: all

constexpr double step_s = 1e-3;

bool is_soft(const catalogue::Method& method) { return method.name.starts_with("mujoco"); }
bool is_single(const catalogue::Method& method) { return method.name.ends_with("-single"); }

Scenario without_gravity(const char* name, double duration_s) {
  Scenario scenario;
  scenario.name = name;
  scenario.duration_s = duration_s;
  scenario.step_s = step_s;
  scenario.gravity = 0;
  scenario.mujoco.time_constant_s = 10 * step_s;
  return scenario;
}

Vec3 axis(const Body& body, std::size_t k) { return axis_of(rotation_of_vector(rotation_vector(body.attitude)), k); }

/// How far a body reaches along a direction from its centre, m.
double reach(const Body& body, const Vec3& along) {
  if (is_sphere(body.shape)) return sides_m(body.shape)[0] / 2;
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += sides_m(body.shape)[k] / 2 * std::fabs(dot(along, axis(body, k)));
  return sum;
}

// ---- Where things touch

/// A plane that something comes down on, and where.
struct Face {
  const char* name;
  Vec3 normal;
  Vec3 point;
};

constexpr double approach_m_s = 0.2;
constexpr double touches_s = 0.1503;

/// A body that comes straight down on a face, which it reaches at touches_s.
Scenario coming_down(Body body, const Face& face) {
  Scenario scenario = without_gravity(face.name, 0.3);
  body.name = "falls";
  body.position_m = face.point + (reach(body, face.normal) + approach_m_s * touches_s) * face.normal;
  body.velocity_m_s = -approach_m_s * face.normal;
  scenario.mechanism.bodies = {body};
  scenario.mechanism.contacts = {{.first = "falls", .second = "face"}};
  return scenario;
}

/// The engines look for contacts at the beginning of a step, MuJoCo's Runge-Kutta within it as well: the first is told
/// at the end of the step after that in which it touches, or of that one. A step is 0.2 mm.
void touches_then(const Scenario& scenario, const char* what) {
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    std::size_t first = 0;
    while (first < run.motion.size() && run.motion[first].contacts == 0) ++first;
    const double t = static_cast<double>(first) * step_s;
    std::printf("%s on %s in %s: %.4f s\n", what, scenario.name.c_str(), std::string(method->name).c_str(), t);
    CHECK_BETWEEN(t - touches_s, 0, 2 * step_s);
  }
}

/// Boxes whose principal axes are not their own, balls; on a tilted plane that the origin is off, on a box that stands,
/// on one that is turned and flies.
void touches() {
  test::Random draw(7);
  Body box{.shape = Box{{0.3, 0.2, 0.1}}, .mass_kg = 1, .attitude = Vec3{0.4, -0.7, 0.5}};
  Body odd = box;
  odd.inertia_kgm2 = test::any_tensor(draw, 1);
  const Body ball{.shape = Sphere{0.2}, .mass_kg = 1, .attitude = Vec3{0.4, -0.7, 0.5}};
  const Vec3 tilted = unit({0.3, -0.5, 0.8});
  const FixedBox standing{{0.5, -0.2, 0.3}, {0.4, 0.6, 0.2}};
  Body carrier{.shape = Box{{0.9, 0.8, 0.3}},
               .mass_kg = 50,
               .position_m = {-0.3, 0.2, 0.4},
               .attitude = Vec3{0.5, 0.3, -0.2},
               .name = "face"};
  carrier.inertia_kgm2 = test::any_tensor(draw, 50);
  const Face faces[] = {{"tilted plane", tilted, 0.7 * tilted + Vec3{0.5, 0.3, 0}},
                        {"standing box", {0, -1, 0}, standing.centre_m - Vec3{0, 0.3, 0}},
                        {"flying box", axis(carrier, 2), carrier.position_m + 0.15 * axis(carrier, 2)}};
  for (const auto& [body, what] : {std::pair{box, "box"}, std::pair{odd, "odd box"}, std::pair{ball, "ball"}}) {
    for (const Face& face : faces) {
      Scenario scenario = coming_down(body, face);
      Mechanism& mechanism = scenario.mechanism;
      if (&face == &faces[0]) {
        mechanism.obstacles = {{HalfSpace{face.normal, dot(face.normal, face.point)}, "face"}};
      } else if (&face == &faces[1]) {
        mechanism.obstacles = {{standing, "face"}};
      } else {
        mechanism.bodies.push_back(carrier);
      }
      touches_then(scenario, what);
    }
  }
}

// ---- Each pair its own contact

/// Balls that strike level ground at 1 m/s, of which each leaves it at its own restitution: MuJoCo, whose springs last
/// a few tens of steps, to 0.004.
void pairs_have_their_own_contacts() {
  constexpr double restitutions[] = {0.9, 0.3, 0.6};
  Scenario scenario = without_gravity("pairs", 0.4);
  scenario.bullet.erp = 0;  // a bounce takes the correction of the overlap with it
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  for (const double restitution : restitutions) {
    const std::size_t i = scenario.mechanism.bodies.size();
    const std::string name = "ball" + std::to_string(i);
    scenario.mechanism.bodies.push_back({.shape = Sphere{0.2},
                                         .mass_kg = 1,
                                         .position_m = {static_cast<double>(i), 0, 0.2 + 0.0003},
                                         .velocity_m_s = {0, 0, -1},
                                         .name = name});
    scenario.mechanism.contacts.push_back({.restitution = restitution, .first = "ground", .second = name});
  }
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    if (method->name == "dart-step") continue;  // which refuses pairs that differ
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    for (std::size_t i = 0; i < 3; ++i) {
      const double speed = run.motion[run.motion.size() - 1].bodies[i].velocity[2];
      std::printf("restitution %g in %s: %.4f\n", restitutions[i], std::string(method->name).c_str(), speed);
      CHECK_NEAR(speed, restitutions[i], is_soft(*method) ? 0.01 : 1e-6);
    }
  }
}

// ---- Impacts as they are told

/// A ball that strikes a tilted plane at 1 m/s, at some moment of a step: when, at what speeds and how deep. The depth
/// is that of the contact, or (`by_height`) that of the ball's centre. It is of a step that begins or ends in the
/// contact: no more than its way, 1 mm; of MuJoCo's springs less than T v, which an undamped one would have.
void impacts_are_told(double into_step, bool by_height) {
  constexpr double restitution = 0.9;
  const Vec3 tilted = unit({0.3, -0.5, 0.8});
  const double touch_s = (50 + into_step) * step_s;
  Scenario scenario = without_gravity("impact", 0.15);
  scenario.bullet.erp = 0;
  const Body ball{.shape = Sphere{0.2},
                  .mass_kg = 1,
                  .position_m = (0.7 + 0.1 + touch_s) * tilted + Vec3{0.5, 0.3, 0},
                  .velocity_m_s = -1.0 * tilted,
                  .name = "ball"};
  scenario.mechanism.bodies = {ball};
  const double touches_at = dot(tilted, ball.position_m) - touch_s;
  scenario.mechanism.obstacles = {{HalfSpace{tilted, touches_at - 0.1}, "wall"}};
  scenario.mechanism.contacts = {{.restitution = restitution}};
  scenario.impact_views = {{.normal = tilted}};
  if (by_height) scenario.impact_views.front().touches_at = touches_at;
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    const std::vector<Impact> impacts = test::recorded(method->make, scenario, sample_grid(scenario)).outcome.impacts;
    CHECK_EQUAL(impacts.size(), 1U);
    if (impacts.empty()) continue;
    const Impact& impact = impacts.front();
    std::printf("impact in %s: %.4f s, %.4f to %.4f m/s, %.3g m\n", std::string(method->name).c_str(), impact.t,
                impact.qd_before, impact.qd_after, impact.depth);
    CHECK_BETWEEN(impact.t - touch_s, -step_s, 1.01 * step_s);
    CHECK_NEAR(impact.q1, touches_at, is_soft(*method) ? 10 * step_s : 1.01 * step_s);
    CHECK_NEAR(impact.qd_before, -1, 1e-6);
    // DART takes back up to 1 mm/s of the overlap with it.
    CHECK_NEAR(impact.qd_after, restitution, is_soft(*method) ? 0.01 : 1.1e-3);
    CHECK_BETWEEN(impact.depth, is_soft(*method) ? 5 * step_s : 0, is_soft(*method) ? 10 * step_s : 1.01 * step_s);
  }
}

// ---- Stops between bodies that fly

/// Two bodies that fly without forces, one of which goes off from the other along or about their joint, until a stop
/// has them go on together.
Scenario going_off(JointKind kind, bool first_goes) {
  Scenario scenario = without_gravity("going_off", 0.5);
  const bool turns = std::holds_alternative<HingeJoint>(kind);
  const Vec3 along = turns ? std::get<HingeJoint>(kind).axis : std::get<SliderJoint>(kind).axis;
  Body stays{.shape = Box{{0.3, 0.2, 0.1}}, .mass_kg = 1, .attitude = Vec3{0.4, -0.7, 0.5}};
  // Moments that are the same about all axes, so that a spin goes on as it is.
  stays.inertia_kgm2 = std::array{0.02, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.02};
  Body goes = stays;
  goes.position_m = 0.6 * along;
  goes.attitude = Vec3{-0.2, 0.3, 0.9};
  (turns ? goes.spin_rad_s : goes.velocity_m_s) = along;
  scenario.mechanism.bodies = {stays, goes};
  const std::size_t first = first_goes ? 1 : 0;
  scenario.mechanism.joints = {{.kind = kind, .first = first, .second = 1 - first, .stop = Stop{-0.1, 0.3, 0}}};
  return scenario;
}

/// How far the second body has gone off from the first, rad or m.
double gone(const ConstSample& start, const ConstSample& now, const Vec3& along, bool turns) {
  const auto& [a, b] = std::pair{now.bodies[0], now.bodies[1]};
  if (!turns)
    return dot(along, b.position - a.position) - dot(along, start.bodies[1].position - start.bodies[0].position);
  const auto turn = [&](std::size_t i) { return now.bodies[i].rotation * transposed(start.bodies[i].rotation); };
  const Rotation r = turn(1) * transposed(turn(0));
  return std::atan2(dot(along, Vec3{r[7] - r[5], r[2] - r[6], r[3] - r[1]}) / 2, (r[0] + r[4] + r[8] - 1) / 2);
}

/// The joint counts its first body against its second: the first goes off to the upper end, the second to the lower. A
/// step may go as far as its own length beyond a stop; MuJoCo's, a spring and damper of the time constant T, T / e.
void stops_in_flight(JointKind kind) {
  const bool turns = std::holds_alternative<HingeJoint>(kind);
  const Vec3 along = turns ? std::get<HingeJoint>(kind).axis : std::get<SliderJoint>(kind).axis;
  for (const bool first_goes : {true, false}) {
    Scenario scenario = going_off(kind, first_goes);
    const double end = first_goes ? 0.3 : 0.1;
    for (const catalogue::Method* const method : test::engines(asked)) {
      if (!catalogue::does(*method, scenario)) continue;
      const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
      double most = 0;
      for (std::size_t k = 0; k < run.motion.size(); ++k) {
        most = std::fmax(most, gone(run.motion[0], run.motion[k], along, turns));
      }
      std::printf("%s of %s in %s: %.4f\n", turns ? "hinge" : "slider", first_goes ? "the first" : "the second",
                  std::string(method->name).c_str(), most);
      CHECK_EQUAL(run.motion.size(), 501U);
      CHECK_BETWEEN(most - end, -1e-6, 1.01 * step_s + (is_soft(*method) ? 10 * step_s / std::exp(1) : 0));
      const auto last = run.motion[run.motion.size() - 1];
      const Vec3 all =
          turns ? last.bodies[0].spin + last.bodies[1].spin : last.bodies[0].velocity + last.bodies[1].velocity;
      CHECK_NEAR(length(all - along), 0, is_single(*method) ? 1e-4 : 1e-9);
    }
  }
}

// ---- Loops that close on the world

/// A body that turns about the line between two joints on the world, of which the second closes a loop: on a circle, at
/// the same speed. Both joints pull alike across the line.
void on_two_joints(const char* name, bool hinge) {
  constexpr double rate = 2;      // rad/s
  constexpr double radius = 0.3;  // m
  Scenario scenario = without_gravity(name, 0.5);
  scenario.rtol = 1e-6;
  scenario.bullet.iterations = 200;
  const Vec3 line = unit({0.2, 0.9, 0.4});
  const Vec3 out = unit(cross(line, {0, 0, 1}));
  const Vec3 middle{0.3, -0.2, 0.5};
  Body body{.shape = Box{{0.3, 0.2, 0.1}},
            .mass_kg = 2,
            .position_m = middle + radius * out,
            .attitude = Vec3{0.4, -0.7, 0.5},
            .velocity_m_s = (rate * radius) * cross(line, out),
            .spin_rad_s = rate * line,
            .inertia_kgm2 = std::array{0.02, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.02}};
  scenario.mechanism.bodies = {body};
  const Vec3 ends[] = {middle - 0.25 * line, middle + 0.25 * line};
  scenario.mechanism.joints = {{.kind = BallJoint{ends[0]}, .first = 0, .second = {}},
                               {.kind = BallJoint{ends[1]}, .first = 0, .second = {}}};
  if (hinge) scenario.mechanism.joints[1].kind = HingeJoint{ends[1], line};
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, scenario)) continue;
    const test::Recorded run = test::recorded(method->make, scenario, sample_grid(scenario));
    CHECK_EQUAL(run.motion.size(), 501U);
    double off = 0;
    double pull = 0;
    for (std::size_t k = 0; k < run.motion.size(); ++k) {
      const double t = static_cast<double>(k) * step_s;
      const Vec3 now = turned(rotation_about(line, rate * t), out);
      off = std::fmax(off, distance(run.motion[k].bodies[0].position, middle + radius * now));
      // What is soft has other forces until it has settled.
      if (t > 0.2) pull = std::fmax(pull, std::fabs(dot(now, run.motion[k].joints[1].force) + rate * rate * radius));
    }
    std::printf("%s in %s: %.3g m, %.3g N of %.3g\n", name, std::string(method->name).c_str(), off, pull,
                rate * rate * radius);
    // 6e-6 m found, of ERP and of springs; forces of single precision as constraints_test has them.
    CHECK_BETWEEN(off, 0, 2e-5);
    if (!hinge) CHECK_BETWEEN(pull, 0, is_single(*method) ? 0.2 : 1e-4);
  }
}

}  // namespace

int main(int argc, char** argv) {
  asked.assign(argv + 1, argv + argc);
  if (test::engines(asked).empty()) {
    std::puts("frames_test: skipped, this build has none of the engines beside ODE");
    return 77;
  }
  touches();
  pairs_have_their_own_contacts();
  for (const double into_step : {0.1, 0.5, 0.9}) {
    for (const bool by_height : {false, true}) impacts_are_told(into_step, by_height);
  }
  const Vec3 along = unit({0.6, -0.3, 0.5});
  stops_in_flight(SliderJoint{{0, 0, 0}, along});
  stops_in_flight(HingeJoint{{0, 0, 0}, along});
  on_two_joints("two balls", false);
  on_two_joints("ball and hinge", true);
  return test::verdict();
}
