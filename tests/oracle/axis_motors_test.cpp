// Motors of joints with several motions, in closed form: beside the reference, which has to agree to 1e-9, ODE, which
// has to come nearer by the step, and the accurate step.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "catalogue/methods.hpp"
#include "model/read_scenario.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

// A cube about its centre, which the anchor is in: nothing that moves it one way loads another one. So each motor gives
// what it has until its speed is there, and from then on nothing.
constexpr double mass = 2;                  // kg
constexpr double moment = mass * 0.09 / 6;  // kg m²: sides of 0.3 m
constexpr Vec3 anchor{0.2, -0.1, 0.5};
constexpr double duration_s = 1;

const Vec3 along = unit(Vec3{1, 2, -2});
const Vec3 across = unit(Vec3{2, 1, 2});
const Vec3 third{1, 0, 0};

struct Drive {
  double speed;
  double most;

  /// Of the cube against what carries it.
  double q(double inertia, double t) const {
    const double pull = std::copysign(most, speed) / inertia;
    const double reached_s = speed / pull;
    return t < reached_s ? pull * t * t / 2 : speed * (t - reached_s / 2);
  }
};
constexpr std::array drives{Drive{0.7, 2.5}, Drive{-3, 0.2}, Drive{2, 0.1}};  // from 0.6 s on at their speed, or sooner

/// What a kind leaves: a way, and turns about one axis that the parent carries, and then one that the child does. By
/// the numbers of the motors that drive them.
struct Motions {
  std::optional<std::size_t> way = {};
  Vec3 way_axis = along;
  std::optional<std::size_t> turn = {};
  Vec3 turn_axis = along;
  std::optional<std::size_t> own_turn = {};
  Vec3 own_axis = across;
};

struct Case {
  const char* kind;
  const char* parent;
  std::string axes;
  Motions motions;
  bool ode_errs = false;  // at every step
};

