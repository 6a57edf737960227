// Bodies may be written in any order, children before those that carry them as well: the motion is the same, in ODE, in
// the accurate step and in the reference.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "catalogue/accurate_method.hpp"
#include "model/read_scenario.hpp"
#include "reference/tree/tree_reference.hpp"
#include "tests/check.hpp"
#include "tests/oracle/beside_reference.hpp"
#include "tests/random_mechanisms.hpp"

namespace {

using namespace odeval;
using namespace odeval::test;

/// Numbers of bodies in the order in which they are written.
using Order = std::vector<std::size_t>;

Order reversed(std::size_t count) {
  Order order(count);
  std::iota(order.rbegin(), order.rend(), std::size_t{0});
  return order;
}

Order shuffled(std::size_t count, unsigned seed) {
  Random random(seed);
  Order order = reversed(count);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

/// The same mechanism with its bodies in that order.
Scenario written(const Scenario& scenario, const Order& order) {
  Scenario other = scenario;
  Mechanism& mechanism = other.mechanism;
  const auto place = [&](std::size_t body) {
    return static_cast<std::size_t>(std::ranges::find(order, body) - order.begin());
  };
  for (std::size_t i = 0; i < order.size(); ++i) mechanism.bodies[i] = scenario.mechanism.bodies[order[i]];
  for (Joint& joint : mechanism.joints) {
    joint.first = place(joint.first);
    if (joint.second) joint.second = place(*joint.second);
  }
  return other;
}

/// Of bodies' places and attitudes in all rows, m or rad.
double apart(const Recorded& one, const Recorded& other, const Order& order) {
  CHECK(one.motion.size() == 11 && other.motion.size() == 11);
  double most = 0;
  for (std::size_t k = 0; k < std::min(one.motion.size(), other.motion.size()); ++k) {
    for (std::size_t i = 0; i < order.size(); ++i) {
      const BodyState& a = one.motion[k].bodies[order[i]];
      const BodyState& b = other.motion[k].bodies[i];
      most = std::max({most, distance(a.position, b.position), test::apart(a.rotation, b.rotation)});
    }
  }
  return most;
}

/// Likewise; and what both state that they may be off by, m and rad together.
struct Difference {
  double is = 0;
  double stated = 0;
};
Difference apart(const Reference& one, const Reference& other, const Order& order) {
  Difference most;
  for (std::size_t k = 0; k < one.trace.rows(); ++k) {
    for (std::size_t i = 0; i < order.size(); ++i) {
      const BodyColumns& a = one.trace.bodies[order[i]];
      const BodyColumns& b = other.trace.bodies[i];
      most.is = std::max({most.is, distance(row(a.position, k), row(b.position, k)),
                          test::apart(row(a.rotation, k), row(b.rotation, k))});
    }
    for (const Reference* of : {&one, &other}) {
      most.stated = std::fmax(most.stated, of->uncertainty_position[k] + of->uncertainty_turn[k]);
    }
  }
  return most;
}

Recorded run(MakeSimulation make, Scenario scenario) {
  scenario.step_s = 1e-3;
  return recorded(make, scenario, rows_of(scenario.step_s));
}

// ODE puts the rows of its equations in the order in which it comes from one body to the next, and sums in it. What
// differs is rounding, which the motion makes larger: at most 1.4e-14 (ODE) and 2.8e-14 (accurate step) in half a
// second.
constexpr double rounding = 1e-12;

/// The reference grows its tree from the world by the joints' order: the same one, and so the same numbers. What flies
/// it grows from the first body that is written, so that rounding differs and with it CVODE's steps.
bool hangs(const Scenario& scenario) {
  return std::ranges::any_of(scenario.mechanism.joints, [](const Joint& joint) { return !joint.second; });
}

struct Runs {
  Recorded ode;
  Recorded accurate;
  Reference reference;
};
Runs runs_of(const Scenario& scenario) {
  return {run(world_step(), scenario), run(catalogue::make_accurate_4, scenario),
          reference::solve_tree(scenario, rows_of(row_spacing_s))};
}

void check(const Scenario& scenario, const Runs& runs, const Order& order) {
  const Runs others = runs_of(written(scenario, order));
  const double ode = apart(runs.ode, others.ode, order);
  const double accurate = apart(runs.accurate, others.accurate, order);
  const Difference reference = apart(runs.reference, others.reference, order);
  std::printf("%s, %zu bodies: ODE %.2g, accurate step %.2g, reference %.2g apart (%.2g stated)\n",
              scenario.name.c_str(), order.size(), ode, accurate, reference.is, reference.stated);
  CHECK_BETWEEN(ode, 0, rounding);
  CHECK_BETWEEN(accurate, 0, rounding);
  CHECK_BETWEEN(reference.is, 0, hangs(scenario) ? 0 : reference.stated);
}

void random_mechanisms() {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Scenario scenario = grown(seed, 3 + seed, all_kinds);
    lay_in_plane(scenario);
    if (seed == 3 && close_loops(scenario, seed, all_kinds)) scenario.name += " with loops";
    load(scenario, seed);
    const std::size_t count = scenario.mechanism.bodies.size();
    const Runs runs = runs_of(scenario);
    check(scenario, runs, reversed(count));
    check(scenario, runs, shuffled(count, seed));
  }
}

std::string table_of(std::size_t body) {
  return fmt::format("[[bodies]]\nname = \"part{0}\"\nmass = {1}\nsize = [0.3, 0.1, 0.2]\nposition = [{2}, 0, 1]\n",
                     body, 1 + 0.1 * static_cast<double>(body), 0.4 * static_cast<double>(body));
}

/// A chain on different joints, one of them in a loop, with what drives, stops and loads it.
std::string text_with(const Order& order) {
  std::string text = "problem = \"mechanism\"\nduration = 0.5\n";
  for (const std::size_t body : order) text += table_of(body);
  const std::array kinds{"hinge", "slider", "piston", "hinge", "ball"};
  for (std::size_t i = 0; i < order.size(); ++i) {
    text += fmt::format("[[joints]]\nname = \"on{0}\"\nkind = \"{1}\"\nparent = \"{2}\"\nchild = \"part{0}\"\n", i,
                        kinds[i], i == 0 ? "world" : fmt::format("part{}", i - 1));
    if (kinds[i] != std::string("slider")) text += fmt::format("anchor = [{}, 0, 1]\n", 0.4 * static_cast<double>(i));
    if (kinds[i] != std::string("ball")) text += fmt::format("axis = [{}, 1, 0.5]\n", i);
    if (i == 3) text += "stops = [-0.1, 0.2]\nstop_restitution = 0.5\n";
    if (i == 1) text += "motor = { velocity = 0.2, force = 30.0 }\n";
  }
  return text +
         "[[springs]]\njoint = \"on1\"\nstiffness = 50.0\n[[torques]]\njoint = \"on0\"\nconstant = 2.0\n"
         "[[struts]]\nparent = \"part4\"\nchild = \"part0\"\nfrom = [1.6, 0, 1]\nto = [0.1, 0, 1]\n"
         "stiffness = 20.0\n";
}

Scenario read(const Order& order) {
  Scenario scenario = ScenarioFile("chain.toml", text_with(order)).read({}, {});
  scenario.ode.cfm = 1e-10;
  return scenario;
}

/// Of a file too: names say what hangs on what.
void files() {
  const Scenario plain = read({0, 1, 2, 3, 4});
  const Recorded by_ode = run(world_step(), plain);
  const Reference solved = reference::solve_tree(plain, rows_of(row_spacing_s));
  for (const Order& order : {Order{4, 3, 2, 1, 0}, Order{2, 4, 0, 3, 1}}) {
    const Scenario other = read(order);
    const double ode = apart(by_ode, run(world_step(), other), order);
    const Difference reference = apart(solved, reference::solve_tree(other, rows_of(row_spacing_s)), order);
    std::printf("file: ODE %.2g, reference %.2g apart (%.2g stated)\n", ode, reference.is, reference.stated);
    for (std::size_t i = 0; i < order.size(); ++i) {
      CHECK_EQUAL(other.mechanism.bodies[i].name, fmt::format("part{}", order[i]));
    }
    CHECK_BETWEEN(ode, 0, rounding);
    CHECK_EQUAL(reference.is, 0.0);
  }
}

}  // namespace

int main() {
  random_mechanisms();
  files();
  return test::verdict();
}
