// Do long thin bodies spin up about their long axis, and why: claim C4.
#include <fmt/format.h>

#include <cmath>

#include "catalogue/keeping.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"
#include "reference/maximal/gyroscopic_rounding.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;

constexpr double aspects[] = {1, 3, 10, 30, 100, 300, 1000, 5000};  // the report's ratio of 1e7 is passed at 4472
constexpr double claimed_ratio = 1e7;  // report, 3.5.3; of a box of square section it is half the squared aspect
constexpr double judged_aspect = 1000;
constexpr double link_aspects[] = {10, 100, 1000};
constexpr double spacing_s = 1e-2;
constexpr double along = 0.5;  // rad/s, of a spin about the length
constexpr double swing_s = 3;  // the double pendulum's own sensitivity takes over later
constexpr const char* thin_methods[] = {"ode-step-single", "ode-step-double", "ode-quickstep-single",
                                        "ode-quickstep-double"};

const char* word(bool gyroscopic) { return gyroscopic ? "on" : "off"; }

double own_spin(const Scenario& scenario) {
  const Vec3& spin = scenario.mechanism.bodies[0].spin_rad_s;
  return std::sqrt(dot(spin, spin));
}

/// The scenario's box, a metre long, with another aspect ratio.
Scenario thinner(Scenario scenario, double aspect) {
  Body& body = scenario.mechanism.bodies[0];
  const double length = sides_m(body.shape)[2];
  body.shape = Box{{length / aspect, length / aspect, length}};
  scenario.sample_s = spacing_s;
  return scenario;
}

/// The same with a spin about its length as well.
Scenario spinning(Scenario scenario, double along_rad_s) {
  const std::size_t axis = scenario.mechanism.bodies[0].long_axis();
  SampleGrid start = sample_grid(scenario);
  start.rows = 1;
  const std::unique_ptr<Simulation> still = available("analytic")->make(scenario, start);
  Motion motion(still->shape(), 1);
  still->run(Recorder(motion));
  Vec3& spin = scenario.mechanism.bodies[0].spin_rad_s;
  spin = spin + along_rad_s * axis_of(motion[0].bodies[0].rotation, axis);
  return scenario;
}

/// A box without any spin about its length, by aspect ratio.
struct SpinUp {
  report::Table table{.name = "thin-body",
                      .columns = {"length : thickness", "ratio of moments", "method", "gyroscopic term",
                                  "spin about its length, rad/s", "over its own spin", "± rad/s", "angle error, rad",
                                  "± rad", "energy drift, J", "angular momentum drift, N m s"}};
  report::Panel panel{.x_label = "length over thickness",
                      .y_label = "spin about its length over its own",
                      .log_x = true,
                      .log_y = true};
};

/// What `add_finding` tells, where rounding decides: at steps that nobody would tell from the file's.
std::vector<double> spins_nearby(const Scenario& thin, const catalogue::Method& method, double own) {
  std::vector<double> spins;
  for (const double percent : catalogue::nearby_percents) {
    const double factor = catalogue::moved(1, percent);
    Scenario scenario = thin;
    scenario.step_s *= factor;
    if (scenario.sample_s) *scenario.sample_s *= factor;
    Evaluator evaluator(scenario);
    const Metrics metrics = evaluator.measure(evaluator.evaluate(method), scenario.duration_s);
    spins.push_back(metrics[quantity::max_long_axis_spin].value_or(NAN) / own);
  }
  return spins;
}

void add_finding(Findings& findings, const std::string& precision, const Metrics* metrics, double own,
                 const std::vector<double>& nearby) {
  const std::string name = "C4.long_axis_spin_" + precision;
  const std::string meaning = fmt::format(
      "spin that a free box 1:{} without any takes up about its length in 10 s, over its own spin, {} precision",
      judged_aspect, precision);
  if (metrics == nullptr) {
    findings.add(name, unavailable(meaning, "", std::string(catalogue::without_single_precision)));
    return;
  }
  findings.add(name, among(measured(meaning, "", *(*metrics)[quantity::max_long_axis_spin] / own,
                                    *(*metrics)[quantity::spin_uncertainty] / own),
                           nearby));
}

