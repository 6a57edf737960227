// What the accurate step costs beside dWorldStep, and what the cost buys.
//
//   odeval-accurate-cost [ROUNDS]
//
// Interleaved in one run: the double pendulum stepped by both; accuracy at equal CPU time (dWorldStep at h = 1e-4,
// until t = 2); what an error of 1e-8 rad until t = 3 costs by either order; cost per step of an arm of 7 hinges, and
// on chains of 8 to 256 links with a fitted exponent; mechanisms and stacks at rest; an impact; contacts that crowd.
// Prints medians and judges nothing.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "catalogue/paths.hpp"
#include "cli/settings.hpp"
#include "engines/ode_rk4/accurate_step.hpp"
#include "measure/spread.hpp"
#include "model/read_scenario.hpp"
#include "odeval/metrics.hpp"
#include "tests/accurate/crowds.hpp"

namespace {

using odeval::median;
using odeval::catalogue::cpu_seconds;
using odeval::catalogue::Evaluator;

odeval::Scenario double_pendulum(double h, double duration) {
  odeval::Scenario scenario = odeval::read_scenario(odeval::catalogue::scenario_folder() / "double_pendulum.toml", {},
                                                    odeval::cli::known_names());
  scenario.step_s = h;
  scenario.duration_s = duration;
  return scenario;
}

double seconds(const Evaluator& evaluator, const char* method) {
  const auto simulation = evaluator.make(odeval::catalogue::find_method(method));
  const double start = cpu_seconds();
  simulation->run(odeval::Recorder());
  return cpu_seconds() - start;
}

double error(Evaluator& evaluator, const char* method, double until) {
  const auto run = evaluator.evaluate(odeval::catalogue::find_method(method));
  return evaluator.measure(run, until)[odeval::quantity::max_error_q].value();
}

void per_step(int rounds) {
  const Evaluator evaluator(double_pendulum(1e-3, 10));
  std::vector<double> ratios, ode, accurate;
  for (int round = -1; round < rounds; ++round) {
    const double a = seconds(evaluator, "ode-step-double");
    const double b = seconds(evaluator, "ode-rk4-double");
    if (round < 0) continue;
    ode.push_back(1e6 * a / 10000);
    accurate.push_back(1e6 * b / 10000);
    ratios.push_back(b / a);
  }
  fmt::print("double_pendulum  dWorldStep {:.2f} us/step, accurate {:.2f} us/step: {:.2f} x (median of ratios)\n",
             median(ode), median(accurate), median(ratios));
}

/// Finds the step whose run takes at most as long as dWorldStep's at 1e-4, and compares errors until t = 2.
void equal_time(int rounds) {
  Evaluator fine(double_pendulum(1e-4, 2));
  const double ode_error = error(fine, "ode-step-double", 2);
  for (const long steps : {4000L, 5000L, 6000L}) {
    Evaluator coarse(double_pendulum(2.0 / static_cast<double>(steps), 2));
    std::vector<double> ratios;
    for (int round = -1; round < rounds; ++round) {
      const double a = seconds(fine, "ode-step-double");
      const double b = seconds(coarse, "ode-rk4-double");
      if (round >= 0) ratios.push_back(b / a);
    }
    const double accurate_error = error(coarse, "ode-rk4-double", 2);
    fmt::print(
        "until t = 2      dWorldStep h = 1e-4: {:.3g} rad; accurate h = {:.3g}: {:.3g} rad in {:.2f} x its time: "
        "{:.3g} x more accurate\n",
        ode_error, 2.0 / static_cast<double>(steps), accurate_error, median(ratios), ode_error / accurate_error);
  }
}

/// CPU time of a simulated second by either order, with steps that keep 1e-8 rad until t = 3.
void orders(int rounds) {
  Evaluator four(double_pendulum(1e-3, 3)), eight(double_pendulum(1e-2, 3));
  std::vector<double> by_four, by_eight;
  for (int round = -1; round < rounds; ++round) {
    const double a = seconds(four, "ode-rk4-double");
    const double b = seconds(eight, "ode-rk8-double");
    if (round < 0) continue;
    by_four.push_back(1e6 * a / 3);
    by_eight.push_back(1e6 * b / 3);
  }
  fmt::print(
      "until t = 3      order 4, h = 0.001: {:.3g} rad, {:.0f} us a second; order 8, h = 0.01: {:.3g} rad, {:.0f} us\n",
      error(four, "ode-rk4-double", 3), median(by_four), error(eight, "ode-rk8-double", 3), median(by_eight));
}

struct Costs {
  double ode, accurate, ratio;  // medians, us
};

/// Of a step of n links on hinges, `oblique` with every other axis upright.
Costs chain(int n, bool oblique, int steps, int rounds) {
  using namespace odeval::test;
  World one, other;
  for (World* world : {&one, &other}) {
    dWorldSetERP(world->id, 0.2);
    dWorldSetCFM(world->id, 1e-10);
    dBodyID before = nullptr;
    for (int i = 0; i < n; ++i) {
      const dBodyID link = world->box(1, {0.1, 1, 0.1}, {0, 0.5 + i, 0});
      const Vector3d axis = oblique && i % 2 == 1 ? Vector3d(0, 0, 1) : Vector3d(1, 0, 0);
      world->hinge(before == nullptr ? link : before, before == nullptr ? nullptr : link, {0, double(i), 0}, axis);
      before = link;
    }
  }
  odeval::AccurateStep step(one.id, one.space);
  std::vector<double> accurate, ode, ratios;
  for (int round = -1; round < rounds; ++round) {
    double start = cpu_seconds();
    for (int k = 0; k < steps; ++k) step(1e-4);
    const double a = (cpu_seconds() - start) / steps;
    start = cpu_seconds();
    for (int k = 0; k < steps; ++k) dWorldStep(other.id, 1e-4);
    const double b = (cpu_seconds() - start) / steps;
    if (round < 0) continue;
    accurate.push_back(1e6 * a), ode.push_back(1e6 * b), ratios.push_back(a / b);
  }
  return {median(ode), median(accurate), median(ratios)};
}

void chains(int rounds) {
  const Costs arm = chain(7, true, 500, rounds);
  fmt::print("arm of 7 hinges  dWorldStep {:.2f} us/step, accurate {:.2f} us/step: {:.2f} x\n", arm.ode, arm.accurate,
             arm.ratio);
  std::vector<double> logs_n, logs_accurate, logs_ode;
  for (const int n : {8, 16, 32, 64, 128, 256}) {
    const Costs costs = chain(n, false, n <= 32 ? 200 : 20, n <= 128 ? std::max(3, rounds / 3) : 3);
    fmt::print("chain of {:3}     dWorldStep {:9.2f} us/step, accurate {:9.2f} us/step\n", n, costs.ode,
               costs.accurate);
    logs_n.push_back(std::log(n));
    logs_accurate.push_back(std::log(costs.accurate));
    logs_ode.push_back(std::log(costs.ode));
  }
  const auto slope = [&](const std::vector<double>& y) {
    const auto count = static_cast<double>(y.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      sx += logs_n[i], sy += y[i], sxx += logs_n[i] * logs_n[i], sxy += logs_n[i] * y[i];
    }
    return (count * sxy - sx * sy) / (count * sxx - sx * sx);
  };
  fmt::print("cost grows as n to the power {:.2f} (dWorldStep {:.2f})\n", slope(logs_accurate), slope(logs_ode));
}

odeval::AccurateStepOptions bouncing(double restitution, double friction = 0) {
  odeval::AccurateStepOptions options;
  options.contact = [=](dGeomID, dGeomID) { return std::optional(odeval::Bounce{restitution, friction}); };
  return options;
}

/// A world with contacts, stepped by ODE in the usual way.
class OdeSteps {
 public:
  explicit OdeSteps(odeval::test::World& world, double friction = 0) : world_(world), friction_(friction) {
    dWorldSetERP(world.id, 0.2);
    dWorldSetCFM(world.id, 1e-9);
  }
  ~OdeSteps() { dJointGroupDestroy(contacts_); }
  OdeSteps(const OdeSteps&) = delete;
  OdeSteps& operator=(const OdeSteps&) = delete;

