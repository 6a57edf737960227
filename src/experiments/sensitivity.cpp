// How an error of the start grows: claim C10, Figure 5.14.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"
#include "reference/planar/reference_solution.hpp"
#include "reference/planar/sensitivity.hpp"

namespace odeval::experiments {
namespace {

constexpr double delta_rad = 0.006;  // report, 5.7.3
constexpr double parted_rad = 0.5;   // visible in a plot of several radians
constexpr double look_s = 6;

std::size_t row_at(const Column& t, double time) { return rows_between(t, 0, time).end - 1; }

/// The double pendulum twice, the second time a little off, and what the sensitivities say of it.
struct Pair {
  const Reference& reference;
  Reference other;
  reference::Sensitivity motion;
  Column separation;  // of q2, rad
  Column predicted;
  double parts_at = INFINITY;  // s

  const Column& t() const { return reference.trace.t; }
};

Pair measure_pair(catalogue::Evaluator& evaluator) {
  Scenario perturbed = evaluator.scenario();
  change_planar(perturbed, [](PlanarView& view) {
    for (double& q : view.q0) q += delta_rad;
  });
  Pair pair{evaluator.reference(),
            reference::solve_reference(perturbed, evaluator.grid()),
            reference::solve_sensitivity(evaluator.scenario(), evaluator.grid()),
            {},
            {}};
  for (std::size_t k = 0; k < pair.t().size(); ++k) {
    pair.separation.push_back(std::fabs(pair.other.trace.q[1][k] - pair.reference.trace.q[1][k]));
    // Row of q2 in the 4 x 4 matrix of transition, columns of q1 and q2.
    const std::vector<double>& transition = pair.motion.transition[k];
    pair.predicted.push_back(std::fabs(transition[4] + transition[5]) * delta_rad);
    if (pair.separation[k] > parted_rad && pair.parts_at == INFINITY) pair.parts_at = pair.t()[k];
  }
  return pair;
}

report::Figure figure_of(const Pair& pair, const catalogue::Evaluation& ode) {
  report::Panel angles{.x_label = "t, s", .y_label = "q2, rad"};
  angles.series = {curve("as given", pair.t(), pair.reference.trace.q[1]),
                   curve(fmt::format("{} rad off at the start", delta_rad), pair.t(), pair.other.trace.q[1], -1, true)};
  report::Panel apart{.x_label = "t, s", .y_label = "separation of q2, rad", .log_y = true};
  apart.series = {curve("measured", pair.t(), above_zero(pair.separation)),
                  curve("predicted by the sensitivities", pair.t(), above_zero(pair.predicted), -1, true),
                  curve("error of ode-step-double", ode.trace.t, above_zero(largest_error(ode.trace)),
                        colour_of("ode-step-double"))};
  if (std::isfinite(pair.parts_at)) {
    angles.shade = apart.shade = report::Shade{
        pair.parts_at,
        fmt::format("q2 of the two runs is more than {} rad apart: they are different motions, and a linear "
                    "prediction no longer holds",
                    parted_rad)};
  }
  report::Panel factor{.x_label = "t, s", .y_label = "growth factor", .log_y = true};
  factor.series = {curve("largest singular value", pair.motion.t, above_zero(pair.motion.growth))};
  report::Panel exponent{.x_label = "t, s", .y_label = "finite-time Lyapunov exponent, 1/s"};
  exponent.series = {curve("ln(growth) / t", pair.motion.t, pair.motion.exponent)};
  return {.name = "fig-5-14",
          .panels = {std::move(angles), std::move(apart), std::move(factor), std::move(exponent)},
          .columns = 2};
}

report::Table table_of(const Pair& pair) {
  report::Table table{
      .name = "sensitivity",
      .columns = {"t, s", "growth factor", "Lyapunov exponent, 1/s", "separation of q2, rad", "predicted, rad"}};
  for (const double time : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0}) {
    if (time > pair.t().back()) continue;
    const std::size_t k = row_at(pair.t(), time);
    table.rows.push_back({time, pair.motion.growth[k], pair.motion.exponent[k], pair.separation[k], pair.predicted[k]});
  }
  return table;
}

}  // namespace

Content sensitivity(Laboratory& laboratory, Findings& findings) {
  catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  const Pair pair = measure_pair(evaluator);
  const double growth = pair.motion.growth[row_at(pair.motion.t, look_s)];
  findings.add(
      "C10.perturbed_parts_at",
      known_by(report::Source::step,
               measured(fmt::format("first time at which {} rad more in q1 and q2 at the start move q2 by {} rad",
                                    delta_rad, parted_rad),
                        "s", pair.parts_at, evaluator.grid().step_s)));
  findings.add(
      "C10.growth_at_6s",
      measured(fmt::format("growth of the worst small error of the start until {} s (largest singular value)", look_s),
               "", growth));

  Content content;
  content.values = {{"delta", delta_rad}, {"growth", shown(growth)}, {"until", look_s}};
  content.exhibits.emplace_back(figure_of(pair, *laboratory.run("double_pendulum", "ode-step-double")));
  content.exhibits.emplace_back(table_of(pair));
  return content;
}

}  // namespace odeval::experiments
