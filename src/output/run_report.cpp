#include "output/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "odeval/metrics.hpp"
#include "odeval/origin.hpp"
#include "output/mechanism_report.hpp"
#include "output/table.hpp"

namespace odeval {

const Metrics* half_a_step(const RunSummary& run) {
  if (!run.uses_ode || run.scenario.ode.start == Start::half_step) return nullptr;
  constexpr double near = 0.1;  // steps
  constexpr double most = 0.9;  // of the error
  const Metrics* found = nullptr;
  for (const Metrics& metrics : run.error_at) {
    const auto& shift = metrics[quantity::time_shift];
    const auto& error = metrics[quantity::max_error_q];
    const auto& left = metrics[quantity::error_q_after_shift];
    if (!shift || !error || !left) continue;
    const bool half = std::fabs(*shift / run.grid.step_s - 0.5) < near;
    if (half && *left < (1 - most) * *error) found = &metrics;
  }
  return found;
}

namespace {

/// Suggests the half-step start where it would take most of the error away.
std::string half_step_hint(const std::vector<RunSummary>& runs, const std::optional<double>& leaves) {
  const auto explained = std::ranges::find_if(runs, [](const RunSummary& run) { return half_a_step(run) != nullptr; });
  if (explained == runs.end()) return "";
  const Metrics& metrics = *half_a_step(*explained);
  const double error = *metrics[quantity::max_error_q];
  if (leaves && !(*leaves < error)) return "";
  return fmt::format(
      "half step  to {:g} s {} is {:.2f} steps ahead of the reference; error {:.3g} rad, after shifting by that "
      "time {:.3g} rad: try --start half-step{}\n",
      metrics.until_s, explained->method, *metrics[quantity::time_shift] / explained->grid.step_s, error,
      *metrics[quantity::error_q_after_shift], leaves ? fmt::format(", which leaves {:.3g} rad", *leaves) : "");
}

/// Why runs ended early, and what ODE itself said of them.
std::string reason_lines(const std::vector<RunSummary>& runs) {
  std::string text;
  for (const RunSummary& run : runs) {
    if (run.outcome.diverged && !run.outcome.reason.empty()) {
      text += fmt::format("diverged   {}: {}\n", run.method, run.outcome.reason);
    }
    if (run.outcome.messages > 0) {
      text += fmt::format("suspect    {}: {}; the first: {}\n", run.method, suspicion(run.outcome),
                          run.outcome.first_message);
    }
  }
  return text.empty() ? text : "\n" + text;
}

/// The springs that the joints were given, as ODE was told.
std::string spring_line(const Scenario& scenario, double step_s) {
  if (!scenario.ode.spring) return "";
  const Softness softness = scenario.ode.softness(step_s);
  return fmt::format("joints     kp {:g} N/m, kd {:g} N s/m: ERP {:.6g}, CFM {:.6g} at this step\n",
                     scenario.ode.spring->kp_N_m, scenario.ode.spring->kd_Ns_m, softness.erp, softness.cfm);
}

/// Where ODE was told to bounce otherwise than the mechanism does, whose motion the reference is.
std::string bounce_line(const std::vector<RunSummary>& runs) {
  const Scenario& scenario = runs.front().scenario;
  const auto told = [](const RunSummary& run) { return run.uses_ode || run.uses_bounce; };
  if (std::ranges::none_of(runs, told)) return "";
  const std::vector<Contact>& contacts = scenario.mechanism.contacts;
  const auto bounce_of = [&](const Contact& contact) { return scenario.ode.bounce.value_or(contact.restitution); };
  const auto other = std::ranges::find_if(
      contacts, [&](const Contact& contact) { return !contact.spring && bounce_of(contact) != contact.restitution; });
  const bool bounces =
      std::ranges::any_of(contacts, [&](const Contact& contact) { return !contact.spring && bounce_of(contact) > 0; });
  std::string text;
  if (other != contacts.end()) {
    text += fmt::format("ODE bounces with {:g}, the reference with {:g}", bounce_of(*other), other->restitution);
  }
  if (scenario.ode.bounce_vel > 0 && bounces) {
    text += fmt::format("{}ODE below {:g} m/s not at all, the reference always", text.empty() ? "" : "; ",
                        scenario.ode.bounce_vel);
  }
  return text.empty() ? text : "bounce     " + text + ": errors from the first impact on are of two motions\n";
}

/// Where ODE's own friction is the reference, what has another: Coulomb's own is no error, and yet is told as one.
std::string friction_line(const std::vector<RunSummary>& runs, const Reference& reference) {
  if (!reference.origin.starts_with(self_converged_origin)) return "";
  const std::vector<Contact>& contacts = runs.front().scenario.mechanism.contacts;
  const auto rubs = [](const Contact& contact) { return contact.friction && contact.friction->limit > 0; };
  if (std::ranges::none_of(contacts, rubs)) return "";
  std::string others;
  for (const RunSummary& run : runs) {
    if (!run.uses_ode) others += (others.empty() ? "" : ", ") + run.method;
  }
  if (others.empty()) return "";
  return "friction   the reference has ODE's own law; " + others +
         " may have another law: what of their errors is that law is not known, and is no fault of theirs\n";
}

template <class Value>
Value setting_of(const Definition& definition, std::string_view key) {
  const auto found = std::ranges::find(definition, key, &Definition::value_type::first);
  return found == definition.end() ? Value{} : std::get<Value>(found->second);
}

/// What was changed of a start that the file's joints do not allow as it is said.
std::string start_lines(const Definition& definition) {
  std::string text;
  if (const auto body = setting_of<std::string>(definition, "changed_at_start.body"); !body.empty()) {
    text += fmt::format(
        "start      velocities changed by up to {} m/s and spins by {} rad/s, most of '{}': the nearest "
        "that all joints allow\n",
        three_digits(setting_of<double>(definition, "changed_at_start.velocity")),
        three_digits(setting_of<double>(definition, "changed_at_start.spin")), body);
  }
  if (const auto joint = setting_of<std::string>(definition, "closed_at_start.joint"); !joint.empty()) {
    text += fmt::format(
        "start      loops closed from q by joints that turned by up to {} rad and slid by {} m, most "
        "'{}'\n",
        three_digits(setting_of<double>(definition, "closed_at_start.turn")),
        three_digits(setting_of<double>(definition, "closed_at_start.way")), joint);
  }
  return text;
}

}  // namespace

std::string run_report(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step,
                       const Reference& reference, const std::optional<double>& half_step_leaves) {
  const Scenario& scenario = runs.front().scenario;
  const SampleGrid& grid = runs.front().grid;
  std::string text = fmt::format("{}: {:g} s, h = {:g} s, {} rows\n\n", scenario.name, grid.time(grid.rows - 1),
                                 grid.step_s, grid.rows);
  text += summary_table(runs, ns_per_step);
  text += reason_lines(runs);
  const auto touched = [](const RunSummary& run) { return !run.outcome.impacts.empty(); };
  if (std::ranges::any_of(runs, touched)) text += "\n" + impacts_table(runs, reference.impacts);
  text += mechanism_tables(runs, reference.strikes);
  for (const RunSummary& run : runs) {
    if (run.outcome.self_difference) {
      text += fmt::format("\n{}: {} rad between its runs at two step sizes\n", run.method,
                          three_digits(run.outcome.self_difference));
    }
  }
  text += compared(runs.front().metrics, Scope::body)
              ? "\ndistance   largest distance of a body from the reference ± what the reference may itself be off by\n"
                "turned     likewise the angle between its attitude and the reference's\n"
              : fmt::format(
                    "\nerror      largest angle error against the reference ± what the reference may itself be "
                    "off by\nlost at    first error above {:g} rad\n",
                    divergence_rad);
  text += "reference  " + reference.origin + '\n';
  if (const auto lost = runs.front().metrics.reference_lost_at) {
    text += fmt::format("           itself unknown to {:g} rad from t = {:g} s: nothing is called lost after that\n",
                        divergence_rad, *lost);
  }
  text += start_lines(scenario.definition);
  text += spring_line(scenario, grid.step_s);
  text += bounce_line(runs);
  text += friction_line(runs, reference);
  text += half_step_hint(runs, half_step_leaves);
  return text;
}

std::string summaries_json(const std::vector<RunSummary>& runs) {
  std::string text = "[\n";
  for (const RunSummary& run : runs) text += (&run == &runs.front() ? "" : ",\n") + summary_json(run);
  return text + "]\n";
}

}  // namespace odeval
