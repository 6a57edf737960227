// The benchmark scenes of others, in ODE and in the engines of this build, beside what was published of them.
#include <cmath>
#include <random>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "experiments/rolling.hpp"
#include "odeval/error.hpp"
#include "odeval/motion.hpp"

namespace odeval::experiments {
namespace {

using report::Cell;
using report::Missing;

/// Numbers of SimBenchmark (D. Kang and J. Hwangbo, ETH Zurich, 2018: leggedrobotics/SimBenchmark), from the files
/// data/bouncing, data/666 and data/rolling/sample.csv that its figures are drawn from, at ERP 0.
struct Published {
  const char* method;                     // of ours that is theirs
  std::optional<double> bouncing;         // J², at 10 ms
  std::optional<double> pile;             // m², at 10 ms
  std::optional<double> along, diagonal;  // m²/s², at 1 ms
};
constexpr std::nullopt_t none = std::nullopt;
// clang-format off
constexpr Published published[] = {
    {"ode-step-double",         18808.3,    0.0161143, 0.21819,     none},
    {"ode-quickstep-double",    18808.3,    0.0161901, 7.66873e-09, 3.14497},
    {"bullet-hinge-double",     none,       none,      none,        none},
    {"bullet-multibody-double", 7.40664e+06, 37.4217,  4.93482e-09, 6.42665e-09},
    {"dart-step",               7.37588e+06, none,     0.42589,     3.14497},
    {"mujoco-euler",            none,       0.933766,  0.0092196,   0.00705417},
    {"ode-rk4-double",          none,       none,      none,        none},
};
// clang-format on
constexpr double their_step_s = 0.01;

Cell cell_of(const std::optional<double>& number, const char* why) {
  return number ? Cell(*number) : Cell(Missing{why});
}

const catalogue::Method* here(const char* name, const Scenario& scenario) {
  const catalogue::Method* const method = available(name);
  return method != nullptr && catalogue::does(*method, scenario) ? method : nullptr;
}

/// Theirs is without feedback of errors.
Scenario without_erp(Scenario scenario) {
  scenario.ode.erp = 0;
  scenario.ode.cfm = 1e-10;
  scenario.bullet.erp = 0;
  return scenario;
}

/// Mean over time of the squared error of the energy, J², of 49 balls that should bounce for ever.
std::optional<double> bouncing(catalogue::Evaluator& evaluator, const catalogue::Method& method) {
  const catalogue::Suspects trials;
  const catalogue::Evaluation run = evaluator.evaluate(method);
  const auto rms = evaluator.measure(run, evaluator.scenario().duration_s)[quantity::rms_energy_drift];
  if (run.outcome.diverged || !rms) return none;
  return *rms * *rms;
}

/// 6 x 6 x 6 balls a little apart, each off its place by up to a millimetre, that fall and run apart without friction.
Scenario pile() {
  constexpr double gap_m = 0.21;
  constexpr double lowest_m = 0.101;
  constexpr double off_m = 0.001;
  Scenario scenario;
  scenario.name = "pile";
  scenario.duration_s = 10;
  scenario.step_s = their_step_s;
  std::mt19937 engine(42);
  const auto place = [&](int k) {
    return gap_m * k + off_m * static_cast<double>(engine()) / static_cast<double>(std::mt19937::max());
  };
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) {
        const double x = place(i);
        const double y = place(j);
        const double z = place(k) + lowest_m;
        scenario.mechanism.bodies.push_back({.shape = Sphere{0.2}, .mass_kg = 10, .position_m = {x, y, z}});
      }
    }
  }
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  scenario.mechanism.contacts = {Contact{}};
  return scenario;
}

/// Sum of the squared overlaps of all pairs, m².
double overlap(std::span<const BodyState> bodies) {
  constexpr double diameter_m = 0.2;
  double sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double below = diameter_m / 2 - bodies[i].position[2];
    if (below > 0) sum += below * below;
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      const Vec3 between = bodies[j].position - bodies[i].position;
      const double squared = dot(between, between);
      if (squared >= diameter_m * diameter_m) continue;
      const double depth = diameter_m - std::sqrt(squared);
      sum += depth * depth;
    }
  }
  return sum;
}

