// What ODE makes of restitution: delivered at an impact, left after many, at rest, and kept by 49 balls.
#include <fmt/format.h>

#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Panel;

constexpr std::string_view big_matrix = "ode-step-double";
constexpr double steps[] = {1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2};
constexpr double mixings[] = {1e-10, 1e-6, 1e-5, 1e-4};

struct First {
  Impact impact{};
  double delivered = NAN;
};

/// The first impact of the scenario.
First first_impact(Scenario scenario) {
  const double height =
      scenario.mechanism.bodies.front().position_m[2] - sides_m(scenario.mechanism.bodies.front().shape)[2] / 2;
  scenario.duration_s = std::sqrt(2 * height / scenario.gravity) + 2 * scenario.step_s;
  scenario.sample_s.reset();
  const Evaluation run = Evaluator(scenario).evaluate(*available(big_matrix));
  if (run.outcome.impacts.empty()) return {};
  const Impact& impact = run.outcome.impacts.front();
  return {impact, -impact.qd_after / impact.qd_before};
}

/// Of one row in a step: the force mixing F adds cfm F to the rate asked for.
double predicted(const Scenario& scenario) {
  const double mixed = scenario.ode.cfm * scenario.mechanism.bodies.front().mass_kg / scenario.step_s;
  return std::fmax((scenario.restitution() - mixed) / (1 + mixed), -1);
}

void delivered(const Scenario& scenario, Content& content, Findings& findings) {
  report::Table table{
      .name = "bouncing-delivered",
      .columns = {"h, s", "ERP", "CFM", "mass, kg", "speed, m/s", "overlap, m", "asked for", "delivered"}};
  const auto add = [&](const Scenario& changed) {
    const First first = first_impact(changed);
    table.rows.push_back({changed.step_s, changed.ode.erp, changed.ode.cfm, changed.mechanism.bodies[0].mass_kg,
                          -first.impact.qd_before, first.impact.depth, changed.restitution(), first.delivered});
    return first.delivered;
  };
  Panel by_step{.title = "over the step", .x_label = "h, s", .y_label = "restitution delivered", .log_x = true};
  std::size_t number = 0;
  for (const double cfm : mixings) {
    report::Series measured_series{fmt::format("CFM {:g}", cfm), {}, {}, report::Mark::points, variant(number)};
    report::Series law{"", {}, {}, report::Mark::line, variant(number++), true};
    for (const double step : steps) {
      Scenario changed = scenario;
      changed.step_s = step;
      changed.ode.cfm = cfm;
      measured_series.x.push_back(step);
      measured_series.y.push_back(add(changed));
      law.x.push_back(step);
      law.y.push_back(predicted(changed));
    }
    by_step.series.push_back(std::move(measured_series));
    by_step.series.push_back(std::move(law));
  }
  Panel by_asked{
      .title = "over what is asked for", .x_label = "restitution asked for", .y_label = "restitution delivered"};
  for (const double erp : {0.2, 0.8}) {
    report::Series series{fmt::format("ERP {}", erp), {}, {}, report::Mark::line_and_points};
    for (const double asked : {0.0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0}) {
      Scenario changed = scenario;
      changed.mechanism.contacts.front().restitution = asked;
      changed.ode.erp = erp;
      series.x.push_back(asked);
      series.y.push_back(add(changed));
    }
    by_asked.series.push_back(std::move(series));
  }
  for (const double height : {0.01, 0.1, 10.0}) {  // the speed of the impact
    Scenario changed = scenario;
    changed.mechanism.bodies[0].position_m[2] = sides_m(changed.mechanism.bodies[0].shape)[2] / 2 + height;
    add(changed);
  }
  Scenario heavy = scenario;
  heavy.ode.cfm = 1e-5;
  heavy.mechanism.bodies[0].mass_kg = 10;
  findings.add("bouncing.restitution_kept",
               measured(fmt::format("restitution delivered over the {} asked for", scenario.restitution()), "",
                        first_impact(scenario).delivered / scenario.restitution()));
  findings.add("bouncing.restitution_heavy",
               measured("the same for 10 kg with the CFM that single precision has by default, 1e-5", "",
                        add(heavy) / scenario.restitution()));

  report::Figure figure{.name = "bouncing-delivered-figure", .columns = 2};
  figure.panels = {std::move(by_step), std::move(by_asked)};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
}