  void step(double h) {
    dSpaceCollide(world_.space, this, &near);
    dWorldStep(world_.id, h);
    dJointGroupEmpty(contacts_);
  }

 private:
  static void near(void* self, dGeomID one, dGeomID other) {
    const auto& steps = *static_cast<OdeSteps*>(self);
    const dBodyID a = dGeomGetBody(one), b = dGeomGetBody(other);
    if (a != nullptr && b != nullptr && dAreConnectedExcluding(a, b, dJointTypeContact) != 0) return;
    dContact contact[8]{};
    const int count = dCollide(one, other, 8, &contact[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      contact[i].surface.mode = dContactBounce | dContactApprox1;
      contact[i].surface.mu = steps.friction_;
      contact[i].surface.bounce = 0.5;
      contact[i].surface.bounce_vel = 0.01;
      dJointAttach(dJointCreateContact(steps.world_.id, steps.contacts_, &contact[i]), a, b);
    }
  }

  odeval::test::World& world_;
  double friction_;
  dJointGroupID contacts_ = dJointGroupCreate(0);
};

/// Frictionless on a plane, after 1.5 s in which they settle.
void at_rest(const char* what, int rounds, const std::function<void(odeval::test::World&)>& build) {
  constexpr double h = 1e-3;
  odeval::test::World one, other;
  for (odeval::test::World* world : {&one, &other}) {
    build(*world);
    dCreatePlane(world->space, 0, 0, 1, 0);
  }
  odeval::AccurateStep step(one.id, one.space, bouncing(0.5));
  OdeSteps ode(other);
  std::vector<double> accurate, plain, ratios;
  std::size_t touches = 0;
  for (int k = 0; k < 1500; ++k) step(h), ode.step(h);
  for (int round = -1; round < rounds; ++round) {
    constexpr int steps = 500;
    double start = cpu_seconds();
    for (int k = 0; k < steps; ++k) {
      step(h);
      touches += step.touches().size();
    }
    const double a = (cpu_seconds() - start) / steps;
    start = cpu_seconds();
    for (int k = 0; k < steps; ++k) ode.step(h);
    const double b = (cpu_seconds() - start) / steps;
    if (round < 0) continue;
    accurate.push_back(1e6 * a), plain.push_back(1e6 * b), ratios.push_back(a / b);
  }
  fmt::print("{:16} dWorldStep {:.2f} us/step, accurate {:.2f} us/step: {:.2f} x, {} touches\n", what, median(plain),
             median(accurate), median(ratios), touches);
}

/// Of the steps of a run, the least that each took in all repeats of it: a run repeats to the bit, and what is more is
/// the machine's.
class LeastTimes {
 public:
  explicit LeastTimes(std::size_t steps) : least_(steps, HUGE_VAL) {}

