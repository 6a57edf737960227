#include "experiments/rolling.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "report/text.hpp"

namespace odeval::experiments::rolling {
namespace {

using report::shown;

/// Of the box, m/s²: friction of the ground takes its part of the force, a ball that rolls is as heavy as 2/7 of it.
constexpr double of_box =
    (force_N - of_ground * gravity * (box_kg + balls * ball_kg)) / (box_kg + balls * ball_kg / 3.5);
constexpr double of_ball = of_box / 3.5;

Vec3 towards(double direction_deg) {
  const double direction = direction_deg * std::numbers::pi / 180;
  return {std::cos(direction), std::sin(direction), 0};
}

}  // namespace

Scenario scene(double direction_deg, int iterations, const Lead& lead) {
  Scenario scenario;
  scenario.name = "rolling";
  scenario.duration_s = duration_s;
  scenario.step_s = step_s;
  scenario.sample_s = 0.01;
  scenario.gravity = gravity;
  scenario.ode.iterations = iterations;
  scenario.ode.erp = 0;
  scenario.ode.cfm = 1e-10;
  scenario.bullet.iterations = iterations;
  scenario.bullet.erp = 0;
  scenario.mujoco.elliptic = true;  // its pyramid has less friction askew to the axes, by up to the root of two
  Mechanism& mechanism = scenario.mechanism;
  const Vec3 centre{0, 0, 0.5};
  mechanism.bodies = {{.shape = Box{{20, 20, 1}}, .mass_kg = box_kg, .position_m = centre, .name = "box"}};
  for (int k = 0; k < balls; ++k) {
    const Vec3 place{2.0 * (k / 5) - 4, 2.0 * (k % 5) - 4, 1.5};
    mechanism.bodies.push_back(
        {.shape = Sphere{1}, .mass_kg = ball_kg, .position_m = place, .name = "ball" + std::to_string(k)});
  }
  const std::size_t first = mechanism.bodies.size();
  const Body slider{
      .shape = Box{{0.1, 0.1, 0.1}}, .mass_kg = lead.slider_kg, .position_m = centre + Vec3{0, 0, lead.above_m}};
  mechanism.bodies.insert(mechanism.bodies.end(), 2, slider);
  const Vec3 along = towards(direction_deg);
  const auto push = [&](int sliders) { return force_N + sliders * lead.slider_kg * of_box; };
  mechanism.joints = {{.kind = SliderJoint{{}, {1, 0, 0}}, .first = first, .second = {}},
                      {.kind = SliderJoint{{}, {0, 1, 0}}, .first = first + 1, .second = first},
                      {.kind = SliderJoint{{}, {0, 0, 1}}, .first = 0, .second = first + 1}};
  mechanism.joints[0].torques = {{.constant = push(2) * along[0]}};
  mechanism.joints[1].torques = {{.constant = push(1) * along[1]}};
  mechanism.obstacles = {{HalfSpace{}, "ground"}};
  mechanism.contacts = {{.friction = Friction{of_ground}, .first = "box", .second = "ground"}};
  for (int k = 0; k < balls; ++k) {  // and not the sliders, which stand within the box
    mechanism.contacts.push_back(
        {.friction = Friction{of_balls}, .first = "box", .second = "ball" + std::to_string(k)});
  }
  return scenario;
}

double error(const Engine& method, double direction_deg, int iterations, const Lead& lead) {
  const Scenario scenario = scene(direction_deg, iterations, lead);
  const SampleGrid grid = sample_grid(scenario);
  const auto simulation = method.make(scenario, grid);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid.rows));
  if (simulation->run(Recorder(motion)).diverged) return INFINITY;
  const Motion& done = motion;
  const Vec3 along = towards(direction_deg);
  double sum = 0;
  for (std::size_t k = 0; k < done.size(); ++k) {
    const double t = grid.time(static_cast<long>(k));
    for (const auto& [body, acceleration] : {std::pair{0, of_box}, std::pair{1, of_ball}}) {
      const Vec3 off = done[k].bodies[static_cast<std::size_t>(body)].velocity - t * acceleration * along;
      sum += dot(off, off);
    }
  }
  return sum / static_cast<double>(done.size());
}

std::string about(const QuickStep& errors, int iterations, int few) {
  constexpr double much = 10;  // times as large
  std::string text;
  if (errors.with_few > much * errors.led) {
    text =
        fmt::format("QuickStep's error along y is what its iterations leave of the sliders: {} leave {}, {} leave {}.",
                    iterations, shown(errors.led), few, shown(errors.with_few));
  } else {
    text = fmt::format("QuickStep's error along y is {} with {} iterations and {} with {}.", shown(errors.led),
                       iterations, shown(errors.with_few), few);
  }
  if (errors.light_lead > much * errors.led) {
    text += fmt::format(
        " With sliders of {} kg, {} m above the box, it is {}: it begins each step without forces, {} iterations do "
        "not "
        "carry the pull from so little mass over the lever to the box, and the sliders run away.",
        shown(light.slider_kg), shown(light.above_m), shown(errors.light_lead), iterations);
  } else {
    text += fmt::format(" Sliders of {} kg, {} m above the box, it holds as well.", shown(light.slider_kg),
                        shown(light.above_m));
  }
  return text;
}

}  // namespace odeval::experiments::rolling
