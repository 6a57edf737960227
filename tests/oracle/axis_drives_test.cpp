// Springs, torques, controllers, stops and motors of every motion of joints that leave several, one by one and all at
// once, in closed form: beside the reference, which has to agree to 1e-9, ODE, which has to come nearer by the step,
// and the accurate step where it reads what is asked.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "catalogue/methods.hpp"
#include "model/read_scenario.hpp"
#include "reference/tree/tree_reference.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

// A cube about its centre, which the anchor is in: what moves it one way loads no other one.
constexpr double mass = 2;                  // kg
constexpr double moment = mass * 0.09 / 6;  // kg m²: sides of 0.3 m
constexpr double duration_s = 0.7;
constexpr double coarsest_s = 2e-3;

const Vec3 along = unit(Vec3{1, 2, -2});
const Vec3 across = unit(Vec3{2, 1, 2});
const Vec3 third{1, 0, 0};

/// A motion of the cube against what carries it, by its number in files.
struct Movable {
  bool slides;
  Vec3 axis;
  bool stopped = true;     // ODE has stops of it
  bool ode_bumps = false;  // and its stop pushes off the centre, at every step
};
struct Case {
  const char* kind;
  const char* parent;
  std::string keys;
  std::vector<Movable> motions;
  bool alone = false;  // all at once they load each other
  double height_m = 0.5;

  Vec3 anchor() const { return {0.2, -0.1, height_m}; }
};

/// What acts on one motion: its tables in a file, and where it goes.
struct Acting {
  std::string of_joint;  // below [[joints]]
  std::string tables;
  std::function<double(double t)> q;
};

double inertia(const Movable& motion) { return motion.slides ? mass : moment; }

std::string key(const char* name, std::size_t number) {
  return number == 1 ? std::string(name) : fmt::format("{}{}", name, number);
}

/// Of a damped oscillator from rest at 0.
double swung(double m, double stiffness, double damping, double middle, double t) {
  const double decay = damping / (2 * m);
  const double turns = std::sqrt(stiffness / m - decay * decay);
  return middle - middle * std::exp(-decay * t) * (std::cos(turns * t) + decay / turns * std::sin(turns * t));
}

/// Sizes that tell motions apart: of the first, the second and the third.
double size_of(std::size_t number) { return std::array{1.0, 1.3, 0.7}[number - 1]; }

Acting loaded(const Movable& motion, std::size_t number) {
  const double m = inertia(motion);
  const double k = 30 * m * size_of(number), kp = 10 * m, d = 0.5 * m, kd = 0.3 * m;
  const double rest = 0.4 * size_of(number), torque = -4 * m, target = -0.2;
  const double middle = (k * rest + torque + kp * target) / (k + kp);
  return {"",
          fmt::format("[[springs]]\njoint = \"it\"\nmotion = {0}\nstiffness = {1}\ndamping = {2}\nrest = {3}\n"
                      "[[torques]]\njoint = \"it\"\nmotion = {0}\nconstant = {4}\n"
                      "[[controllers]]\njoint = \"it\"\nmotion = {0}\nkp = {5}\nkd = {6}\ntarget = {7}\n"
                      "sampling = \"continuous\"\n",
                      number, k, d, rest, torque, kp, kd, target),
          [=](double t) { return swung(m, k + kp, d + kd, middle, t); }};
}

/// Looked at once in each of the steps of a length, and held.
Acting controlled(const Movable& motion, std::size_t number, double h) {
  const double m = inertia(motion);
  const double kp = 40 * m * size_of(number), kd = 2 * m, target = 0.5;
  return {"",
          fmt::format("[[controllers]]\njoint = \"it\"\nmotion = {}\nkp = {}\nkd = {}\ntarget = {}\n", number, kp, kd,
                      target),
          [=](double until) {
            double q = 0, rate = 0;
            for (long step = 0; step < std::lround(until / h); ++step) {
              const double gained = (kp * (target - q) - kd * rate) / m;
              q += h * (rate + h * gained / 2);
              rate += h * gained;
            }
            return q;
          }};
}

constexpr double strikes_at_s = 0.4;  // on the end of a step, of every length here
constexpr double restitution = 0.5;   // above ODE's ERP; so it is struck again after 0.8 s

/// Pushed from rest against an end of its way, the low one of every second motion.
Acting stopped(const Movable& motion, std::size_t number) {
  const double gained = (number == 2 ? -1 : 1) * (motion.slides ? 5 : 8) * size_of(number);
  const double end = gained * strikes_at_s * strikes_at_s / 2;
  return {fmt::format("{} = [{}, {}]\n{} = {}\n", key("stops", number), std::fmin(end, -0.1), std::fmax(end, 0.1),
                      key("stop_restitution", number), restitution),
          fmt::format("[[torques]]\njoint = \"it\"\nmotion = {}\nconstant = {}\n", number, gained * inertia(motion)),
          [=](double t) {
            const double after = t - strikes_at_s;
            if (after < 0) return gained * t * t / 2;
            return end - restitution * gained * strikes_at_s * after + gained * after * after / 2;
          }};
}

