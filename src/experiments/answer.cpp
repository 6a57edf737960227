// The page's first screen: for each kind of task the settings of ODE that keep an error, what they cost, and a film of
// ODE beside the truth until it is lost.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "catalogue/keeping.hpp"
#include "experiments/all.hpp"
#include "experiments/answer_runs.hpp"
#include "experiments/parts.hpp"
#include "odeval/error.hpp"
#include "render/png.hpp"
#include "render/studio.hpp"

namespace odeval::experiments {
namespace {

using namespace answers;

const std::string never = fmt::format("no step from {} ms down to {} µs keeps it, or the method does not do it",
                                      shown(1e3 * ladder_s.front()), shown(1e6 * ladder_s.back()));

report::Cell cell_of(const Answer& answer, double value) {
  if (answer.kept.keeps) return value;
  return report::Missing{never};
}

/// A quantity as people who build say it: in mrad and mm.
struct Small {
  explicit Small(const Task& task) : unit("m" + std::string(quantities[task.quantity].unit)) {}
  double operator()(double value) const { return 1e3 * value; }
  std::string unit;
};

void add_findings(const Task& task, const Answered& all, double duration_s, Findings& findings) {
  const Answer& best = all.best();
  const Small small(task);
  const std::string task_text(task.text);
  const std::string about = fmt::format("{}, {} {} kept", task.text, shown(small(task.budget)), small.unit);
  const std::string name = "answer." + std::string(task.name);
  const auto found = [&](const Answer& answer, std::string meaning, std::string of, double value) {
    meaning += about;
    findings.add(name + of, answer.kept.keeps ? measured(meaning, of == "_erp" ? "" : "ms", value)
                                              : unavailable(meaning, "ms", never));
  };
  found(best, "step of ODE's best settings: ", "_step", 1e3 * best.kept.step_s);
  findings.add(name + "_budget", measured("what is kept: " + task_text, small.unit, small(task.budget)));
  findings.add(name + "_until", measured("until when it is kept: " + task_text, "s", duration_s));
  findings.add(name + "_half_step", measured("whether ODE's best settings have the half-step start: " + task_text, "",
                                             best.kept.ode.start == Start::half_step ? 1 : 0));
  found(best, "ERP of ODE's best settings: ", "_erp", best.kept.ode.erp);
  found(all.plain, "step of ODE's defaults: ", "_default_step", 1e3 * all.plain.kept.step_s);
  findings.add(name + "_keeps", measured("whether any settings of ODE keep it: " + task_text, "", best.kept.keeps));
  findings.add(name + "_default_keeps",
               measured("whether ODE's defaults keep it: " + task_text, "", all.plain.kept.keeps));
  const std::string gain = "step of ODE's best settings over that of its defaults: " + task_text;
  findings.add(name + "_gain", best.kept.keeps && all.plain.kept.keeps
                                   ? measured(gain, "", best.kept.step_s / all.plain.kept.step_s)
                                   : unavailable(gain, "", never));
}

std::vector<report::Cell> row_of(const Task& task, const Bench& bench, const Answered& all) {
  const Answer& best = all.best();
  const Kept& kept = best.kept;
  const Small small(task);
  const auto read = [&](std::string_view key, double value) -> report::Cell {
    if (best.kept.keeps && !reads(bench, best, key)) return report::Missing{"no joint or contact that would read it"};
    return cell_of(best, value);
  };
  return {std::string(task.text),
          cell_of(best, 1e3 * kept.step_s),
          read("ode.erp", kept.ode.erp),
          read("ode.cfm", kept.ode.cfm),
          also(best),
          best.method == nullptr || best.method->name == direct ? "dWorldStep" : "dWorldQuickStep",
          fmt::format("{} {}, {} s", shown(small(task.budget)), small.unit, shown(bench.scenario().duration_s)),
          cell_of(best, small(kept.error)),
          cell_of(best, small(kept.uncertainty)),
          cell_of(best, best.us_per_s),
          cell_of(all.plain, 1e3 * all.plain.kept.step_s),
          cell_of(all.plain, all.plain.us_per_s),
          cell_of(all.accurate, 1e3 * all.accurate.kept.step_s),
          cell_of(all.accurate, all.accurate.us_per_s)};
}

/// Every run of the table, where its error stands, and what it has to keep.
void add_proofs(const Task& task, const Bench& bench, const Answered& all, report::Table& proofs) {
  const Quantity& quantity = quantities[task.quantity];
  for (const auto& [answer, name, text] : {std::tuple{&all.best(), "best", "ODE's best"},
                                           {&all.plain, "defaults", "ODE's defaults"},
                                           {&all.accurate, "accurate", "accurate step"}}) {
    if (!answer->kept.keeps) continue;
    proofs.evidence.emplace_back(task.evidence);
    proofs.rows.push_back({std::string(task.text), std::string(text), command_of(bench, *answer, name),
                           std::string(quantity.name), answer->kept.error, task.budget, std::string(quantity.unit)});
  }
}

/// What the settings that keep the error on one arm leave on others.
report::Table other_arms(Laboratory& laboratory, const Kept& kept, Findings& findings) {
  report::Table table{.name = "answer-arms",
                      .columns = {"scenario", "until, s", "error, mrad", "error at a finer step, mrad",
                                  "error of the accurate step at the same step, mrad", "± mrad"}};
  double most = 0;
  for (const auto& [name, file] :
       {std::pair{"three_link", "three_link_arm"}, {"acrobot", "acrobot"}, {"puma", "puma560_falling"}}) {
    const std::string finding = fmt::format("answer.arm_of_{}", name);
    const std::string meaning = fmt::format("angle error of the settings for the double pendulum on {}", file);
    try {
      const double until_s = tasks().front().of(laboratory).duration_s;
      const auto error = [&](std::string_view method, double step_s, const OdeSettings& ode) {
        Scenario scenario = until(laboratory.scenario(file), until_s);
        scenario.step_s = step_s;  // of its controller as well, and so of the reference
        scenario.sample_s = rows_s;
        scenario.ode = ode;
        catalogue::Evaluator evaluator(std::move(scenario));
        const Metrics metrics = evaluator.measure(evaluator.evaluate(*available(method), ode), until_s);
        return std::pair{1e3 * metrics[quantity::max_error_turn].value_or(NAN),
                         1e3 * metrics[quantity::turn_uncertainty].value_or(NAN)};
      };
      const auto [off, known] = error(direct, kept.step_s, kept.ode);
      const double accurately = error(accurate, kept.step_s, kept.ode).first;
      most = std::max(most, accurately);
      findings.add(finding, measured(meaning, "mrad", off, known));
      table.rows.push_back({std::string(file), until_s, finite_cell(off),
                            finite_cell(error(direct, kept.step_s / 2, kept.ode).first), finite_cell(accurately),
                            finite_cell(known)});
    } catch (const UserError& error) {  // the build lacks the reference of trees
      findings.add(finding, unavailable(meaning, "mrad", error.what()));
      std::vector<report::Cell> row{std::string(file)};
      row.resize(table.columns.size(), report::Missing{error.what()});
      table.rows.push_back(std::move(row));
    }
  }
  findings.add("answer.arms_accurate",
               measured("largest angle error of the accurate step on those arms, at the same step", "mrad", most));
  return table;
}

/// ODE's motion with the truth as an outline, until a time.
report::Exhibit film(catalogue::Evaluator& evaluator, const catalogue::Evaluation& run, double until_s) try {
  constexpr int rate = 12;  // frames a second
  const Scenario& scenario = evaluator.scenario();
  const Reference& reference = evaluator.reference();
  render::Studio studio(scenario, {30, 14, {}}, 420, 300, render::caption_font(), {});
  render::Film frames(rate, {{"scenario", scenario.name}, {"method", direct}});
  const double spacing = run.trace.t.at(1);
  const int last = static_cast<int>(rate * std::min(until_s, run.trace.t.back()));
  for (int frame = -1; frame <= last; ++frame) {
    // The last one first: it is what stands still in print, where both should be seen.
    const auto row = static_cast<std::size_t>(std::lround((frame < 0 ? last : frame) / (rate * spacing)));
    const std::string label = fmt::format("t = {:.2f} s", run.trace.t[row]);
    frames.add(studio.frame(
        {render::pose_at(scenario, run.trace, row), render::pose_at(scenario, reference.trace, row), label},
        {"ODE, and the truth as an outline", label}));
  }
  return report::Picture{.name = "film", .png = frames.finish()};
} catch (const MachineError& error) {  // no OpenGL, no font
  return report::Lacking{"film", error.what()};
}

constexpr double early_s = 1;
constexpr double film_goes_on_s = 1;

/// An arm as a program has it that sets nothing, until it is another motion.
report::Exhibit plain_arm(Laboratory& laboratory, Findings& findings) {
  catalogue::Evaluator& pendulum = laboratory.evaluator("double_pendulum");
  const Scenario& scenario = pendulum.scenario();
  const catalogue::Evaluation run = pendulum.evaluate(*available(direct), defaults(scenario));
  const std::optional<double> lost_at = pendulum.measure(run, scenario.duration_s)[quantity::divergence_time];
  const double same_until = lost_at.value_or(scenario.duration_s);
  const std::string about = fmt::format(", double pendulum with ODE's defaults, h = {} s", shown(scenario.step_s));
  const std::string until = fmt::format(" until {} s", shown(early_s));
  findings.add("answer.step", measured("step of the first sentence", "ms", 1e3 * scenario.step_s));
  findings.add("answer.early", measured("end of the first sentence", "s", early_s));
  findings.add("answer.error",
               measured("angle error of dWorldStep" + until + about, "mrad", 1e3 * error_until(pendulum, run, early_s),
                        1e3 * uncertainty_until(pendulum, run, early_s)));
  const std::string when = "when dWorldStep's motion is another one" + about;
  findings.add("answer.until", measured("end of that motion", "s", scenario.duration_s));
  findings.add("answer.lost", measured("whether dWorldStep's motion becomes another one" + about, "", lost_at ? 1 : 0));
  findings.add("answer.lost_at",
               lost_at ? measured(when, "s", *lost_at) : unavailable(when, "s", "never until its end"));
  const double drift_J = pendulum.measure(run, same_until)[quantity::max_energy_drift].value_or(NAN);
  findings.add("answer.energy_drift",
               measured("energy drift of dWorldStep until it is another motion" + about, "J", drift_J));
  findings.add("answer.energy_share", measured("that drift over the largest kinetic energy" + about, "",
                                               drift_J / std::ranges::max(pendulum.reference().trace.kinetic)));
  return film(pendulum, run, same_until + film_goes_on_s);
}

/// Single beside double precision with the same settings, those of single precision, at smaller and smaller steps.
report::Table precisions(Laboratory& laboratory, Findings& findings) {
  constexpr std::array steps_s{1e-3, 5e-4, 2e-4, 1e-4};
  report::Table table{.name = "answer-precision",
                      .columns = {"step, ms", "error in double precision, mrad", "in single precision, mrad",
                                  "single over double", "± mrad"}};
  const catalogue::Method* const single = available("ode-step-single");
  const Bench bench(tasks().front(), laboratory);
  const double until_s = bench.scenario().duration_s;
  for (const double step_s : steps_s) {
    const OdeSettings ode = defaults(bench.scenario(), true);
    const Kept twice = bench.tried(*available(direct), step_s, ode);
    std::vector<report::Cell> row{1e3 * step_s, 1e3 * twice.error};
    report::Finding ratio =
        unavailable(fmt::format("angle error in single over that in double precision, double pendulum until {} s, "
                                "h = {} s, CFM {}",
                                shown(until_s), shown(step_s), shown(ode.cfm)),
                    "", std::string(catalogue::without_single_precision));
    if (single != nullptr) {
      const Kept once = bench.tried(*single, step_s, ode);
      ratio = measured_ratio(ratio.meaning, once.error, twice.error, once.uncertainty, twice.uncertainty);
      row.insert(row.end(), {finite_cell(1e3 * once.error), finite_cell(ratio.value)});
    } else {
      row.resize(row.size() + 2, report::Missing{ratio.missing});
    }
    row.emplace_back(1e3 * twice.uncertainty);
    table.rows.push_back(std::move(row));
    if (step_s == steps_s.front()) findings.add("answer.single_ratio", std::move(ratio));
    if (step_s == steps_s.back()) findings.add("answer.single_fine_ratio", std::move(ratio));
  }
  findings.add("answer.single_step", measured("step of the sentence on precision", "ms", 1e3 * steps_s.front()));
  findings.add("answer.single_fine_step", measured("its smaller step", "ms", 1e3 * steps_s.back()));
  findings.add("answer.single_until", measured("end of the sentence on precision", "s", until_s));
  return table;
}

/// What impacts are off by in a program that sets nothing, at a step and at those nearby.
report::Table plain_impacts(Laboratory& laboratory, Findings& findings) {
  const Scenario& scenario = laboratory.scenario("wall_pendulum");
  report::Table table{
      .name = "answer-impacts",
      .columns = {"step, ms", "impacts", "error of the first one's time, ms", "of the worst one's time, ms",
                  "the reference knows that to, ms", "angle error, mrad", "± mrad"}};
  std::vector<double> percents(catalogue::nearby_percents.begin(), catalogue::nearby_percents.end());
  percents.push_back(0);
  std::ranges::sort(percents);
  std::array<double, 7> most{};  // a column each
  for (const double percent : percents) {
    Scenario changed = scenario;
    changed.step_s = catalogue::moved(scenario.step_s, percent);
    catalogue::Evaluator evaluator(changed);
    const catalogue::Evaluation run = evaluator.evaluate(*available(direct), defaults(scenario));
    const Metrics metrics = evaluator.measure(run, scenario.duration_s);
    const auto& impacts = run.outcome.impacts;
    const auto& true_ones = evaluator.reference().impacts;
    const std::array row{1e3 * changed.step_s,
                         static_cast<double>(impacts.size()),
                         impacts.empty() || true_ones.empty() ? NAN : 1e3 * std::fabs(impacts[0].t - true_ones[0].t),
                         1e3 * metrics[quantity::max_impact_error].value_or(NAN),
                         1e3 * metrics[quantity::impact_uncertainty].value_or(NAN),
                         1e3 * metrics[quantity::max_error_q].value_or(NAN),
                         1e3 * metrics[quantity::reference_uncertainty].value_or(NAN)};
    for (std::size_t i = 0; i < row.size(); ++i) most[i] = std::isnan(row[i]) ? NAN : std::max(most[i], row[i]);
    table.rows.emplace_back();
    for (const double value : row) table.rows.back().push_back(finite_cell(value));
  }
  const std::string about = fmt::format(
      ", link against a wall with ODE's defaults until {} s, the most of {} steps within {} % of {} s",
      shown(scenario.duration_s), percents.size(), shown(catalogue::farthest_percent), shown(scenario.step_s));
  findings.add("answer.impact_first", measured("error of the first impact's time" + about, "ms", most[2], most[4]));
  findings.add("answer.impact_error", measured("largest error of an impact's time" + about, "ms", most[3], most[4]));
  findings.add("answer.impact_angle", measured("largest angle error" + about, "mrad", most[5], most[6]));
  findings.add("answer.impact_steps", measured("largest error of an impact's time, in steps" + about, "",
                                               1e-3 * most[3] / scenario.step_s, 1e-3 * most[4] / scenario.step_s));
  findings.add("answer.impacts", measured("impacts in that time", "", most[1]));
  findings.add("answer.wall_steps",
               measured("steps tried for the sentence on impacts", "", static_cast<double>(percents.size())));
  findings.add("answer.wall_nearby", measured("how far from its step", "%", catalogue::farthest_percent));
  findings.add("answer.wall_step", measured("step of the sentence on impacts", "ms", 1e3 * scenario.step_s));
  findings.add("answer.wall_until", measured("end of the sentence on impacts", "s", scenario.duration_s));
  return table;
}

}  // namespace

Content answer(Laboratory& laboratory, Findings& findings) {
  report::Table table{.name = "answer",
                      .columns = {"task", "step, ms", "ERP", "CFM", "also", "stepper", "keeps, until",
                                  "error, mrad or mm", "± mrad or mm", "µs a simulated second",
                                  "ODE's defaults: step, ms", "µs a second", "accurate step: step, ms", "µs a second"}};
  report::Table proofs{
      .name = "answer-proofs",
      .columns = {"task", "settings", "the run that proves it", "its error is", "error", "budget", "unit"}};
  Kept arm;
  for (const Task& task : tasks()) {
    table.evidence.emplace_back(proofs.name);
    try {
      const Bench bench(task, laboratory);
      const Answered all = answered(bench);
      add_findings(task, all, bench.scenario().duration_s, findings);
      table.rows.push_back(row_of(task, bench, all));
      add_proofs(task, bench, all, proofs);
      if (&task == tasks().data()) arm = all.direct.kept;
    } catch (const std::exception& error) {  // the build lacks what the task's reference needs
      std::vector<report::Cell> row{std::string(task.text)};
      row.resize(table.columns.size(), report::Missing{error.what()});
      table.rows.push_back(std::move(row));
      findings.add(fmt::format("answer.{}_step", task.name),
                   unavailable("step of ODE's best settings", "ms", error.what()));
      findings.add(fmt::format("answer.{}_default_step", task.name),
                   unavailable("step of ODE's defaults", "ms", error.what()));
    }
  }
  Content content;
  content.values = {{"step", 1e3 * laboratory.scenario("double_pendulum").step_s},
                    {"goes_on", film_goes_on_s},
                    {"largest_step", shown(1e3 * ladder_s.front())},
                    {"least_step", shown(1e6 * ladder_s.back())},
                    {"steps", ladder_s.size()},
                    {"erps", erps.size()},
                    {"cfms", cfms.size()},
                    {"iterations", OdeSettings{}.iterations},
                    {"much_cheaper", much_cheaper_percent},
                    {"nearby", shown(catalogue::farthest_percent)},
                    {"rows", shown(1e3 * rows_s)}};
  content.exhibits.emplace_back(std::move(table));
  content.exhibits.emplace_back(std::move(proofs));
  content.exhibits.emplace_back(other_arms(laboratory, arm, findings));
  content.exhibits.emplace_back(plain_impacts(laboratory, findings));
  content.exhibits.emplace_back(precisions(laboratory, findings));
  content.exhibits.push_back(plain_arm(laboratory, findings));
  return content;
}

}  // namespace odeval::experiments