SpinUp spin_up(const Scenario& file, Findings& findings) {
  SpinUp result;
  std::map<std::string, report::Series> series;
  for (const double aspect : aspects) {
    Evaluator evaluator(thinner(file, aspect));
    const Scenario& scenario = evaluator.scenario();
    const Vec3 moments = scenario.mechanism.bodies[0].uniform_moments_kgm2();
    const double own = own_spin(scenario);
    for (const char* name : thin_methods) {
      const catalogue::Method* const method = available(name);
      const std::string precision = std::string_view(name).ends_with("single") ? "single" : "double";
      const bool big_matrix = std::string_view(name).starts_with("ode-step");
      for (const bool gyroscopic : {true, false}) {
        const bool judged = aspect == judged_aspect && gyroscopic && big_matrix;
        if (method == nullptr) {
          if (judged) add_finding(findings, precision, nullptr, own, {});
          result.table.rows.push_back(row_left_out(
              {fmt::format("{}", aspect), moments[0] / moments[2], std::string(name), std::string(word(gyroscopic))},
              result.table.columns.size()));
          continue;
        }
        OdeSettings settings = scenario.ode;
        settings.gyroscopic = gyroscopic;
        const Metrics metrics = evaluator.measure(evaluator.evaluate(*method, settings), scenario.duration_s);
        if (judged) add_finding(findings, precision, &metrics, own, spins_nearby(scenario, *method, own));
        const double spin = metrics[quantity::max_long_axis_spin].value_or(NAN);
        result.table.rows.push_back(
            {fmt::format("{}", aspect), moments[0] / moments[2], std::string(name), std::string(word(gyroscopic)),
             finite_cell(spin), finite_cell(spin / own), *metrics[quantity::spin_uncertainty],
             finite_cell(metrics[quantity::max_error_turn]), *metrics[quantity::turn_uncertainty],
             finite_cell(metrics[quantity::max_energy_drift]),
             finite_cell(metrics[quantity::max_angular_momentum_drift])});
        if (!big_matrix) continue;
        const std::string label = fmt::format("{} precision, gyroscopic term {}", precision, word(gyroscopic));
        report::Series& curve = series[label];
        curve.label = label;
        curve.mark = report::Mark::line_and_points;
        curve.colour = colour_of(name);
        curve.dashed = !gyroscopic;
        curve.x.push_back(aspect);
        curve.y.push_back(spin / own);
      }
    }
  }
  for (auto& [label, curve] : series) result.panel.series.push_back(std::move(curve));
  return result;
}

/// A box that does spin about its length: the part that is left.
report::Table spin_kept(const Scenario& file) {
  report::Table table{
      .name = "thin-body-spin",
      .columns = {"length : thickness", "method", "gyroscopic term", "spin about its length after 10 s, rad/s",
                  "± rad/s", "angle error until 10 s, rad", "± rad"}};
  for (const double aspect : {1.0, 10.0, 100.0, 1000.0}) {
    Evaluator evaluator(spinning(thinner(file, aspect), along));
    for (const char* name : {"ode-step-double", "ode-rk4-double"}) {
      for (const bool gyroscopic : {true, false}) {
        if (!gyroscopic && std::string_view(name) == "ode-rk4-double") continue;  // it has no such choice
        OdeSettings settings = evaluator.scenario().ode;
        settings.gyroscopic = gyroscopic;
        const Evaluation run = evaluator.evaluate(*available(name), settings);
        const Metrics metrics = evaluator.measure(run, evaluator.scenario().duration_s);
        table.rows.push_back({fmt::format("{}", aspect), std::string(name), std::string(word(gyroscopic)),
                              finite_cell(run.trace.long_axis_spin[0].back()), *metrics[quantity::spin_uncertainty],
                              finite_cell(metrics[quantity::max_error_turn]), *metrics[quantity::turn_uncertainty]});
      }
    }
  }
  return table;
}

