// Chains of n links: how error, conditioning and cost grow with the number of states. The other half of claim C3.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "catalogue/timing.hpp"
#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/order.hpp"
#include "measure/spread.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Missing;
using report::Panel;

constexpr std::size_t error_sizes[] = {2, 4, 8, 16, 32, 64};
constexpr std::size_t cost_sizes[] = {4, 8, 16, 32, 64, 128};
static_assert(std::size(error_sizes) == std::size(cost_sizes));
constexpr double until_s = 1;
constexpr const char* steppers[] = {"ode-step-double", "ode-quickstep-double", "ode-rk4-double",
                                    "lagrange-symplectic-euler"};
constexpr const char* timed[] = {"ode-step-double", "ode-quickstep-double", "ode-rk4-double", "lagrange-cvode"};
constexpr int rounds = 3;

/// What is plotted over n: one value a size.
struct Growth {
  std::string name;
  std::string unit;
  std::vector<ErrorPoint> points;
  int colour = -1;
};

report::Series series_of(const Growth& growth) {
  report::Series series{growth.name, {}, {}, report::Mark::line_and_points, growth.colour};
  for (const ErrorPoint& point : growth.points) {
    series.x.push_back(point.setting);
    series.y.push_back(point.error);
  }
  return series;
}

std::optional<ObservedOrder> exponent(const Growth& growth) { return observed_order(growth.points, 1e300); }

struct Errors {
  std::vector<Growth> errors;      // of the steppers
  std::vector<Growth> conditions;  // generalized, Cartesian with CFM
  report::Table table;
};

Errors measure_errors(const Scenario& file) {
  Errors result;
  result.table = {.name = "chain-errors",
                  .columns = {"n", "dWorldStep, rad", "QuickStep, rad", "fourth-order step, rad",
                              "symplectic Euler, rad", "the reference's uncertainty, rad",
                              "condition of the mass matrix", "condition of ODE's system matrix"}};
  for (const char* stepper : steppers) result.errors.push_back({stepper, "error", {}, colour_of(stepper)});
  result.conditions = {{"generalized: mass matrix", "condition", {}, colour_of("lagrange-cvode")},
                       {"Cartesian: ODE's system matrix", "condition", {}, colour_of("ode-step-double")}};
  for (const std::size_t n : error_sizes) {
    Evaluator evaluator(chain_of(file, n, until_s));
    const double uncertainty = evaluator.reference().uncertainty_q.back();
    std::vector<Cell> row{static_cast<double>(n)};
    double condition[2] = {};
    for (std::size_t i = 0; i < std::size(steppers); ++i) {
      const Evaluation run = evaluator.evaluate(*available(steppers[i]));
      const double error = error_until(evaluator, run, until_s);
      result.errors[i].points.push_back({static_cast<double>(n), error, uncertainty});
      row.push_back(finite_cell(error));
      if (i == 0) condition[1] = median(run.trace.condition);
      if (i == 3) condition[0] = median(run.trace.condition);
    }
    row.emplace_back(uncertainty);
    for (std::size_t c = 0; c < 2; ++c) {
      row.emplace_back(condition[c]);
      result.conditions[c].points.push_back({static_cast<double>(n), condition[c], 0});
    }
    result.table.rows.push_back(std::move(row));
  }
  return result;
}

struct Costs {
  std::vector<Growth> costs;  // s a step; of CVODE: s for 1 s of motion
  report::Table table;
};

// So few steps that the longest chain takes dWorldStep a tenth of a second.
long steps_of(std::size_t n) { return std::max(8L, 1000L / static_cast<long>(n)); }

Costs measure_costs(const Scenario& file) {
  Costs result;
  result.table = {.name = "chain-costs",
                  .columns = {"n", "dWorldStep, s a step", "QuickStep, s a step", "fourth-order step, s a step",
                              "reference (one run of CVODE), s for 1 s of motion"}};
  for (const char* method : timed) result.costs.push_back({method, "cost", {}, colour_of(method)});
  for (const std::size_t n : cost_sizes) {
    Scenario steps = chain_of(file, n, until_s);
    steps.sample_s.reset();
    steps.duration_s = static_cast<double>(steps_of(n)) * steps.step_s;
    const Evaluator few(steps);
    const Evaluator whole(chain_of(file, n, until_s));
    std::vector<catalogue::TimedRun> runs;
    for (const char* method : timed) {
      const bool reference = std::string_view(method) == catalogue::reference_method;
      runs.push_back({reference ? &whole : &few, available(method), 0, 0, {}, 1});
    }
    catalogue::time_in_turns(runs, rounds);
    std::vector<Cell> row{static_cast<double>(n)};
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const bool reference = runs[i].evaluator == &whole;
      const double cost = runs[i].median_s() / (reference ? until_s : static_cast<double>(steps_of(n)));
      result.costs[i].points.push_back({static_cast<double>(n), cost, 0});
      row.emplace_back(cost);
    }
    result.table.rows.push_back(std::move(row));
  }
  return result;
}