/// At its speed from 0.2 s on.
Acting driven(const Movable& motion, std::size_t number) {
  const double speed = (number == 2 ? -1 : 1) * size_of(number), reached_s = 0.2;
  return {fmt::format("[joints.{}]\nvelocity = {}\nforce = {}\n", key("motor", number), speed,
                      std::fabs(speed) / reached_s * inertia(motion)),
          "", [=](double t) { return t < reached_s ? speed / reached_s * t * t / 2 : speed * (t - reached_s / 2); }};
}

std::string shown(const Vec3& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

struct Setup {
  Scenario scenario;
  std::vector<std::pair<Movable, std::function<double(double)>>> moves;
};

using Act = std::function<Acting(const Movable&, std::size_t number)>;

/// `only` is the number of the motion on which something acts, 0: on all.
Setup setup(const Case& what, const Act& act, std::size_t only, double h) {
  std::string text = fmt::format(
      "problem = \"mechanism\"\nduration = {}\ngravity = 0\n[[bodies]]\nname = \"base\"\nmass = 1\nsize = [1, 1, 1]\n"
      "position = [0, 0, -1]\n[[bodies]]\nname = \"cube\"\nmass = {}\nsize = [0.3, 0.3, 0.3]\nposition = {}\n"
      "[[joints]]\nkind = \"fixed\"\nparent = \"world\"\nchild = \"base\"\nanchor = [0, 0, -1]\n"
      "[[joints]]\nname = \"it\"\nkind = \"{}\"\nparent = \"{}\"\nchild = \"cube\"\nanchor = {}\n{}",
      duration_s, mass, shown(what.anchor()), what.kind, what.parent, shown(what.anchor()), what.keys);
  std::string tables;
  Setup made;
  for (std::size_t number = 1; number <= what.motions.size(); ++number) {
    if (only != 0 && number != only) continue;
    const Movable& motion = what.motions[number - 1];
    const Acting acting = act(motion, number);
    text += acting.of_joint;
    tables += acting.tables;
    made.moves.emplace_back(motion, acting.q);
  }
  made.scenario = ScenarioFile("x.toml", text + tables).read({}, {});
  made.scenario.ode.cfm = 0;
  made.scenario.step_s = h;
  made.scenario.sample_s = coarsest_s;
  return made;
}

Frame truth(const Case& what, const Setup& of, double t) {
  Frame frame{what.anchor()};
  for (const auto& [motion, q] : of.moves) {
    if (motion.slides) {
      frame.position_m = frame.position_m + q(t) * motion.axis;
    } else {
      frame.rotation = frame.rotation * rotation_about(motion.axis, q(t));
    }
  }
  return frame;
}

struct Run {
  double off = 0;          // m or rad
  double unaccounted = 0;  // J
  double force = 0;        // N, of the joint
  std::vector<StopStrike> strikes;
};
/// `reference` is of rows at the same times; its motion is not looked at.
Run run(const char* method, const Case& what, const Setup& of, const std::shared_ptr<const Reference>& reference) {
  catalogue::Evaluator evaluator(of.scenario, reference);
  const catalogue::Evaluation found = evaluator.evaluate(catalogue::find_method(method));
  CHECK(!found.outcome.diverged && found.trace.rows() > 1);
  const BodyColumns& cube = found.trace.bodies[1];
  Run run{.strikes = found.outcome.strikes};
  for (std::size_t k = 0; k < found.trace.rows(); ++k) {
    const Frame is = truth(what, of, found.trace.t[k]);
    for (std::size_t d = 0; d < 3; ++d) run.off = std::fmax(run.off, std::fabs(is.position_m[d] - cube.position[d][k]));
    for (std::size_t d = 0; d < 9; ++d) run.off = std::fmax(run.off, std::fabs(is.rotation[d] - cube.rotation[d][k]));
    run.force = std::fmax(run.force, length({cube.joint_force[0][k], cube.joint_force[1][k], cube.joint_force[2][k]}));
    if (found.trace.unaccounted.empty()) continue;  // of the accurate step
    run.unaccounted = std::fmax(run.unaccounted, std::fabs(found.trace.unaccounted[k]));
  }
  return run;
}

/// Each motion strikes the end that its file says.
void check_strikes(const std::vector<StopStrike>& strikes, const Setup& of, double late_s) {
  const Joint& joint = of.scenario.mechanism.joints[1];
  const auto with_stop =
      std::ranges::count_if(joint.drives, [](const AxisDrive& drive) { return drive.stop.has_value(); });
  CHECK_EQUAL(strikes.size(), static_cast<std::size_t>(with_stop));
  for (const StopStrike& strike : strikes) {
    CHECK_EQUAL(strike.joint, std::size_t{1});
    CHECK_BETWEEN(strike.t, strikes_at_s - 1e-9, strikes_at_s + late_s);
    const bool low = strike.low == (joint.second ? false : true);  // files count the child against a parent that moves
    CHECK_EQUAL(low, strike.motion == 2);
    CHECK_NEAR(strike.rate_after / strike.rate_before, -restitution, 1e-3);
  }
}

/// ODE's order is first, or it errs by as much at every step.
void check(const char* how, const Case& what, const std::function<Act(double h)>& act, std::size_t only, bool errs) {
  const Setup at_coarsest = setup(what, act(coarsest_s), only, coarsest_s);
  const auto rows =
      std::make_shared<const Reference>(reference::solve_tree(at_coarsest.scenario, sample_grid(at_coarsest.scenario)));
  const Run reference = run("mechanism-cvode", what, at_coarsest, rows);
  std::printf("%s on %s, %s, %s: reference %.3g off, %.3g J unaccounted, %.3g N\n", what.kind, what.parent, how,
              only == 0 ? "all motions" : fmt::format("motion {}", only).c_str(), reference.off, reference.unaccounted,
              reference.force);
  CHECK_BETWEEN(reference.off, 0, 1e-9);
  CHECK_BETWEEN(reference.unaccounted, 0, 1e-9);
  // What moves it is all that it needs: a load of a way is no force of the joint.
  if (how == std::string("loaded") || how == std::string("controlled")) CHECK_BETWEEN(reference.force, 0, 1e-9);
  check_strikes(reference.strikes, at_coarsest, 1e-9);
  Run before;
  double order = 0;
  for (const double h : {coarsest_s, coarsest_s / 2, coarsest_s / 4}) {
    const Setup now = setup(what, act(h), only, h);
    const Run ode = run("ode-step-double", what, now, rows);
    order = std::log2(before.off / ode.off);
    std::printf("  ODE at %g: %.4g, order %.3f; unaccounted %.3g J\n", h, ode.off, order, ode.unaccounted);
    if (!errs) check_strikes(ode.strikes, now, 2 * h);
    before = ode;
  }
  if (errs) {
    CHECK_BETWEEN(order, -0.2, 0.2);
  } else {
    CHECK_BETWEEN(order, 0.9, 1.1);
  }
  const catalogue::Method& rk4 = catalogue::find_method("ode-rk4-double");
  if (!catalogue::does(rk4, at_coarsest.scenario)) return;
  const Run accurate = run("ode-rk4-double", what, at_coarsest, rows);
  std::printf("  accurate step %.3g\n", accurate.off);
  CHECK_BETWEEN(accurate.off, 0, 1e-9);
}

void check_motions(const char* how, const Case& what, const std::function<Act(double h)>& act,
                   bool (*wanted)(const Movable&)) {
  std::size_t all = 0;
  for (std::size_t number = 1; number <= what.motions.size(); ++number) {
    const Movable& motion = what.motions[number - 1];
    if (!wanted(motion)) continue;
    ++all;
    check(how, what, act, number, how == std::string("stopped") && motion.ode_bumps);
  }
  if (all == what.motions.size() && !what.alone) check(how, what, act, 0, false);
}

bool any(const Movable&) { return true; }
bool has_stops(const Movable& motion) { return motion.stopped; }

}  // namespace