void many(const Scenario& scenario, Content& content) {
  Panel panel{.x_label = "impact", .y_label = "speed over that of the first", .log_y = true};
  Column numbers;
  Column truth;
  for (const double step : {1e-2, 1e-3, 1e-4}) {
    Scenario changed = scenario;
    changed.step_s = step;
    changed.sample_s = 1e-2;
    const Evaluation run = Evaluator(changed).evaluate(*available(big_matrix));
    report::Series series{fmt::format("h = {:g} s", step), {}, {}, report::Mark::line_and_points};
    for (const Impact& impact : run.outcome.impacts) {
      if (series.x.size() == 25) break;
      series.x.push_back(static_cast<double>(series.x.size()) + 1);
      series.y.push_back(impact.qd_before / run.outcome.impacts.front().qd_before);
    }
    if (series.x.size() > numbers.size()) numbers = series.x;
    panel.series.push_back(std::move(series));
  }
  for (const double number : numbers) truth.push_back(std::pow(scenario.restitution(), number - 1));
  panel.series.push_back(curve("Newton's law", numbers, truth, guide_colour, true));
  report::Figure figure{.name = "bouncing-many-figure"};
  figure.panels = {std::move(panel)};
  content.exhibits.emplace_back(std::move(figure));
}

void rest(const Scenario& scenario, Content& content) {
  report::Table table{.name = "bouncing-rest",
                      .columns = {"method", "ERP", "CFM", "slower do not bounce, m/s", "rests from, s",
                                  "largest speed in the last second, m/s", "overlap at the end, m"}};
  double true_rest = NAN;
  for (const char* method :
       {"ode-step-double", "ode-step-single", "ode-quickstep-double", "ode-quickstep-single", "ode-rk4-double"}) {
    for (const auto& [cfm, bounce_vel] : {std::pair{1e-10, 0.0}, std::pair{1e-10, 0.05}, std::pair{1e-5, 0.0}}) {
      if (std::string_view(method) == "ode-rk4-double" && (cfm != 1e-10 || bounce_vel != 0)) continue;
      Scenario changed = scenario;
      changed.ode.cfm = cfm;
      changed.ode.bounce_vel = bounce_vel;
      const bool has = std::string_view(method) != "ode-rk4-double";
      std::vector<Cell> row{std::string(method), has ? Cell(changed.ode.erp) : Cell("-"), has ? Cell(cfm) : Cell("-"),
                            has ? Cell(bounce_vel) : Cell("-")};
      if (available(method) == nullptr) {
        for (int i = 0; i < 3; ++i) row.emplace_back(report::Missing{"not in this build"});
      } else {
        Evaluator evaluator(changed);
        const Evaluation run = evaluator.evaluate(*available(method));
        true_rest = evaluator.reference().at_rest_from;
        const auto rests = evaluator.measure(run, changed.duration_s)[quantity::rest_time];
        const Column& rate = run.trace.bodies[0].velocity[2];
        double fastest = 0;
        for (std::size_t k = rows_between(run.trace.t, changed.duration_s - 1, changed.duration_s).first;
             k < rate.size(); ++k) {
          fastest = std::max(fastest, std::fabs(rate[k]));
        }
        row.emplace_back(rests ? Cell(*rests) : Cell("never"));
        row.emplace_back(fastest);
        row.emplace_back(run.trace.penetration.back());
      }
      table.rows.push_back(std::move(row));
    }
  }
  content.values.insert(
      {{"rests_from", shown(true_rest)}, {"rest_speed", rest_m_s}, {"duration", scenario.duration_s}});
  content.exhibits.emplace_back(std::move(table));
}

/// Of the first ball.
double deepest(const std::vector<Impact>& impacts) {
  double depth = 0;
  for (const Impact& impact : impacts) depth = std::max(depth, impact.depth);
  return depth;
}

