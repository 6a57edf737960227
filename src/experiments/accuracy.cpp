// Which method follows which, and for how long: the report's Figure 5.13 and claim C9.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/answer_runs.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Figure;
using report::Panel;
using report::Table;

constexpr std::string_view scenario_name = "double_pendulum";
constexpr std::string_view compared[] = {"ode-step-double", "lagrange-euler", "lagrange-ode45"};
constexpr double claimed_until_s = 6;
constexpr double visible_rad = 0.5;  // two curves of the report's Figure 5.13, 15 rad high, part for the eye

/// Root mean square of the differences of all angles until a time, rad.
double rms_apart(const Trace& a, const Trace& b, double until_s) {
  const Span rows = rows_between(a.t, 0, until_s);
  double squares = 0;
  for (std::size_t i = 0; i < a.q.size(); ++i) {
    for (std::size_t k = rows.first; k < rows.end; ++k) squares += std::pow(a.q[i][k] - b.q[i][k], 2);
  }
  return std::sqrt(squares / static_cast<double>(a.q.size() * (rows.end - rows.first)));
}

/// The first sample where any angle differs by more; nothing if none does.
std::optional<double> parts_at(const Trace& a, const Trace& b, double by_rad) {
  const std::size_t rows = std::min(a.rows(), b.rows());
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < a.q.size(); ++i) {
      if (!(std::fabs(a.q[i][k] - b.q[i][k]) <= by_rad)) return a.t[k];
    }
  }
  return std::nullopt;
}

Figure angles(Evaluator& evaluator, const std::vector<const Evaluation*>& runs) {
  const Trace& truth = evaluator.reference().trace;
  const auto shade = all_lost(evaluator, runs);
  Figure figure{.name = "fig-5-13"};
  for (std::size_t i = 0; i < truth.q.size(); ++i) {
    Panel panel{.x_label = "t, s", .y_label = fmt::format("q{}, rad", i + 1), .shade = shade};
    panel.series.push_back(curve("reference", truth.t, truth.q[i], colour_of(catalogue::reference_method), true));
    for (const Evaluation* run : runs) {
      const std::string name(run->method->name);
      panel.series.push_back(curve(name, run->trace.t, run->trace.q[i], colour_of(name)));
    }
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure errors(Evaluator& evaluator, const std::vector<const Evaluation*>& runs) {
  const Reference& reference = evaluator.reference();
  Figure figure{.name = "accuracy-errors"};
  Panel panel{.x_label = "t, s", .y_label = "error, rad", .log_y = true, .shade = all_lost(evaluator, runs)};
  for (const Evaluation* run : runs) {
    const std::string name(run->method->name);
    panel.series.push_back(curve(name, run->trace.t, above_zero(largest_error(run->trace)), colour_of(name)));
  }
  panel.series.push_back(uncertainty_curve(reference.trace.t, reference.uncertainty_q));
  const double end = reference.trace.t.back();
  panel.series.push_back(curve(fmt::format("lost: {} rad", divergence_rad), {0, end}, {divergence_rad, divergence_rad},
                               guide_colour, true));
  figure.panels.push_back(std::move(panel));
  return figure;
}

Table losses(Evaluator& evaluator, const std::vector<const Evaluation*>& runs, const Trace& ode45) {
  Table table{.name = "accuracy",
              .columns = {"method", "error until 1 s, rad", "error until 3 s, rad", "lost at, s",
                          fmt::format("distance from ode45 until {} s (rms), rad", claimed_until_s),
                          fmt::format("parts from ode45 by {} rad at, s", visible_rad)}};
  for (const Evaluation* run : runs) {
    const Metrics whole = evaluator.measure(*run, evaluator.scenario().duration_s);
    const std::optional<double> apart = parts_at(run->trace, ode45, visible_rad);
    const bool itself = &run->trace == &ode45;
    table.rows.push_back({std::string(run->method->name), error_until(evaluator, *run, 1),
                          error_until(evaluator, *run, 3),
                          whole[quantity::divergence_time] ? Cell(*whole[quantity::divergence_time]) : Cell("not lost"),
                          itself ? Cell("itself") : Cell(rms_apart(run->trace, ode45, claimed_until_s)),
                          itself  ? Cell("itself")
                          : apart ? Cell(*apart)
                                  : Cell("never")});
  }
  return table;
}

}  // namespace

Content accuracy(Laboratory& laboratory, Findings& findings) {
  Evaluator& evaluator = laboratory.evaluator(std::string(scenario_name));
  std::vector<const Evaluation*> runs;
  for (const std::string_view name : compared) {
    runs.push_back(laboratory.run(std::string(scenario_name), name));
  }
  const Trace& ode = runs[0]->trace;
  const Trace& euler = runs[1]->trace;
  const Trace& ode45 = runs[2]->trace;
  const double step = evaluator.grid().step_s;

  const double ode_apart = rms_apart(ode, ode45, claimed_until_s);
  const double euler_apart = rms_apart(euler, ode45, claimed_until_s);
  findings.add("C9.distance_ratio",
               measured_ratio(fmt::format("distance of ODE from ode45 over distance of Euler from ode45, until {} s",
                                          claimed_until_s),
                              ode_apart, euler_apart));
  const std::optional<double> parted = parts_at(ode, ode45, visible_rad);
  const std::string meaning = fmt::format("first time that ODE differs from ode45 by more than {} rad", visible_rad);
  findings.add("C9.ode_parts_at", parted ? known_by(report::Source::step, measured(meaning, "s", *parted, step))
                                         : unavailable(meaning, "s", "they stay together to the end"));

  const auto lost_at = [&](const Evaluation* run) {
    const auto time = evaluator.measure(*run, evaluator.scenario().duration_s)[quantity::divergence_time];
    return time ? "at " + shown(*time) + " s" : std::string("never");
  };
  Content content;
  const double cfm = evaluator.scenario().ode.cfm;
  const double default_cfm = answers::cfms.front();
  content.values = {{"other_cfm", cfm != default_cfm},
                    {"cfm", cfm},
                    {"default_cfm", default_cfm},
                    {"known", reference_known(evaluator, {1, 3, evaluator.scenario().duration_s})},
                    {"claimed_until", claimed_until_s},
                    {"lost", divergence_rad},
                    {"ode_lost", lost_at(runs[0])},
                    {"ode45_lost", lost_at(runs[2])},
                    {"euler_lost", lost_at(runs[1])}};
  content.exhibits.emplace_back(angles(evaluator, runs));
  content.exhibits.emplace_back(errors(evaluator, runs));
  content.exhibits.emplace_back(losses(evaluator, runs, ode45));
  return content;
}

}  // namespace odeval::experiments