int main(int argc, char** argv) {
  const std::string one = "axis = " + shown(along) + "\n";
  const std::string two = one + "axis2 = " + shown(across) + "\n";
  const std::string three =
      "axis = " + shown(third) + "\naxis2 = " + shown(along) + "\naxis3 = " + shown(across) + "\n";
  const Movable first{false, along}, second{false, across}, way{true, along};
  const std::vector<Case> cases{
      {"universal", "base", two, {first, second}},
      {"universal", "world", two, {first, second}},
      {"piston", "base", one, {way, first}},
      {"piston", "world", one, {way, first}},
      {"pr", "base", two, {{true, along, true, true}, second}, true},
      {"pr", "world", two, {way, second}, true},
      {"pu", "base", three, {{true, third}, first, second}},
      {"pu", "world", three, {{true, third}, first, second}, true},
      {"hinge2", "base", two + "suspension = [1000.0, 10.0]\n", {first, {false, across, false}}},
      {"plane2d",
       "world",
       "",
       {{true, {1, 0, 0}, false}, {true, {0, 1, 0}, false}, {false, {0, 0, 1}, false}},
       false,
       0},
  };
  for (const Case& what : cases) {
    if (argc > 1 && what.kind != std::string(argv[1])) continue;
    check_motions(
        "loaded", what, [](double) -> Act { return loaded; }, any);
    check_motions(
        "controlled", what,
        [](double h) -> Act { return [h](const Movable& m, std::size_t n) { return controlled(m, n, h); }; }, any);
    check_motions(
        "stopped", what, [](double) -> Act { return stopped; }, has_stops);
    if (what.kind == std::string("plane2d"))
      check_motions(
          "driven", what, [](double) -> Act { return driven; }, any);
  }
  return test::verdict();
}