/// Mean over time of that, none where the motion is lost, and CPU time, s.
std::pair<std::optional<double>, double> piled(const Scenario& scenario, const catalogue::Method& method) {
  const SampleGrid grid = sample_grid(scenario);
  const auto simulation = method.make(scenario, grid);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid.rows));
  const double start = catalogue::cpu_seconds();
  const bool lost = simulation->run(Recorder(motion)).diverged;
  const double seconds = catalogue::cpu_seconds() - start;
  if (lost) return {none, seconds};
  double sum = 0;
  const Motion& done = motion;
  for (std::size_t k = 0; k < done.size(); ++k) sum += overlap(done[k].bodies);
  return {sum / static_cast<double>(done.size()), seconds};
}

constexpr const char* not_here = "not in this build, or the method does not do it";
constexpr const char* unpublished = "not published";

constexpr int iterations = 100;
constexpr double along_y_deg = 90;

Cell rolled(const char* name, double direction_deg) try {
  const catalogue::Method* const method = here(name, rolling::scene(direction_deg, iterations));
  if (method == nullptr) return Missing{not_here};
  const double error = rolling::error(*method, direction_deg, iterations);
  return finite_cell(std::isfinite(error) ? std::optional(error) : none);
} catch (const UserError& error) {  // DART has friction of things, not of pairs
  return Missing{error.what()};
}

}  // namespace

Content benchmarks(Laboratory& laboratory, Findings& findings) {
  report::Table bounce{.name = "bench-bouncing", .columns = {"method", "published, J²", "here, J²"}};
  report::Table stack{.name = "bench-pile", .columns = {"method", "published, m²", "here, m²", "CPU time here, s"}};
  report::Table direction{.name = "bench-rolling",
                          .columns = {"method", "published, along y, m²/s²", "here, m²/s²",
                                      "published, at 60 degrees, m²/s²", "here, m²/s²"}};
  catalogue::Evaluator balls(without_erp(laboratory.scenario("bouncing_balls")));
  const Scenario crowd = without_erp(pile());
  for (const Published& row : published) {
    const std::string name = row.method;
    const catalogue::Method* const method = here(row.method, balls.scenario());
    bounce.rows.push_back({name, cell_of(row.bouncing, unpublished),
                           method != nullptr ? finite_cell(bouncing(balls, *method)) : Cell(Missing{not_here})});
    // The fourth-order step resolves every impact of the pile, and MuJoCo's solver takes minutes.
    const bool tried =
        method != nullptr && (name.starts_with("ode-step") || name.starts_with("ode-q") || name.starts_with("bullet"));
    const auto [mean, seconds] = tried ? piled(crowd, *method) : std::pair{std::optional(0.0), 0.0};
    const Missing too_long{"not in this build, or too long for a report"};
    stack.rows.push_back({name, cell_of(row.pile, unpublished), tried ? finite_cell(mean) : Cell(too_long),
                          tried ? Cell(seconds) : Cell(too_long)});
    direction.rows.push_back({name, cell_of(row.along, unpublished), rolled(row.method, along_y_deg),
                              cell_of(row.diagonal, unpublished), rolled(row.method, 60)});
  }
  Content content;
  const int few = OdeSettings{}.iterations;
  const catalogue::Method& quick = catalogue::find_method("ode-quickstep-double");
  const rolling::QuickStep errors{rolling::error(quick, along_y_deg, iterations),
                                  rolling::error(quick, along_y_deg, few),
                                  rolling::error(quick, along_y_deg, iterations, rolling::light)};
  findings.add("bench.rolling_quickstep", measured("error of QuickStep's rolling scene along y", "m²/s²", errors.led));
  findings.add("bench.rolling_quickstep_light",
               measured("the same with light sliders on a lever", "m²/s²", errors.light_lead));
  content.values = {{"iterations", iterations},
                    {"balls", rolling::balls},
                    {"box", rolling::box_kg},
                    {"ball", rolling::ball_kg},
                    {"force", rolling::force_N},
                    {"of_ground", rolling::of_ground},
                    {"of_balls", rolling::of_balls},
                    {"until", rolling::duration_s},
                    {"step", 1e3 * rolling::step_s},
                    {"slider", rolling::Lead{}.slider_kg},
                    {"quickstep", rolling::about(errors, iterations, few)}};
  content.exhibits.emplace_back(std::move(bounce));
  content.exhibits.emplace_back(std::move(stack));
  content.exhibits.emplace_back(std::move(direction));
  return content;
}

}  // namespace odeval::experiments
