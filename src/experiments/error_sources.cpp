// Where ODE's error comes from: its parts, each measured by changing one thing.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "measure/cartesian_trace.hpp"
#include "model/generate.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Missing;

constexpr double until_s = 1;
constexpr std::string_view step = "ode-step-double";
constexpr std::string_view quick = "ode-quickstep-double";

/// The largest difference of an angle at rows that both have, rad.
double apart(const Trace& a, const Trace& b) {
  const std::size_t rows = std::min(a.rows(), b.rows());
  double largest = a.rows() == b.rows() ? 0 : INFINITY;
  for (std::size_t i = 0; i < a.q.size(); ++i) {
    for (std::size_t k = 0; k < rows; ++k) largest = std::max(largest, std::fabs(a.q[i][k] - b.q[i][k]));
  }
  return largest;
}

/// The rates after one step of a method from a state.
std::vector<double> one_step(Scenario scenario, const Trace& from, std::size_t row, std::string_view method) {
  change_planar(scenario, [&](PlanarView& view) {
    for (std::size_t i = 0; i < from.q.size(); ++i) {
      view.q0[i] = from.q[i][row];
      view.qd0[i] = from.qd[i][row];
    }
  });
  scenario.sample_s.reset();
  scenario.duration_s = scenario.step_s;
  const SampleGrid grid = sample_grid(scenario);
  const std::unique_ptr<Simulation> simulation = available(method)->make(scenario, grid);
  Motion motion(simulation->shape(), static_cast<std::size_t>(grid.rows));
  simulation->run(Recorder(motion));
  const Trace trace = cartesian_trace(scenario, grid, motion);
  std::vector<double> rates;
  for (const Column& column : trace.qd) rates.push_back(column.back());
  return rates;
}

/// What the iteration leaves unsolved in one step, as an acceleration, rad/s², the largest along the reference's path.
double residual_of_iteration(const Scenario& scenario, const Trace& path) {
  double largest = 0;
  constexpr std::size_t states = 20;
  for (std::size_t s = 0; s < states; ++s) {
    const std::size_t row = s * (path.rows() - 1) / (states - 1);
    const std::vector<double> direct = one_step(scenario, path, row, step);
    const std::vector<double> iterated = one_step(scenario, path, row, quick);
    for (std::size_t i = 0; i < direct.size(); ++i) {
      largest = std::max(largest, std::fabs(iterated[i] - direct[i]) / scenario.step_s);
    }
  }
  return largest;
}

struct Part {
  std::string name;
  std::string measured_as;
  std::optional<double> value;
  std::string unit = "rad";
};

std::vector<Part> parts_of(Evaluator& evaluator) {
  const Scenario& scenario = evaluator.scenario();
  const Evaluation whole = evaluator.evaluate(*available(step));
  Scenario halved = scenario;
  halved.step_s /= 2;
  halved.sample_s = scenario.sample_s.value_or(scenario.step_s);
  const Evaluation fine = Evaluator(halved, evaluator.reference()).evaluate(*available(step));
  const auto changed = [&](const std::function<void(OdeSettings&)>& change) {
    OdeSettings settings = scenario.ode;
    change(settings);
    return apart(evaluator.evaluate(*available(step), settings).trace, whole.trace);
  };
  const double iteration = apart(evaluator.evaluate(*available(quick)).trace, whole.trace);
  std::optional<double> rounding;
  if (const catalogue::Method* single = available("ode-step-single")) {
    rounding = apart(evaluator.evaluate(*single).trace, whole.trace);
  }
  const Evaluation generalized = evaluator.evaluate(*available("lagrange-symplectic-euler"));
  return {{"all of it", "dWorldStep against the reference", error_until(evaluator, whole, until_s)},
          {"time discretisation", "twice the change when the step is halved: the part of first order",
           2 * apart(fine.trace, whole.trace)},
          {"no extra degrees of freedom", "symplectic Euler in generalized coordinates against the reference",
           error_until(evaluator, generalized, until_s)},
          {"feedback of joint errors", "ERP 1 instead of the file's", changed([](OdeSettings& ode) { ode.erp = 1; })},
          {"joint drift", "ERP 0 instead of the file's: nothing holds the joints together",
           changed([](OdeSettings& ode) { ode.erp = 0; })},
          {"softness of joints", "CFM 0 instead of the file's", changed([](OdeSettings& ode) { ode.cfm = 0; })},
          {"iterative solver, whole run", "QuickStep against dWorldStep", iteration},
          {"iterative solver, one step", "rates of QuickStep and dWorldStep after one step from the same state, over h",
           residual_of_iteration(scenario, evaluator.reference().trace), "rad/s²"},
          {"rounding", "single against double precision", rounding}};
}

}  // namespace

Content error_sources(Laboratory& laboratory, Findings& findings) {
  report::Table table{.name = "error-sources", .columns = {"part", "measured as", "unit", "double pendulum", "chain"}};
  std::array<std::vector<Part>, 2> columns;
  std::array<double, 2> uncertainty{};
  const char* scenarios[] = {"double_pendulum", "chain"};
  for (std::size_t s = 0; s < 2; ++s) {
    Scenario scenario = laboratory.scenario(scenarios[s]);
    scenario.duration_s = until_s;
    Evaluator evaluator(scenario);
    columns[s] = parts_of(evaluator);
    uncertainty[s] = evaluator.reference().uncertainty_q.back();
  }
  const auto cell = [](const Part& part) -> Cell {
    if (!part.value) return Missing{"this build has no single precision"};
    if (!std::isfinite(*part.value)) return Missing{"the run blew up"};
    return *part.value;
  };
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    const Part& part = columns[0][i];
    table.rows.push_back({part.name, part.measured_as, part.unit, cell(part), cell(columns[1][i])});
  }
  table.rows.push_back({std::string("what the reference may itself be off by"), std::string("its stated bound"),
                        std::string("rad"), uncertainty[0], uncertainty[1]});
  const auto without_joints = [&](std::size_t s) { return shown(*columns[s][2].value / *columns[s][0].value); };
  for (std::size_t s = 0; s < 2; ++s) {
    findings.add(
        fmt::format("sources.discretisation_share_{}", scenarios[s]),
        measured_ratio(fmt::format("first-order part of dWorldStep's error over all of it, {}", scenarios[s]),
                       columns[s][1].value.value(), columns[s][0].value.value(), uncertainty[s], uncertainty[s]));
  }
  Content content;
  content.values = {{"until", until_s},
                    {"links", laboratory.scenario("chain").planar->links.size()},
                    {"step", laboratory.scenario("chain").step_s},
                    {"erp", laboratory.scenario("chain").ode.erp},
                    {"cfm", laboratory.scenario("chain").ode.cfm},
                    {"double_pendulum", without_joints(0)},
                    {"chain", without_joints(1)}};
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