/// Energies of the balls over the steps of the ladder; beyond 1 ms one ball stands for all, which are equal.
void ladder(const Scenario& grid, Content& content, Findings& findings) {
  report::Table table{
      .name = "bouncing-balls",
      .columns = {"method", "ERP", "h, s", "balls", "energy at the start, J", "mean squared energy error, J²",
                  "energy at the end over the start", "largest overlap, m"}};
  Panel panel{.x_label = "h, s", .y_label = "root mean square energy error over energy", .log_x = true, .log_y = true};
  const auto energy = [](const Trace& trace, std::size_t row) { return trace.kinetic[row] + trace.potential[row]; };
  struct Rung {
    std::string_view method;
    double erp;
    double largest;
    double least;
  };
  for (const Rung& rung : {Rung{"ode-step-double", 0.2, 0.1, 1e-5}, Rung{"ode-step-double", 0.0, 0.1, 1e-4},
                           Rung{"ode-quickstep-double", 0.2, 0.1, 1e-3}, Rung{"ode-rk4-double", 0.2, 0.1, 1e-3}}) {
    report::Series series{
        fmt::format("{}{}", rung.method, rung.method == "ode-rk4-double" ? "" : fmt::format(", ERP {}", rung.erp)),
        {},
        {},
        report::Mark::line_and_points};
    for (const double step : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
      if (step > rung.largest || step < rung.least) continue;
      Scenario scenario = grid;
      const bool all = step > 5e-3 && rung.method != "ode-rk4-double";
      const double stands_for = all ? 1 : static_cast<double>(grid.mechanism.bodies.size());
      if (!all) scenario.mechanism.bodies.resize(1);
      scenario.step_s = step;
      scenario.sample_s = 0.1;
      scenario.ode.erp = rung.erp;
      Evaluator evaluator(scenario);
      const Evaluation run = evaluator.evaluate(*available(rung.method));
      const Metrics metrics = evaluator.measure(run, scenario.duration_s);
      const double start = stands_for * energy(run.trace, 0);
      const double rms = stands_for * *metrics[quantity::rms_energy_drift];
      const double last = stands_for * energy(run.trace, run.trace.rows() - 1);
      table.rows.push_back({std::string(rung.method), rung.erp, step,
                            static_cast<double>(scenario.mechanism.bodies.size()), start, rms * rms, last / start,
                            deepest(run.outcome.impacts)});
      series.x.push_back(step);
      series.y.push_back(rms / start);
      if (rung.method == big_matrix && rung.erp == grid.ode.erp && step == 1e-3) {
        findings.add("bouncing.energy_error",
                     measured("root mean square energy error of 49 balls over their energy, dWorldStep at 1 ms", "",
                              rms / start));
      }
    }
    panel.series.push_back(std::move(series));
  }
  report::Figure figure{.name = "bouncing-balls-figure"};
  figure.panels = {std::move(panel)};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
}

}  // namespace

Content bouncing_ball(Laboratory& laboratory, Findings& findings) {
  const Scenario& scenario = laboratory.scenario("bouncing_ball");
  Content content;
  const Body& body = scenario.mechanism.bodies[0];
  const Scenario& grid = laboratory.scenario("bouncing_balls");
  const Body& of_grid = grid.mechanism.bodies[0];
  const double radius = sides_m(of_grid.shape)[2] / 2;
  content.values = {{"restitution", scenario.restitution()},
                    {"mass", body.mass_kg},
                    {"height", shown(body.position_m[2] - sides_m(body.shape)[2] / 2)},
                    {"cfm", grid.ode.cfm},
                    {"balls", grid.mechanism.bodies.size()},
                    {"balls_duration", grid.duration_s},
                    {"balls_mass", of_grid.mass_kg},
                    {"balls_restitution", grid.restitution()},
                    {"radius", shown(radius)},
                    {"drop", shown(of_grid.position_m[2] - radius)}};
  delivered(scenario, content, findings);
  many(scenario, content);
  rest(scenario, content);
  ladder(grid, content, findings);
  return content;
}

}  // namespace odeval::experiments