std::string shown(const Vec3& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

Scenario scenario_of(const Case& what) {
  std::string text = fmt::format("problem = \"mechanism\"\nduration = {}\ngravity = 0\n", duration_s);
  text +=
      "[[bodies]]\nname = \"base\"\nmass = 1\nsize = [1, 1, 1]\nposition = [0, 0, -1]\n"
      "[[joints]]\nkind = \"fixed\"\nparent = \"world\"\nchild = \"base\"\nanchor = [0, 0, -1]\n";
  text += fmt::format("[[bodies]]\nname = \"cube\"\nmass = {}\nsize = [0.3, 0.3, 0.3]\nposition = {}\n", mass,
                      shown(anchor));
  text += fmt::format("[[joints]]\nname = \"it\"\nkind = \"{}\"\nparent = \"{}\"\nchild = \"cube\"\nanchor = {}\n{}",
                      what.kind, what.parent, shown(anchor), what.axes);
  for (const auto& number : {what.motions.way, what.motions.turn, what.motions.own_turn}) {
    if (!number) continue;
    text +=
        fmt::format("[joints.motor{}]\nvelocity = {}\nforce = {}\n", *number == 0 ? "" : fmt::format("{}", *number + 1),
                    drives[*number].speed, drives[*number].most);
  }
  Scenario scenario = ScenarioFile("x.toml", text).read({}, {});
  scenario.ode.cfm = 0;
  return scenario;
}

Frame truth(const Motions& motions, double t) {
  Frame frame{anchor};
  if (motions.way) frame.position_m = anchor + drives[*motions.way].q(mass, t) * motions.way_axis;
  if (motions.turn) frame.rotation = rotation_about(motions.turn_axis, drives[*motions.turn].q(moment, t));
  if (motions.own_turn)
    frame.rotation = frame.rotation * rotation_about(motions.own_axis, drives[*motions.own_turn].q(moment, t));
  return frame;
}

double apart(const Frame& a, const Vec3& position, const Rotation& rotation) {
  double most = distance(a.position_m, position);
  for (std::size_t k = 0; k < 9; ++k) most = std::fmax(most, std::fabs(a.rotation[k] - rotation[k]));
  return most;
}

double most(const Column& column) {
  double largest = column.empty() ? INFINITY : 0;
  for (const double value : column) largest = std::fmax(largest, std::fabs(value));
  return largest;
}

template <std::size_t N>
std::array<double, N> row(const std::array<Column, N>& columns, std::size_t k) {
  std::array<double, N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = columns[i][k];
  return values;
}

struct Run {
  double off = 0;
  double unaccounted = 0;
  std::size_t motors = 0;
};
Run run(const char* method, const Case& what, Scenario scenario, double h) {
  scenario.step_s = h;
  catalogue::Evaluator evaluator(scenario);
  const catalogue::Evaluation found = evaluator.evaluate(catalogue::find_method(method));
  CHECK(!found.outcome.diverged);
  const BodyColumns& cube = found.trace.bodies[1];
  Run run{0, most(found.trace.unaccounted), found.outcome.motors.size()};
  for (std::size_t k = 0; k < found.trace.rows(); ++k) {
    run.off =
        std::fmax(run.off, apart(truth(what.motions, found.trace.t[k]), row(cube.position, k), row(cube.rotation, k)));
  }
  return run;
}

void check(const Case& what) {
  const Scenario scenario = scenario_of(what);
  const Run reference = run("mechanism-cvode", what, scenario, 2e-3);
  std::printf("%s on %s: reference %.3g off, %.3g J unaccounted\n", what.kind, what.parent, reference.off,
              reference.unaccounted);
  CHECK_BETWEEN(reference.off, 0, 1e-9);
  CHECK_BETWEEN(reference.unaccounted, 0, 1e-9);
  std::size_t driven = 0;
  for (const auto& number : {what.motions.way, what.motions.turn, what.motions.own_turn}) driven += number ? 1 : 0;
  CHECK_EQUAL(reference.motors, driven);
  Run before;
  double order = 0;
  for (const double h : {2e-3, 1e-3, 5e-4}) {
    const Run now = run("ode-step-double", what, scenario, h);
    order = std::log2(before.off / now.off);
    std::printf("  ODE at %g: %.4g, order %.3f; unaccounted %.3g J\n", h, now.off, order, now.unaccounted);
    CHECK_EQUAL(now.motors, driven);
    before = now;
  }
  const Run accurate = run("ode-rk4-double", what, scenario, 1e-3);
  std::printf("  accurate step %.3g\n", accurate.off);
  if (what.ode_errs) {
    CHECK_BETWEEN(order, -0.1, 0.1);
    CHECK_BETWEEN(before.off, 0.5, 2);
  } else {
    CHECK_BETWEEN(order, 0.9, 1.1);
  }
  CHECK_BETWEEN(accurate.off, 0, 1e-9);
}

}  // namespace

int main() {
  const std::string one = "axis = " + shown(along) + "\n";
  const std::string two = one + "axis2 = " + shown(across) + "\n";
  const std::string three =
      "axis = " + shown(third) + "\naxis2 = " + shown(along) + "\naxis3 = " + shown(across) + "\n";
  const std::array cases{
      Case{"universal", "base", two, {.turn = 0, .own_turn = 1}},
      Case{"universal", "world", two, {.turn = 0, .own_turn = 1}},
      Case{"piston", "base", one, {.way = 0, .turn = 1}},
      Case{"piston", "world", one, {.way = 0, .turn = 1}},
      Case{"pr", "base", two, {.turn = 1, .turn_axis = across}},
      // ODE has the force on a pr's way act half-way between the bodies' centres (joint.cpp: addLimot), as on a slider,
      // but here it turns the hinge: by 0.375 N m, where that has a motor of 0.2 N m.
      Case{"pr", "base", two, {.way = 0, .turn = 1, .turn_axis = across}, true},
      Case{"pu", "base", three, {.way = 0, .way_axis = third, .turn = 1, .own_turn = 2}},
      Case{"pu", "world", three, {.turn = 1, .own_turn = 2}},
      Case{"hinge2", "base", two + "suspension = [1000.0, 10.0]\n", {.turn = 0, .own_turn = 1}},
  };
  for (const Case& what : cases) check(what);
  return test::verdict();
}
