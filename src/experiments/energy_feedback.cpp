// Does the feedback of joint errors (ERP) make the energy fluctuate? Claim C8b.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Figure;
using report::Mark;
using report::Panel;

constexpr double steps_s[] = {1e-3, 5e-4, 2.5e-4};
constexpr double erps[] = {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
constexpr double early_s = 3;
constexpr const char* method = "ode-step-double";

struct Run {
  double step_s;
  double erp;
  double cfm;
  double drift_early;  // J, largest
  double drift;        // J, largest over the whole run
  double error_early;  // rad
  double gap;          // m, largest over the whole run
};

std::vector<Run> measure_all(const Scenario& file, const std::vector<double>& cfms) {
  std::vector<Run> runs;
  for (const double step_s : steps_s) {
    Scenario scenario = file;
    scenario.step_s = step_s;
    Evaluator evaluator(scenario);
    for (const double cfm : cfms) {
      for (const double erp : erps) {
        OdeSettings settings = file.ode;
        settings.erp = erp;
        settings.cfm = cfm;
        const Evaluation run = evaluator.evaluate(*available(method), settings);
        const Metrics early = evaluator.measure(run, early_s);
        const Metrics whole = evaluator.measure(run, scenario.duration_s);
        runs.push_back({step_s, erp, cfm, *early[quantity::max_energy_drift], *whole[quantity::max_energy_drift],
                        early[quantity::max_error_q].value_or(NAN), whole[quantity::max_gap].value_or(NAN)});
      }
    }
  }
  return runs;
}

const Run& find(const std::vector<Run>& runs, double step_s, double erp, double cfm) {
  return *std::ranges::find_if(
      runs, [&](const Run& run) { return run.step_s == step_s && run.erp == erp && run.cfm == cfm; });
}

/// One panel a step, one curve a CFM, over ERP.
Figure figure(const std::vector<Run>& runs, const std::vector<double>& cfms) {
  Figure figure{.name = "energy-feedback-figure", .columns = 3};
  struct Row {
    const char* label;
    double Run::*value;
  };
  for (const Row& row : {Row{"largest drift, J", &Run::drift}, Row{"largest drift until 3 s, J", &Run::drift_early},
                         Row{"angle error until 3 s, rad", &Run::error_early}}) {
    for (const double step_s : steps_s) {
      const std::string_view what(row.label);
      Panel panel{.title = fmt::format("{}, h = {} s", what.substr(0, what.find(", ")), step_s),
                  .x_label = "ERP",
                  .y_label = row.label,
                  .log_y = true};
      for (std::size_t c = 0; c < cfms.size(); ++c) {
        report::Series series{fmt::format("CFM {}", cfms[c]), {}, {}, Mark::line_and_points, variant(c)};
        for (const double erp : erps) {
          series.x.push_back(erp);
          series.y.push_back(find(runs, step_s, erp, cfms[c]).*row.value);
        }
        panel.series.push_back(std::move(series));
      }
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

/// A row a step and ERP; the drift for every CFM, the rest for the file's.
report::Table table(const std::vector<Run>& runs, const std::vector<double>& cfms, const Scenario& file) {
  report::Table table{.name = "energy-feedback", .columns = {"h, s", "ERP"}};
  for (const double cfm : cfms) table.columns.push_back(fmt::format("drift with CFM {}, J", cfm));
  const std::string usual = fmt::format(" with CFM {}", file.ode.cfm);
  table.columns.push_back(fmt::format("drift until {} s{}, J", early_s, usual));
  table.columns.push_back(fmt::format("angle error until {} s{}, rad", early_s, usual));
  table.columns.push_back("largest gap in a joint" + usual + ", m");
  for (const double step_s : steps_s) {
    for (const double erp : erps) {
      std::vector<report::Cell> row{step_s, erp};
      for (const double cfm : cfms) row.emplace_back(find(runs, step_s, erp, cfm).drift);
      const Run& run = find(runs, step_s, erp, file.ode.cfm);
      row.insert(row.end(), {run.drift_early, run.error_early, run.gap});
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

}  // namespace

Content energy_feedback(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("double_pendulum");
  std::vector<double> cfms{0, 1e-10, 1e-5, 1e-3};
  if (std::ranges::find(cfms, file.ode.cfm) == cfms.end()) cfms.push_back(file.ode.cfm);
  const std::vector<Run> runs = measure_all(file, cfms);

  std::vector<double> ratios;
  std::vector<report::Values> drifts;
  std::vector<report::Values> errors;
  for (const double step_s : steps_s) {
    const Run& without = find(runs, step_s, 0, 0);
    const Run& with = find(runs, step_s, 0.2, file.ode.cfm);
    ratios.push_back(without.drift / with.drift);
    drifts.push_back({{"without", shown(without.drift)}, {"with", shown(with.drift)}, {"step", step_s}});
    errors.push_back({{"without", shown(without.error_early)}, {"with", shown(with.error_early)}});
  }
  const std::string meaning = fmt::format(
      "largest energy drift in {} s without feedback (ERP 0, CFM 0) over that with "
      "ERP 0.2 and CFM {}: ",
      file.duration_s, file.ode.cfm);
  findings.add("C8b.least_ratio",
               measured(meaning + "the smallest of three step sizes", "", *std::ranges::min_element(ratios)));
  findings.add("C8b.largest_ratio",
               measured(meaning + "the largest of three step sizes", "", *std::ranges::max_element(ratios)));

  Content content;
  content.values = {{"duration", file.duration_s},
                    {"least_erp", erps[0]},
                    {"most_erp", erps[std::size(erps) - 1]},
                    {"cfms", cfms.size()},
                    {"steps", std::size(steps_s)},
                    {"erp", file.ode.erp},
                    {"cfm", file.ode.cfm},
                    {"drifts", drifts},
                    {"early", early_s},
                    {"errors", errors},
                    {"known", reference_known(laboratory.evaluator("double_pendulum"), {early_s})}};
  content.exhibits.emplace_back(figure(runs, cfms));
  content.exhibits.emplace_back(table(runs, cfms, file));
  return content;
}

}  // namespace odeval::experiments
