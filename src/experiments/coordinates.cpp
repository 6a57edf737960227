// Cartesian coordinates with feedback beside generalized ones: claim C3.
#include <fmt/format.h>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/spread.hpp"

namespace odeval::experiments {
namespace {

constexpr double until_s = 3;
constexpr const char* compared[] = {"ode-step-double", "maximal-ode-step", "lagrange-symplectic-euler",
                                    "lagrange-euler", "maximal-euler"};

}  // namespace

Section coordinates(Laboratory& laboratory, Findings& findings) {
  catalogue::Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  report::Table table{
      "coordinates",
      "First-order methods in Cartesian and in generalized coordinates",
      {"method", "error until 3 s, rad", "the reference's uncertainty, rad", "condition number, median over the run"},
      {},
      "The condition number (1-norm) is that of the matrix the method inverts in each step."};
  double error[std::size(compared)];
  double doubt[std::size(compared)];
  double condition[std::size(compared)];
  report::Panel panel{.x_label = "t, s", .y_label = "condition number", .log_y = true};
  for (std::size_t i = 0; i < std::size(compared); ++i) {
    const catalogue::Evaluation& run = *laboratory.run("double_pendulum", compared[i]);
    error[i] = error_until(evaluator, run, until_s);
    doubt[i] = uncertainty_until(evaluator, run, until_s);
    condition[i] = median(run.trace.condition);
    table.rows.push_back({std::string(compared[i]), error[i], doubt[i], condition[i]});
    panel.series.push_back(curve(compared[i], run.trace.t, run.trace.condition, colour_of(compared[i])));
  }
  findings.add("C3.error_ratio",
               measured_ratio("error of dWorldStep over that of symplectic Euler in generalized coordinates, until 3 s",
                              error[0], error[2], doubt[0], doubt[2]));
  findings.add("C3.condition_ratio",
               measured_ratio("median condition number of ODE's system matrix over that of the generalized mass matrix",
                              condition[0], condition[2]));
  Section section{"coordinates", "Cartesian or generalized coordinates?", {}};
  section.blocks.emplace_back(
      report::Text{"The report expected more states and a worse conditioned matrix to cost accuracy. Both kinds of "
                   "methods here are of "
                   "first order and take the same steps."});
  section.blocks.emplace_back(std::move(table));
  section.blocks.emplace_back(report::Figure{"coordinates-condition",
                                             "Condition of what each method inverts",
                                             "The larger, the more digits a solution may lose.",
                                             {std::move(panel)},
                                             1});
  return section;
}

}  // namespace odeval::experiments
