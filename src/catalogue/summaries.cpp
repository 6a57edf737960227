#include "catalogue/summaries.hpp"

#include "catalogue/self_converged.hpp"
#include "catalogue/versions.hpp"
#include "output/mechanism_report.hpp"

namespace odeval::catalogue {

RunSummary settings_of(const Method& method, const Scenario& scenario) {
  const auto in_effect = [](const std::optional<double>& asked, double own) {
    return own == 0 ? std::nullopt : std::optional(asked.value_or(own));
  };
  RunSummary summary;
  summary.scenario = scenario;
  summary.grid = sample_grid(scenario);
  summary.method = method.name;
  summary.is_reference = method.name == provider_of(scenario).method && !scenario.rtol && !scenario.atol;
  summary.uses_ode = has_half_step_start(method);
  summary.uses_bounce = !summary.uses_ode && reads(method, "ode.bounce", scenario);
  summary.uses_bullet = reads(method, "bullet.iterations", scenario);
  summary.uses_mujoco = reads(method, "mujoco.time_constant", scenario);
  const bool here = method.make != nullptr;  // else a folder holds results of a build that has it
  if (method.tells && here) summary.told = method.make(scenario, summary.grid)->told();
  summary.uses_maximal = reads(method, "maximal.ks", scenario);
  summary.rtol = in_effect(scenario.rtol, method.rtol);
  summary.atol = in_effect(scenario.atol, method.atol);
  summary.versions = versions();
  return summary;
}

RunSummary summarise(const Evaluation& run, Evaluator& evaluator) {
  RunSummary summary = settings_of(*run.method, evaluator.scenario());
  summary.outcome = run.outcome;
  summary.metrics = evaluator.measure(run, summary.grid.time(summary.grid.rows - 1));
  for (const double until : error_times_within(summary.grid)) {
    summary.error_at.push_back(evaluator.measure(run, until));
  }
  summary.parts = parts_of(evaluator.scenario(), run.trace);
  summary.reference = evaluator.reference().origin;
  return summary;
}

}  // namespace odeval::catalogue
