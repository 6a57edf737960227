// What CFM does for the system that dWorldStep solves: claim C5.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"
#include "reference/maximal/ode_step_simulation.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Missing;

constexpr double until_s = 3;
constexpr double heavy = 1e6;
constexpr double cfms[] = {0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2};
constexpr double shown_cfms[] = {0, 1e-10, 1e-8, 1e-5, 1e-3};

struct SetUp {
  const char* label;
  Scenario scenario;
  int hinges;  // in the place of each
  catalogue::Method method;
};

/// Rows that say the same, which only CFM keeps apart. Tables show the first one's force.
void make_joints_twice(Mechanism& mechanism) {
  std::vector<Joint> joints;
  for (const Joint& joint : mechanism.joints) joints.insert(joints.end(), 2, joint);
  mechanism.joints = std::move(joints);
}

/// dWorldStep on the file's pendulum; on one whose first link is heavy, which nearly makes the system singular; and
/// with each hinge made twice, which does.
std::vector<SetUp> set_ups(const Scenario& file) {
  const catalogue::Method step = *available("ode-step-double");
  catalogue::Method doubled = step;
  doubled.inverts = SystemMatrix::none;
  std::vector<SetUp> all{{"as in the file", file, 1, step},
                         {"upper link a million times as heavy", file, 1, step},
                         {"every hinge twice", file, 2, doubled}};
  change_planar(all[1].scenario, [](PlanarView& view) { view.links[0].mass_kg *= heavy; });
  make_joints_twice(all[2].scenario.mechanism);
  for (SetUp& one : all) one.scenario.duration_s = until_s;
  return all;
}

reference::SystemSpectrum spectrum(const SetUp& set_up, double cfm) {
  Scenario scenario = set_up.scenario;
  scenario.ode.cfm = cfm;
  return reference::system_spectrum(scenario, set_up.hinges);
}

/// Decimal digits that a solution may keep of the 16 of a double.
double digits_left(double condition) {
  return std::max(0.0, -std::log10(std::numeric_limits<double>::epsilon() * condition));
}

double digits_regained(const SetUp& set_up, double cfm) {
  return digits_left(spectrum(set_up, cfm).condition()) - digits_left(spectrum(set_up, 0).condition());
}

report::Figure figure(const std::vector<SetUp>& all) {
  report::Panel panel{.x_label = "CFM", .y_label = "condition number", .log_x = true, .log_y = true};
  for (std::size_t i = 0; i < all.size(); ++i) {
    report::Series series{all[i].label, {}, {}, report::Mark::line_and_points, variant(i)};
    for (const double cfm : cfms) {
      if (cfm == 0) continue;
      series.x.push_back(cfm);
      series.y.push_back(spectrum(all[i], cfm).condition());
    }
    panel.series.push_back(std::move(series));
  }
  panel.series.push_back({"no digit of a double is left",
                          {cfms[1], cfms[std::size(cfms) - 1]},
                          {1 / std::numeric_limits<double>::epsilon(), 1 / std::numeric_limits<double>::epsilon()},
                          report::Mark::line,
                          guide_colour,
                          true});
  return {.name = "conditioning-figure", .panels = {std::move(panel)}};
}

/// What dWorldStep makes of it.
struct Run {
  bool finished;
  std::string how;  // when not
  double error;     // rad
  double gap;       // m
};

Run run_of(const SetUp& set_up, Evaluator& evaluator, double cfm) {
  OdeSettings ode = set_up.scenario.ode;
  ode.cfm = cfm;
  const Evaluation run = evaluator.evaluate(set_up.method, ode);
  if (run.outcome.diverged) return {false, run.outcome.reason, NAN, NAN};
  const Metrics metrics = evaluator.measure(run, until_s);
  return {true, "", metrics[quantity::max_error_q].value_or(NAN), metrics[quantity::max_gap].value_or(NAN)};
}

std::vector<Cell> row_of(const SetUp& set_up, double cfm, double condition, const Run& run) {
  const Missing given_up{"ODE gave up"};
  std::vector<Cell> row{std::string(set_up.label), cfm};
  row.push_back(std::isfinite(condition) ? Cell(condition) : Cell(Missing{"singular to rounding"}));
  row.emplace_back(digits_left(condition));
  row.push_back(run.finished ? Cell(run.error) : Cell(given_up));
  row.push_back(run.finished ? Cell(run.gap) : Cell(given_up));
  row.emplace_back(run.finished ? std::string("done") : run.how);
  return row;
}

}  // namespace

Content conditioning(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("double_pendulum");
  const std::vector<SetUp> all = set_ups(file);
  const SetUp& single = all[0];
  const SetUp& near_singular = all[1];
  const SetUp& redundant = all[2];

  report::Table table{
      .name = "conditioning",
      .columns = {"set-up", "CFM", "condition number", "digits left of 16", "angle error, rad", "gap, m", "run"}};
  std::string without;
  double error_single = NAN;
  double error_redundant = NAN;
  double uncertainty = NAN;
  for (const SetUp& set_up : all) {
    Evaluator evaluator(set_up.scenario);
    for (const double cfm : shown_cfms) {
      const double condition = spectrum(set_up, cfm).condition();
      const Run run = run_of(set_up, evaluator, cfm);
      table.rows.push_back(row_of(set_up, cfm, condition, run));
      if (&set_up == &redundant && cfm == 0) without = run.finished ? "it goes on by luck" : run.how;
      if (cfm == file.ode.cfm && &set_up == &single) {
        error_single = run.error;
        uncertainty = *std::ranges::max_element(evaluator.reference().uncertainty_q);
      }
      if (cfm == file.ode.cfm && &set_up == &redundant) error_redundant = run.error;
    }
  }
  const std::string at = fmt::format("CFM {} instead of 0", file.ode.cfm);
  findings.add("C5.digits_regained", measured("digits that solving keeps with " + at + ", every hinge made twice", "",
                                              digits_regained(redundant, file.ode.cfm)));
  findings.add("conditioning.near_singular_digits",
               measured("the same, upper link a million times as heavy and no hinge twice", "",
                        digits_regained(near_singular, file.ode.cfm)));
  findings.add("C5.error_ratio",
               measured_ratio(fmt::format("angle error until {} s with every hinge twice over that with each once, CFM "
                                          "{}",
                                          until_s, file.ode.cfm),
                              error_redundant, error_single, uncertainty, uncertainty));

  Content content;
  content.values = {{"until", until_s},
                    {"step", file.step_s},
                    {"ends", without},
                    {"cfm", file.ode.cfm},
                    {"heavy_mass", near_singular.scenario.planar->links[0].mass_kg},
                    {"sag", shown(file.ode.cfm * file.step_s / file.ode.erp *
                                  (near_singular.scenario.planar->links[0].mass_kg +
                                   near_singular.scenario.planar->links[1].mass_kg) *
                                  file.gravity)}};
  content.exhibits.emplace_back(figure(all));
  content.exhibits.emplace_back(table);
  return content;
}

}  // namespace odeval::experiments