/// How wrong dWorldStep is about the forces in its joints (dJointFeedback), beside the reference's multipliers.
report::Table joint_forces(Laboratory& laboratory, Findings& findings) {
  report::Table table{.name = "joint-forces",
                      .columns = {"scenario", "CFM", "h, s", "largest force, N", "largest error, N",
                                  "over that at half the step", "out of the plane, m"}};
  for (const char* name : {"double_pendulum", "chain"}) {
    Scenario scenario = laboratory.scenario(name);
    scenario.duration_s = until_s;
    for (const double cfm : {scenario.ode.cfm, 0.0}) {
      scenario.ode.cfm = cfm;
      double finer = NAN;
      std::vector<std::vector<Cell>> rows;
      for (const double step_s : {2.5e-4, 5e-4, 1e-3, 2e-3}) {
        scenario.step_s = step_s;
        Evaluator evaluator(scenario);
        const Evaluation run = evaluator.evaluate(*available("ode-step-double"));
        const Metrics metrics = evaluator.measure(run, until_s);
        double largest = 0;
        for (const auto& [x, y, z] : evaluator.reference().joint_force) {
          for (std::size_t k = 0; k < x.size(); ++k) largest = std::max(largest, std::hypot(x[k], y[k], z[k]));
        }
        const double error = metrics[quantity::max_reaction_error].value_or(NAN);
        rows.push_back({std::string(name), cfm, step_s, largest, error,
                        std::isnan(finer) ? Cell(Missing{"the finest step"}) : Cell(error / finer),
                        metrics[quantity::max_out_of_plane].value_or(NAN)});
        if (step_s == 5e-4) {
          findings.add(fmt::format("chain.force_error_halved_{}{}", name, cfm == 0 ? "_rigid" : ""),
                       measured(fmt::format("error of joint forces at h = {} s over that at half the step, {}, CFM {}",
                                            step_s, name, cfm),
                                "", error / finer));
        }
        finer = error;
      }
      table.rows.insert(table.rows.end(), rows.rbegin(), rows.rend());
    }
  }
  return table;
}

/// Where two costs cross, between sizes by the logarithms; nothing if they do not.
std::optional<double> crossing(const Growth& dear, const Growth& cheap) {
  for (std::size_t i = 1; i < dear.points.size(); ++i) {
    const double before = std::log(dear.points[i - 1].error / cheap.points[i - 1].error);
    const double after = std::log(dear.points[i].error / cheap.points[i].error);
    if (!(before < 0 && after >= 0)) continue;
    const double from = std::log(dear.points[i - 1].setting);
    const double to = std::log(dear.points[i].setting);
    return std::exp(from + (to - from) * before / (before - after));
  }
  return std::nullopt;
}

void add_exponents(report::Table& table, const std::vector<Growth>& growths) {
  for (const Growth& growth : growths) {
    const auto fit = exponent(growth);
    if (fit) {
      table.rows.push_back({growth.name, growth.unit, fit->order, fit->half_width, fit->from, fit->to});
    } else {
      const Missing missing{"too few points"};
      table.rows.push_back({growth.name, growth.unit, missing, missing, missing, missing});
    }
  }
}

void add_finding(Findings& findings, const std::string& name, const std::string& meaning, const Growth& growth) {
  const auto fit = exponent(growth);
  findings.add(name, fit ? known_by(report::Source::fit, measured(meaning, "", fit->order, fit->half_width))
                         : unavailable(meaning, "", "too few runs stayed finite"));
}

}  // namespace

Content chain(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("chain");
  const Errors errors = measure_errors(file);
  const Costs costs = measure_costs(file);
  add_finding(findings, "C3.error_exponent",
              "exponent with which the error of dWorldStep grows with the number of links, 2 to 64, until 1 s",
              errors.errors[0]);
  add_finding(findings, "chain.condition_exponent_generalized",
              "exponent with which the condition of the mass matrix grows with the number of links",
              errors.conditions[0]);
  add_finding(findings, "chain.condition_exponent_cartesian", "the same of ODE's system matrix", errors.conditions[1]);
  const auto overtakes = crossing(costs.costs[0], costs.costs[1]);
  const std::string meaning = fmt::format(
      "number of links from which a step of QuickStep ({} iterations) is cheaper than dWorldStep's, on this machine",
      file.ode.iterations);
  findings.add("chain.quickstep_overtakes",
               overtakes ? measured(meaning, "", *overtakes) : unavailable(meaning, "", "not between 4 and 128 links"));

  report::Table exponents{.name = "chain-exponents",
                          .columns = {"method", "of", "p", "half width (95 %)", "from n", "to n"}};
  add_exponents(exponents, errors.errors);
  add_exponents(exponents, errors.conditions);
  add_exponents(exponents, costs.costs);

  Panel of_errors{.x_label = "links", .y_label = "error until 1 s, rad", .log_x = true, .log_y = true};
  Panel of_conditions{.x_label = "links", .y_label = "condition number", .log_x = true, .log_y = true};
  Panel of_costs{.x_label = "links", .y_label = "CPU time a step, s", .log_x = true, .log_y = true};
  for (const Growth& growth : errors.errors) of_errors.series.push_back(series_of(growth));
  for (const Growth& growth : errors.conditions) of_conditions.series.push_back(series_of(growth));
  for (std::size_t i = 0; i < 3; ++i) of_costs.series.push_back(series_of(costs.costs[i]));

  report::Figure figure{.name = "chain-figure", .columns = 3};
  figure.panels = {std::move(of_errors), std::move(of_conditions), std::move(of_costs)};
  Content content;
  content.values = {{"until", until_s},
                    {"step", file.step_s},
                    {"rows_apart", chain_rows_s},
                    {"rounds", rounds},
                    {"sizes", std::size(error_sizes)},
                    {"iterations", file.ode.iterations},
                    {"overtakes", overtakes ? fmt::format("{}", std::lround(*overtakes)) : ""}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(errors.table);
  content.exhibits.emplace_back(costs.table);
  content.exhibits.emplace_back(std::move(exponents));
  content.exhibits.emplace_back(joint_forces(laboratory, findings));
  return content;
}

}  // namespace odeval::experiments
