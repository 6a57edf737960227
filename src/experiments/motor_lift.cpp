// What a motor loses of its speed to CFM.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using report::Missing;
using report::Panel;

constexpr std::string_view shown_method = "ode-step-double";
constexpr std::string_view softened[] = {shown_method, "ode-quickstep-double"};
constexpr std::string_view rigid = "ode-rk4-double";
// What ODE takes where a program sets nothing, in double and in single precision, and ten times that.
constexpr double cfms[] = {1e-10, 1e-5, 1e-4};
constexpr double steps_s[] = {1e-2, 1e-3, 1e-4};
constexpr double rows_s = 1e-2;

/// A load from rest against its weight: at the limit of force up to the speed, then with the speed.
struct Lift {
  double mass_kg;
  double weight_N;
  double force_N;
  double velocity_m_s;

  double height_m(double t) const {
    const double acceleration = (force_N - weight_N) / mass_kg;
    const double reached_s = velocity_m_s / acceleration;
    return t < reached_s ? acceleration * t * t / 2 : velocity_m_s * (t - reached_s / 2);
  }
};

Lift lift_of(const Scenario& scenario) {
  const double mass = scenario.mechanism.bodies.front().mass_kg;
  const Motor& motor = scenario.mechanism.joints.front().motor.value();
  return {mass, mass * scenario.gravity, motor.most, motor.speed};
}

struct Lifted {
  double lost_m_s;  // of its speed, at the end
  Column t;
  Column behind_mm;  // the closed form
};

Lifted lifted(const Scenario& file, std::string_view method, double step_s, double cfm) {
  Scenario scenario = file;
  scenario.step_s = step_s;
  scenario.sample_s = rows_s;
  scenario.ode.cfm = cfm;
  const Lift lift = lift_of(scenario);
  const SampleGrid grid = sample_grid(scenario);
  const std::unique_ptr<Simulation> simulation = available(method)->make(scenario, grid);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid.rows));
  simulation->run(Recorder(motion));
  const auto load = [&](std::size_t k) { return std::as_const(motion)[k].bodies.front(); };
  Lifted all{lift.velocity_m_s - load(motion.size() - 1).velocity[2], {}, {}};
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const double t = grid.time(static_cast<std::int64_t>(k));
    all.t.push_back(t);
    all.behind_mm.push_back(1e3 * (lift.height_m(t) - (load(k).position[2] - load(0).position[2])));
  }
  return all;
}

}  // namespace

Content motor_lift(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("motor_lift");
  const Lift lift = lift_of(file);
  report::Table table{.name = "motor-lift",
                      .columns = {"method", "CFM", "h, s", "lost of the speed, mm/s", "CFM times the weight, mm/s",
                                  "behind at the end, mm"}};
  Panel panel{.title = "behind the closed form", .x_label = "t, s", .y_label = "distance, mm"};
  double most_off = 0;
  for (const std::string_view method : softened) {
    for (std::size_t i = 0; i < std::size(cfms); ++i) {
      const double law = cfms[i] * lift.weight_N;
      for (const double step_s : steps_s) {
        const Lifted run = lifted(file, method, step_s, cfms[i]);
        table.rows.push_back(
            {std::string(method), cfms[i], step_s, 1e3 * run.lost_m_s, 1e3 * law, run.behind_mm.back()});
        most_off = std::max(most_off, std::fabs(run.lost_m_s - law));
        if (method != shown_method || step_s != file.step_s) continue;
        panel.series.push_back(curve(fmt::format("CFM {}", shown(cfms[i])), run.t, run.behind_mm, variant(i)));
      }
    }
  }
  double rigid_lost = 0;
  for (const double step_s : steps_s) {
    const Lifted run = lifted(file, rigid, step_s, file.ode.cfm);
    table.rows.push_back({std::string(rigid), Missing{"none"}, step_s, 1e3 * run.lost_m_s, 0.0, run.behind_mm.back()});
    rigid_lost = std::max(rigid_lost, std::fabs(run.lost_m_s));
  }
  findings.add("motor.speed_loss_off",
               measured("largest difference of what a motor loses of its speed from CFM times the force it lifts with, "
                        "dWorldStep and QuickStep, all CFM and steps",
                        "m/s", most_off));
  findings.add("motor.rigid_loss",
               measured("most that the fourth-order step's motor loses of its speed, all steps", "m/s", rigid_lost));

  report::Figure figure{.name = "motor-lift-figure", .columns = 1};
  figure.panels.push_back(std::move(panel));
  Content content;
  content.values = {{"mass", lift.mass_kg},
                    {"force", lift.force_N},
                    {"velocity", lift.velocity_m_s},
                    {"duration", file.duration_s},
                    {"step", file.step_s}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
