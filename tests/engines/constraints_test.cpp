// What the engines beside ODE hold by constraints, where they can: contacts with restitution and friction, stops,
// loops. Each beside a closed form or the reference of trees, at one step and at a quarter of it.
//
//   constraints_test [METHOD...]   of those alone
#include <algorithm>
#include <string>
#include <vector>

#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/engines/beside_ode.hpp"
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
  double position;  // m, or of a link in a plane rad
  double force;     // N, of joints, at samples without contact
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
  return {metrics[error].value_or(NAN), metrics[quantity::max_reaction_error].value_or(0), run.outcome.impacts.size()};
}

struct Case {
  const char* name;
  Scenario scenario;
  double small;    // m or rad: below that an error is none that a quarter of the step would have to make less
  double at_most;  // of the error at a quarter of the step
};

constexpr double step_s = 1e-3;

/// A quarter of the step is a quarter of the error, where a contact begins anywhere in a step: 0.07 to 0.46 found.
void converges(const Case& what) {
  for (const catalogue::Method* const method : test::engines(asked)) {
    if (!catalogue::does(*method, what.scenario)) continue;
    const Errors coarse = errors_at(what.scenario, *method, step_s);
    const Errors fine = errors_at(what.scenario, *method, step_s / 4);
    std::printf("%s in %s: %.3g -> %.3g, %.3g -> %.3g N, %zu impacts\n", what.name, std::string(method->name).c_str(),
                coarse.position, fine.position, coarse.force, fine.force, fine.impacts);
    CHECK(fine.position < 0.6 * coarse.position || fine.position < what.small);
    CHECK_BETWEEN(fine.position, 0, what.at_most);
  }
}

/// A load on a rail that falls or turns onto the ends of its joint's way.
Scenario with_stop(JointKind kind, double restitution) {
  Scenario scenario;
  scenario.name = "stop";
  scenario.duration_s = 0.8;
  scenario.mechanism.bodies = {{.shape = Box{{0.2, 0.1, 0.1}}, .mass_kg = 2, .position_m = {0.4, 0, 0.1}}};
  scenario.mechanism.joints = {{.kind = kind, .first = 0, .second = {}, .stop = Stop{-0.7, 0.5, restitution}}};
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

Scenario without_erp(Scenario scenario) {
  scenario.bullet.erp = 0;
  return scenario;
}

Scenario shortened(Scenario scenario, double duration_s) {
  scenario.duration_s = duration_s;
  return scenario;
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
  // MuJoCo's springs give 0.135 of the speed back where nothing should bounce: 1.1 cm from 3.7 m/s.
  converges({"slider stops", with_stop(SliderJoint{{0, 0, 0}, {0, 0, 1}}, 0), 0.011, 0.011});
  converges({"slider bounces", with_stop(SliderJoint{{0, 0, 0}, {0, 0, 1}}, 0.5), 0, 0.02});
  // In Bullet's joint coordinates a stop lets go for a moment.
  converges({"hinge stops", with_stop(HingeJoint{{0, 0, 0}, {0, 1, 0}}, 0), 7e-3, 7e-3});
  converges({"hinge bounces", with_stop(HingeJoint{{0, 0, 0}, {0, 1, 0}}, 0.5), 0, 0.01});
  converges({"loop", four_bar(), 0, 5e-4});
#endif
  refusals();
  return test::verdict();
}
