// The "boxes" benchmark of Gazebo in ODE: what the integration of a single free body is worth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "experiments/all.hpp"
#include "experiments/free_box_published.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using free_box_published::Errors;
using report::Cell;

constexpr double steps_s[] = {1e-4, 4e-4, 1e-3};
constexpr double early_s = 1;  // the tumbling of a first-order run is lost after 2 s
constexpr double spacing_s = 1e-2;
constexpr const char* measured_methods[] = {"ode-step-double",      "ode-step-single", "ode-quickstep-double",
                                            "ode-quickstep-single", "ode-rk4-double",  "lagrange-cvode"};

/// Of which nothing was published.
constexpr const char* other_methods[] = {"bullet-multibody-double", "mujoco-euler", "mujoco-implicit", "mujoco-rk4"};

/// A case of the benchmark, of which the scenario file has the second.
struct Case {
  const char* name;
  bool tumbles;
};
constexpr Case cases[] = {{"simple", false}, {"tumbling", true}};

Scenario scenario_of(const Case& which, Scenario scenario, double step_s) {
  if (!which.tumbles) {
    scenario.gravity = 0;
    scenario.mechanism.bodies[0].velocity_m_s = {-0.9, 0.4, 0.1};
    scenario.mechanism.bodies[0].spin_rad_s = {0.5, 0, 0};
  }
  scenario.step_s = step_s;
  scenario.sample_s = spacing_s;
  return scenario;
}

/// |L| and the kinetic energy at the start, which the benchmark measures by.
struct Scales {
  double momentum = 0;
  double energy = 0;
};
Scales scales_of(const Body& body) {
  const Vec3 moments = body.uniform_moments_kgm2();  // the body starts in the world's axes
  Scales scales{0, body.mass_kg * dot(body.velocity_m_s, body.velocity_m_s) / 2};
  for (std::size_t k = 0; k < 3; ++k) {
    const double angular = moments[k] * body.spin_rad_s[k];
    scales.momentum += angular * angular;
    scales.energy += angular * body.spin_rad_s[k] / 2;
  }
  scales.momentum = std::sqrt(scales.momentum);
  return scales;
}

Errors errors_of(Evaluator& evaluator, const Evaluation& run) {
  const Metrics all = evaluator.measure(run, evaluator.scenario().duration_s);
  const Scales scales = scales_of(evaluator.scenario().mechanism.bodies[0]);
  return {*all[quantity::max_error_position], *all[quantity::max_angular_momentum_drift] / scales.momentum,
          *all[quantity::max_energy_drift] / scales.energy, *all[quantity::max_error_turn]};
}

/// Theirs beside ours.
std::vector<Cell> compared(const Case& which, double step_s, const free_box_published::Engine& engine,
                           const Errors& ours) {
  const Errors* const found = free_box_published::of(engine.method, which.tumbles, step_s);
  const Errors theirs = found != nullptr ? *found : Errors{NAN, NAN, NAN, {}};
  const Cell turned =
      theirs.turned_rad ? Cell(*theirs.turned_rad) : Cell(report::Missing{"no attitude to compare with"});
  return {std::string(which.name),
          fmt::format("{} ({})", engine.name, engine.method),
          1e3 * step_s,
          theirs.distance_m,
          ours.distance_m,
          turned,
          *ours.turned_rad,
          theirs.momentum,
          ours.momentum,
          theirs.energy,
          ours.energy};
}

/// What the experiment measures, case after case.
class FreeFlights {
 public:
  explicit FreeFlights(const Scenario& file) : file_(file) {}

  void measure(const Case& which, double step_s) {
    Evaluator evaluator(scenario_of(which, file_, step_s));
    for (const char* name : measured_methods) {
      const catalogue::Method* const method = available(name);
      if (method == nullptr) {
        table.rows.push_back(row_left_out({std::string(which.name), std::string(name), step_s}, table.columns.size()));
      } else {
        add_row(which, step_s, *method, evaluator);
      }
    }
    for (const char* name : other_methods) {  // the page says once what the build lacks
      if (const catalogue::Method* const method = available(name)) add_row(which, step_s, *method, evaluator);
    }
    for (const free_box_published::Engine& engine : free_box_published::engines()) {
      const catalogue::Method* const method = available(engine.method);
      if (method == nullptr) continue;
      const Errors errors = errors_of(evaluator, evaluator.evaluate(*method));
      compared_rows_[{which.tumbles, &engine}].push_back(compared(which, step_s, engine, errors));
      if (!which.tumbles) continue;
      measured_[{std::string(method->name), step_s}] = errors;
      if (step_s == std::end(steps_s)[-1]) halve(which, step_s / 2, *method);  // the coarsest, which costs the least
    }
    if (which.tumbles && step_s == file_.step_s) {
      const Reference& reference = evaluator.reference();
      over_time.series.push_back(uncertainty_curve(reference.trace.t, reference.uncertainty_turn));
    }
  }

  report::Table table{.name = "free-box",
                      .columns = {"case", "method", "step, s", "distance, m", "g h T / 2, m", "± m",
                                  fmt::format("turned until {} s, rad", early_s), "± rad", "turned until 10 s, rad",
                                  "± rad", "angular momentum error", "energy error"}};
  /// Theirs beside ours, an engine's steps together.
  report::Table beside() const {
    report::Table all{
        .name = "free-box-published",
        .columns = {"case", "engine (method here)", "step, ms", "distance, m: Gazebo 6", "here",
                    "turned, rad: Gazebo 6", "here", "angular momentum: Gazebo 6", "here", "energy: Gazebo 6", "here"}};
    for (const auto& [key, rows] : compared_rows_) all.rows.insert(all.rows.end(), rows.begin(), rows.end());
    return all;
  }

