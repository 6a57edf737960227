// How an error of the start grows: claim C10, Figure 5.14.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"
#include "reference/reference_solution.hpp"
#include "reference/sensitivity.hpp"

namespace odeval::experiments {
namespace {

constexpr double delta_rad = 0.006;  // report, 5.7.3
constexpr double parted_rad = 0.5;   // visible in a plot of several radians
constexpr double look_s = 6;

std::size_t row_at(const Column& t, double time) { return rows_between(t, 0, time).end - 1; }

}  // namespace

Content sensitivity(Laboratory& laboratory, Findings& findings) {
  catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  const Reference& reference = evaluator.reference();
  const Column& t = reference.trace.t;
  Scenario perturbed = evaluator.scenario();
  change_planar(perturbed, [](PlanarView& view) {
    for (double& q : view.q0) q += delta_rad;
  });
  const Reference other = reference::solve_reference(perturbed, evaluator.grid());
  const reference::Sensitivity motion = reference::solve_sensitivity(evaluator.scenario(), evaluator.grid());

  Column separation(t.size());
  Column predicted(t.size());
  double parts_at = INFINITY;
  for (std::size_t k = 0; k < t.size(); ++k) {
    separation[k] = std::fabs(other.trace.q[1][k] - reference.trace.q[1][k]);
    // Row of q2 in the 4 x 4 matrix of transition, columns of q1 and q2.
    predicted[k] = std::fabs(motion.transition[k][4] + motion.transition[k][5]) * delta_rad;
    if (separation[k] > parted_rad && parts_at == INFINITY) parts_at = t[k];
  }
  const double growth = motion.growth[row_at(motion.t, look_s)];
  findings.add("C10.perturbed_parts_at",
               measured(fmt::format("first time at which {} rad more in q1 and q2 at the start move q2 by {} rad",
                                    delta_rad, parted_rad),
                        "s", parts_at, evaluator.grid().step_s));
  findings.add("C10.growth_at_6s",
               measured("growth of the worst small error of the start until 6 s (largest singular value)", "", growth));

  const catalogue::Evaluation& ode = *laboratory.run("double_pendulum", "ode-step-double");
  report::Panel angles{.x_label = "t, s", .y_label = "q2, rad"};
  angles.series = {curve("as given", t, reference.trace.q[1]),
                   curve(fmt::format("{} rad off at the start", delta_rad), t, other.trace.q[1], -1, true)};
  report::Panel apart{.x_label = "t, s", .y_label = "separation of q2, rad", .log_y = true};
  apart.series = {curve("measured", t, above_zero(separation)),
                  curve("predicted by the sensitivities", t, above_zero(predicted), -1, true),
                  curve("error of ode-step-double", ode.trace.t, above_zero(largest_error(ode.trace)),
                        colour_of("ode-step-double"))};
  if (std::isfinite(parts_at)) {
    angles.shade = apart.shade = report::Shade{
        parts_at, fmt::format("q2 of the two runs is more than {} rad apart: they are different motions, and a linear "
                              "prediction no longer holds",
                              parted_rad)};
  }
  report::Panel factor{.x_label = "t, s", .y_label = "growth factor", .log_y = true};
  factor.series = {curve("largest singular value", motion.t, above_zero(motion.growth))};
  report::Panel exponent{.x_label = "t, s", .y_label = "finite-time Lyapunov exponent, 1/s"};
  exponent.series = {curve("ln(growth) / t", motion.t, motion.exponent)};

  report::Table table{
      .name = "sensitivity",
      .columns = {"t, s", "growth factor", "Lyapunov exponent, 1/s", "separation of q2, rad", "predicted, rad"}};
  for (const double time : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0}) {
    if (time > t.back()) continue;
    const std::size_t k = row_at(t, time);
    table.rows.push_back({time, motion.growth[k], motion.exponent[k], separation[k], predicted[k]});
  }

  Content content;
  content.values = {{"delta", delta_rad}, {"growth", shown(growth)}, {"until", look_s}};
  content.exhibits.emplace_back(
      report::Figure{.name = "fig-5-14",
                     .panels = {std::move(angles), std::move(apart), std::move(factor), std::move(exponent)},
                     .columns = 2});
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