/// Where the digits go: ODE's step rebuilt in single precision, the same torque by other orders of operations.
report::Table orders_of_operations(const Scenario& file) {
  using reference::GyroscopicForm;
  report::Table table{.name = "thin-body-rounding",
                      .columns = {"length : thickness", "in ODE, rad/s", "ODE's order rebuilt, rad/s",
                                  "w* solved for first, rad/s", "w* in the body's axes, rad/s"}};
  const catalogue::Method* const single = available("ode-step-single");
  for (const double aspect : {10.0, 30.0, 100.0, 300.0, 1000.0}) {
    Evaluator evaluator(thinner(file, aspect));
    const Scenario& scenario = evaluator.scenario();
    std::vector<Cell> row{fmt::format("{}", aspect), report::Missing{std::string(catalogue::without_single_precision)}};
    if (single != nullptr) {
      row[1] = finite_cell(
          evaluator.measure(evaluator.evaluate(*single), scenario.duration_s)[quantity::max_long_axis_spin]);
    }
    for (const GyroscopicForm form : {GyroscopicForm::as_ode, GyroscopicForm::solved, GyroscopicForm::in_body_frame}) {
      row.push_back(finite_cell(reference::long_axis_spin_in_single(scenario.mechanism.bodies[0], scenario.step_s,
                                                                    sample_grid(scenario).steps(), form)));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Links a metre long on hinges, thinner and thinner.
report::Table thin_links(Laboratory& laboratory) {
  report::Table table{
      .name = "thin-links",
      .columns = {"scenario", "length : thickness", "method", "gyroscopic term", "spin about its length, rad/s",
                  "out of plane, m", "angle error, rad", "± rad", "energy drift, J"}};
  for (const char* name : {"single_pendulum", "double_pendulum"}) {
    for (const double aspect : link_aspects) {
      Scenario scenario = laboratory.scenario(name);
      scenario.duration_s = swing_s;
      scenario.sample_s = spacing_s;
      change_planar(scenario, [aspect = aspect](PlanarView& view) {
        for (Link& link : view.links) link.width_m = link.depth_m = link.length_m / aspect;
      });
      Evaluator evaluator(scenario);
      for (const char* method_name : thin_methods) {
        const catalogue::Method* const method = available(method_name);
        for (const bool gyroscopic : {true, false}) {
          if (method == nullptr) {
            table.rows.push_back(row_left_out(
                {std::string(name), fmt::format("{}", aspect), std::string(method_name), std::string(word(gyroscopic))},
                table.columns.size()));
            continue;
          }
          OdeSettings settings = scenario.ode;
          settings.gyroscopic = gyroscopic;
          const Metrics metrics = evaluator.measure(evaluator.evaluate(*method, settings), swing_s);
          table.rows.push_back({std::string(name), fmt::format("{}", aspect), std::string(method_name),
                                std::string(word(gyroscopic)), finite_cell(metrics[quantity::max_long_axis_spin]),
                                finite_cell(metrics[quantity::max_out_of_plane]),
                                finite_cell(metrics[quantity::max_error_q]), *metrics[quantity::reference_uncertainty],
                                finite_cell(metrics[quantity::max_energy_drift])});
        }
      }
    }
  }
  return table;
}

}  // namespace

Content thin_body(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("thin_body");
  SpinUp up = spin_up(file, findings);
  report::Figure figure{.name = "thin-body-figure"};
  figure.panels.push_back(std::move(up.panel));
  Content content;
  findings.add("C4.aspect", measured("length over thickness of the box of C4", "", judged_aspect));
  content.values = {{"along", along},
                    {"claimed_ratio", shown(claimed_ratio)},
                    {"claimed_aspect", std::lround(std::sqrt(2 * claimed_ratio))},
                    {"step", file.step_s},
                    {"duration", file.duration_s},
                    {"swing_duration", swing_s},
                    {"own_spin", shown(own_spin(file))},
                    {"left_out", left_out({std::begin(thin_methods), std::end(thin_methods)})}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(up.table));
  content.exhibits.emplace_back(orders_of_operations(file));
  content.exhibits.emplace_back(spin_kept(file));
  content.exhibits.emplace_back(thin_links(laboratory));
  return content;
}

}  // namespace odeval::experiments
