// The "boxes" benchmark of Gazebo in ODE: what the integration of a single free body is worth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;

constexpr double steps_s[] = {1e-4, 4e-4, 1e-3};
constexpr double early_s = 1;  // the tumbling of a first-order run is lost after 2 s
constexpr double spacing_s = 1e-2;
constexpr const char* measured_methods[] = {"ode-step-double",      "ode-step-single", "ode-quickstep-double",
                                            "ode-quickstep-single", "ode-rk4-double",  "lagrange-cvode"};

/// Largest errors, those of angular momentum and energy relative to what they were at the start.
struct Errors {
  double distance_m = 0;
  double momentum = 0;
  double energy = 0;
  std::optional<double> turned_rad = {};
};

/// The benchmark's own results: S. Peters' repository scpeters/benchmark,
/// benchmark_gazebo/test_results/BENCHMARK_boxes_dt.csv, of Gazebo 6 in 2015.
struct Published {
  const char* method;  // of ours that is theirs
  bool tumbles;
  double step_s;
  Errors errors;
};
// clang-format off
constexpr Published published[] = {
    {"ode-quickstep-double",  false, 1e-4, {1.32316e-11, 0, 0, 1.04167e-09}},
    {"ode-quickstep-double",  false, 4e-4, {3.11725e-12, 0, 0, 1.66673e-08}},
    {"ode-quickstep-double",  false, 1e-3, {1.65532e-12, 0, 0, 1.04177e-07}},
    {"bullet-hinge-double",   false, 1e-4, {1.32316e-11, 1.69995e-12, 6.85531e-14, 3.40528e-12}},
    {"bullet-hinge-double",   false, 4e-4, {3.11725e-12, 1.72371e-13, 7.10395e-15, 4.50751e-13}},
    {"bullet-hinge-double",   false, 1e-3, {1.65532e-12, 5.28787e-14, 2.13118e-15, 1.58096e-13}},
    {"simbody-semi-explicit", false, 1e-4, {1.9222e-11, 0, 0, 2.60406e-10}},
    {"simbody-semi-explicit", false, 4e-4, {5.03797e-12, 0, 0, 4.16683e-09}},
    {"simbody-semi-explicit", false, 1e-3, {2.29424e-12, 0, 0, 2.60443e-08}},
    {"dart-step",             false, 1e-4, {1.32316e-11, 9.15335e-16, 3.46317e-14, 2.30683e-06}},
    {"dart-step",             false, 4e-4, {3.11725e-12, 1.23444e-15, 1.74047e-14, 6.28318}},
    {"dart-step",             false, 1e-3, {1.65532e-12, 8.48948e-16, 2.48638e-15, 3.1082e-06}},
    {"ode-quickstep-double",  true,  1e-4, {0.0049, 0.0012715, 0.00124711}},
    {"ode-quickstep-double",  true,  4e-4, {0.0196008, 0.00513309, 0.00498742}},
    {"ode-quickstep-double",  true,  1e-3, {0.0490049, 0.0130775, 0.0124631}},
    {"bullet-hinge-double",   true,  1e-4, {0.0049, 0.00125827, 0.0013586}},
    {"bullet-hinge-double",   true,  4e-4, {0.0196008, 0.00501544, 0.00543344}},
    {"bullet-hinge-double",   true,  1e-3, {0.0490049, 0.0124515, 0.0135785}},
    {"simbody-semi-explicit", true,  1e-4, {0.00245, 0.000634808, 0.00062358}},
    {"simbody-semi-explicit", true,  4e-4, {0.00980039, 0.00255109, 0.00249411}},
    {"simbody-semi-explicit", true,  1e-3, {0.0245024, 0.00643788, 0.00623412}},
    {"dart-step",             true,  1e-4, {0.0049, 2.22942, 0.0269129}},
    {"dart-step",             true,  4e-4, {0.0196008, 2.23344, 0.0289518}},
    {"dart-step",             true,  1e-3, {0.0490049, 2.18611, 0.0376207}},
};
// clang-format on
/// Whose numbers were published, and who has them here.
struct Compared {
  const char* engine;
  const char* method;
};
constexpr Compared compared_engines[] = {{"ODE", "ode-quickstep-double"},
                                         {"Bullet", "bullet-hinge-double"},
                                         {"Simbody", "simbody-semi-explicit"},
                                         {"DART", "dart-step"}};
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
std::vector<Cell> compared(const Case& which, double step_s, const Compared& engine, const Errors& ours) {
  const auto* const found = std::ranges::find_if(published, [&](const Published& row) {
    return row.method == std::string_view(engine.method) && row.tumbles == which.tumbles && row.step_s == step_s;
  });
  const Errors theirs = found != std::end(published) ? found->errors : Errors{NAN, NAN, NAN, {}};
  const Cell turned =
      theirs.turned_rad ? Cell(*theirs.turned_rad) : Cell(report::Missing{"no attitude to compare with"});
  return {std::string(which.name),
          fmt::format("{} ({})", engine.engine, engine.method),
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
    for (const Compared& engine : compared_engines) {
      const catalogue::Method* const method = available(engine.method);
      if (method == nullptr) continue;
      compared_rows_[{which.tumbles, &engine}].push_back(
          compared(which, step_s, engine, errors_of(evaluator, evaluator.evaluate(*method))));
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
  std::map<std::pair<bool, const Compared*>, std::vector<std::vector<Cell>>> compared_rows_;  // tumbling ones last
};

std::vector<std::string> methods() {
  std::vector<std::string> all(std::begin(measured_methods), std::end(measured_methods));
  for (const Compared& engine : compared_engines) {
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
                    {"left_out", left_out(methods())}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(flights.table));
  content.exhibits.emplace_back(flights.beside());
  return content;
}

}  // namespace odeval::experiments