  std::string about_published() const { return free_box_published::about(measured_); }

  report::Panel over_time{.title = "over time, tumbling", .x_label = "t, s", .y_label = "angle, rad", .log_y = true};
  report::Series turned{fmt::format("angle until {} s, rad", early_s), {}, {}, report::Mark::line_and_points};
  report::Series fallen{"distance until 10 s, m", {}, {}, report::Mark::line_and_points};
  double off_the_law = 0;
  double uncertainty = 0;

 private:
  void add_row(const Case& which, double step_s, const catalogue::Method& method, Evaluator& evaluator) {
    const Scenario& scenario = evaluator.scenario();
    const double law = scenario.gravity * step_s * scenario.duration_s / 2;
    const Evaluation run = evaluator.evaluate(method);
    const Errors errors = errors_of(evaluator, run);
    const Metrics all = evaluator.measure(run, scenario.duration_s);
    const Metrics early = evaluator.measure(run, early_s);
    if (which.tumbles) measured_[{std::string(method.name), step_s}] = errors;
    const bool of_ode = catalogue::has_half_step_start(method);
    table.rows.push_back({std::string(which.name), std::string(method.name), step_s, errors.distance_m,
                          of_ode ? Cell(law) : Cell(std::string("-")), *all[quantity::position_uncertainty],
                          *early[quantity::max_error_turn], *early[quantity::turn_uncertainty], *errors.turned_rad,
                          *all[quantity::turn_uncertainty], errors.momentum, errors.energy});
    if (!which.tumbles) return;
    if (method.name == "ode-step-double") add_step(step_s, law, all, early);
    const bool measured = std::ranges::find(measured_methods, method.name) != std::end(measured_methods);
    if (step_s == file_.step_s && measured && !method.name.starts_with("ode-quickstep")) draw(run);
  }

  /// Gazebo may have divided a step.
  void halve(const Case& which, double step_s, const catalogue::Method& method) {
    Evaluator evaluator(scenario_of(which, file_, step_s));
    measured_[{std::string(method.name), step_s}] = errors_of(evaluator, evaluator.evaluate(method));
  }

  void add_step(double step_s, double law, const Metrics& all, const Metrics& early) {
    off_the_law = std::fmax(off_the_law, std::fabs(*all[quantity::max_error_position] - law));
    uncertainty = std::fmax(uncertainty, *all[quantity::position_uncertainty]);
    turned.x.push_back(step_s);
    turned.y.push_back(*early[quantity::max_error_turn]);
    fallen.x.push_back(step_s);
    fallen.y.push_back(*all[quantity::max_error_position]);
  }

  void draw(const Evaluation& run) {
    const std::string_view name = run.method->name;
    const Column& error = run.trace.error_turn[0];
    const auto lost = std::ranges::find_if(error, [](double angle) { return angle > divergence_rad; });
    if (name == "ode-step-double" && lost != error.end()) {
      over_time.shade = report::Shade{run.trace.t[static_cast<std::size_t>(lost - error.begin())],
                                      fmt::format("dWorldStep is off by more than {} rad", divergence_rad)};
    }
    over_time.series.push_back(
        curve(std::string(name), run.trace.t, above_zero(error), colour_of(name), name.ends_with("single")));
  }

  const Scenario& file_;
  free_box_published::Measured measured_;
  std::map<std::pair<bool, const free_box_published::Engine*>, std::vector<std::vector<Cell>>>
      compared_rows_;  // tumbling ones last
};

std::vector<std::string> methods() {
  std::vector<std::string> all(std::begin(measured_methods), std::end(measured_methods));
  for (const free_box_published::Engine& engine : free_box_published::engines()) {
    if (std::ranges::find(all, engine.method) == all.end()) all.emplace_back(engine.method);
  }
  all.insert(all.end(), std::begin(other_methods), std::end(other_methods));
  return all;
}

}  // namespace

Content free_box(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("free_box");
  FreeFlights flights(file);
  for (const Case& which : cases) {
    for (const double step_s : steps_s) flights.measure(which, step_s);
  }
  findings.add("free_box.off_the_law", measured("distance of dWorldStep's error from g h T / 2, largest of three steps",
                                                "m", flights.off_the_law, flights.uncertainty));

  report::Panel over_steps{.title = "dWorldStep over the step, tumbling",
                           .x_label = "h, s",
                           .y_label = "error, rad or m",
                           .log_x = true,
                           .log_y = true};
  over_steps.series = {flights.turned, flights.fallen};
  report::Figure figure{.name = "free-box-errors", .columns = 2};
  figure.panels = {std::move(over_steps), std::move(flights.over_time)};
  Content content;
  const Vec3 sides = sides_m(file.mechanism.bodies[0].shape);
  content.values = {{"step", file.step_s},
                    {"duration", file.duration_s},
                    {"mass", file.mechanism.bodies[0].mass_kg},
                    {"sides", fmt::format("{:g} x {:g} x {:g}", sides[0], sides[1], sides[2])},
                    {"off_the_law", shown(flights.off_the_law)},
                    {"published", flights.about_published()},
                    {"left_out", left_out(methods())}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(flights.table));
  content.exhibits.emplace_back(flights.beside());
  return content;
}

}  // namespace odeval::experiments
