// The single pendulum beside the double one: claim C17.
#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

constexpr const char* shown_methods[] = {"ode-step-double", "ode-rk4-double", "lagrange-ode45", "lagrange-euler"};
constexpr double early_s = 1;
constexpr double late_s = 10;

// Beside the file's own, which nobody would tell from it.
constexpr double nearby_erps[] = {0.19, 0.21};
constexpr double nearby_steps[] = {0.99, 1.01};  // of the step

/// How much the error of dWorldStep grows from early to late.
double growth_at(const Scenario& file, double step_factor, double erp) {
  Scenario scenario = file;
  scenario.step_s *= step_factor;
  scenario.ode.erp = erp;
  catalogue::Evaluator evaluator(scenario);
  const catalogue::Evaluation run = evaluator.evaluate(*available("ode-step-double"));
  return error_until(evaluator, run, late_s) / error_until(evaluator, run, early_s);
}

/// Of the double over the single pendulum, at settings beside the files' own.
std::vector<double> ratios_nearby(Laboratory& laboratory) {
  const Scenario& one = laboratory.scenario("single_pendulum");
  const Scenario& two = laboratory.scenario("double_pendulum");
  std::vector<double> ratios;
  for (const double erp : nearby_erps) ratios.push_back(growth_at(two, 1, erp) / growth_at(one, 1, erp));
  for (const double factor : nearby_steps)
    ratios.push_back(growth_at(two, factor, two.ode.erp) / growth_at(one, factor, one.ode.erp));
  return ratios;
}

}  // namespace

Content single_pendulum(Laboratory& laboratory, Findings& findings) {
  report::Table table{.name = "single-pendulum",
                      .columns = {"scenario", "error until 1 s, rad", "uncertainty of the reference at 1 s, rad",
                                  "until 10 s, rad", "at 10 s, rad", "growth"}};
  double growth[2] = {};
  double uncertainty[2] = {};
  const char* const scenarios[] = {"single_pendulum", "double_pendulum"};
  for (std::size_t s = 0; s < 2; ++s) {
    catalogue::Evaluator& evaluator = laboratory.evaluator(scenarios[s]);
    const catalogue::Evaluation& run = *laboratory.run(scenarios[s], "ode-step-double");
    const double early = error_until(evaluator, run, early_s);
    const double late = error_until(evaluator, run, late_s);
    growth[s] = late / early;
    uncertainty[s] =
        (uncertainty_until(evaluator, run, late_s) + growth[s] * uncertainty_until(evaluator, run, early_s)) / early;
    table.rows.push_back({std::string(scenarios[s]), early, uncertainty_until(evaluator, run, early_s), late,
                          uncertainty_until(evaluator, run, late_s), growth[s]});
  }
  findings.add("C17.growth_ratio",
               among(measured_ratio("growth of dWorldStep's error from 1 s to 10 s: double over single pendulum",
                                    growth[1], growth[0], uncertainty[1], uncertainty[0]),
                     ratios_nearby(laboratory)));

  report::Panel panel{.x_label = "t, s", .y_label = "error, rad", .log_y = true};
  for (const char* method : shown_methods) {
    const catalogue::Evaluation& run = *laboratory.run("single_pendulum", method);
    panel.series.push_back(curve(method, run.trace.t, above_zero(largest_error(run.trace)), colour_of(method)));
  }
  panel.shade =
      lost_shade(laboratory.evaluator("single_pendulum"), *laboratory.run("single_pendulum", "ode-step-double"));
  const Reference& reference = laboratory.evaluator("single_pendulum").reference();
  panel.series.push_back(uncertainty_curve(reference.trace.t, reference.uncertainty_q));

  Content content;
  content.values = {
      {"early", early_s}, {"late", late_s}, {"single_growth", shown(growth[0])}, {"double_growth", shown(growth[1])}};
  content.exhibits.emplace_back(report::Figure{.name = "single-pendulum-errors", .panels = {std::move(panel)}});
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