  template <class Step>
  void time(std::size_t k, Step&& step) {
    const double start = cpu_seconds();
    step();
    least_[k] = std::min(least_[k], cpu_seconds() - start);
  }
  double mean() const {
    return std::accumulate(least_.begin(), least_.end(), 0.0) / static_cast<double>(least_.size());
  }
  std::size_t slowest() const { return static_cast<std::size_t>(std::ranges::max_element(least_) - least_.begin()); }
  double operator[](std::size_t k) const { return least_[k]; }

 private:
  std::vector<double> least_;
};

struct CrowdKind {
  const char* name;
  void (*build)(odeval::test::World&);
  double friction;
};
constexpr double crowd_h = 5e-3;
constexpr std::size_t crowd_steps = 2000;

/// What a step did, which hangs on no clock: evaluations of the accelerations, and pairs of geoms that were asked how
/// they bounce, which is every touching pair once at every state looked at.
struct Work {
  int evaluations = 0, pairs = 0;
};
Work work_of(std::size_t k, const CrowdKind& kind) {
  odeval::test::World world;
  kind.build(world);
  Work work;
  odeval::AccurateStepOptions options;
  options.contact = [&](dGeomID, dGeomID) {
    ++work.pairs;
    return std::optional(odeval::Bounce{0, kind.friction});
  };
  options.forces = [&](double) { ++work.evaluations; };
  odeval::AccurateStep step(world.id, world.space, options);
  for (std::size_t i = 0; i <= k; ++i) {
    work = {};
    step(crowd_h);
  }
  return work;
}

/// Contacts that crowd, plastic, 10 s at h = 5 ms from the fall on: mean and slowest step, either against dWorldStep's
/// mean in the same run.
void crowd(const CrowdKind& kind) {
  constexpr int repeats = 3;
  LeastTimes accurate(crowd_steps), plain(crowd_steps);
  std::size_t crowded = 0;
  double overlap = 0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    odeval::test::World one, other;
    kind.build(one);
    kind.build(other);
    odeval::AccurateStep step(one.id, one.space, bouncing(0, kind.friction));
    OdeSteps ode(other, kind.friction);
    for (std::size_t k = 0; k < crowd_steps; ++k) {
      accurate.time(k, [&] { step(crowd_h); });
      plain.time(k, [&] { ode.step(crowd_h); });
    }
    crowded = step.crowded_steps();
    overlap = odeval::test::overlap(one);
  }
  const std::size_t slowest = accurate.slowest();
  const Work work = work_of(slowest, kind);
  fmt::print(
      "{:12} mu {:3} dWorldStep {:.1f} us/step, accurate {:.1f} us/step: {:.2f} x, slowest step {:.1f} x; {} crowded "
      "steps, overlap {:.2g} m\n{:12} the slowest is step {}: {} evaluations, {} pairs in contact\n",
      kind.name, kind.friction, 1e6 * plain.mean(), 1e6 * accurate.mean(), accurate.mean() / plain.mean(),
      accurate[slowest] / plain.mean(), crowded, overlap, "", slowest, work.evaluations, work.pairs);
}

/// Steps with and without an impact of a link that swings against a wall.
void impacts() {
  using namespace odeval::test;
  using Clock = std::chrono::steady_clock;
  World world;
  const dBodyID link = world.box(1, {1, 0.1, 0.1}, {1.5, 0, 3});
  world.hinge(link, nullptr, {1, 0, 3}, {0, 1, 0});
  dGeomSetPosition(dCreateBox(world.space, 1.8, 2, 10), 0, 0, 0);
  odeval::AccurateStep step(world.id, world.space, bouncing(1));
  std::vector<double> with, without;
  for (int k = 0; k < 200000; ++k) {
    const auto start = Clock::now();
    step(1e-3);
    const double took = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    (step.touches().empty() ? without : with).push_back(took);
  }
  fmt::print("an impact        step {:.2f} us, step with an impact {:.2f} us: {:.1f} steps ({} impacts)\n",
             median(without), median(with), median(with) / median(without), with.size());
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 11;
  per_step(rounds);
  equal_time(rounds);
  orders(rounds);
  chains(rounds);
  for (const int links : {2, 3, 4}) {
    at_rest(fmt::format("arm of {} at rest", links).c_str(), rounds, [links](odeval::test::World& world) {
      dBodyID before = nullptr;
      for (int i = 0; i < links; ++i) {
        const dBodyID link = world.box(1, {0.4, 0.1, 0.1}, {0.2 + 0.4 * i, 0, 0.055});
        world.hinge(link, before, {0.4 * i, 0, 0.055}, {0, 1, 0});
        before = link;
      }
    });
  }
  at_rest("stack of 4", rounds, [](odeval::test::World& world) {
    for (int i = 0; i < 4; ++i) world.box(1, {0.2, 0.2, 0.2}, {0, 0, 0.1 + 0.2 * i});
  });
  for (const double friction : {0.0, 0.5}) {
    crowd({"ragdoll", odeval::test::ragdoll, friction});
    crowd({"stack of 10", odeval::test::stack_of_10, friction});
    crowd({"pile of 50", odeval::test::pile_of_50, friction});
  }
  crowd({"buggy", odeval::test::buggy, 1});
  impacts();
}
