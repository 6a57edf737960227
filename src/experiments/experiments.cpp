#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "catalogue/self_converged.hpp"
#include "experiments/all.hpp"

namespace odeval::experiments {
namespace {

constexpr report::Embedded prose[] = {
#include "experiment_prose.inc"  // the files of text/, by their names
};

/// Without a template it does not compile.
consteval Experiment row(std::string_view name, report::Content (*run)(Laboratory&, report::Findings&)) {
  return {name, report::text_of(prose, name), run};
}

// clang-format off
constexpr std::array table{
    row("answer", answer),
    row("switch", should_i_switch),
    row("snapshots", snapshots),
    row("double-pendulum", double_pendulum),
    row("accuracy", accuracy),
    row("table-5-2", table_5_2),
    row("work-precision", work_precision),
    row("energy", energy),
    row("energy-feedback", energy_feedback),
    row("wall-pendulum", wall_pendulum),
    row("contact-delay", contact_delay),
    row("quickstep", quickstep),
    row("quickstep-chain", quickstep_chain),
    row("half-step", half_step),
    row("half-step-erp", half_step_erp),
    row("half-step-energy", half_step_energy),
    row("order", order),
    row("sensitivity", sensitivity),
    row("dh", denavit_hartenberg),
    row("single-pendulum", single_pendulum),
    row("coordinates", coordinates),
    row("chain", chain),
    row("error-sources", error_sources),
    row("conditioning", conditioning),
    row("orientation", orientation),
    row("feedback-term", feedback_term),
    row("free-box", free_box),
    row("thin-body", thin_body),
    row("friction", friction),
    row("bouncing-ball", bouncing_ball),
    row("spring-joint", spring_joint),
    row("motor-lift", motor_lift),
    row("remedy", remedy),
    row("iftomm", iftomm),
    row("potra", potra),
    row("benchmarks", benchmarks),
};
// clang-format on

static_assert(std::size(table) == std::size(prose), "a template of no experiment");

/// What stands below a section whose runs ODE itself complained of.
std::string suspects_text(const std::vector<std::string>& suspects) {
  constexpr std::size_t most = 5;
  std::string text =
      fmt::format("Suspect: ODE itself complained in {} of these runs, whose numbers say little: ", suspects.size());
  for (std::size_t i = 0; i < std::min(most, suspects.size()); ++i) text += (i == 0 ? "" : "; ") + suspects[i];
  return text + (suspects.size() > most ? "; and others." : ".");
}

/// What stands below a section with numbers that nobody but ODE itself knows the truth of.
std::string own_limits_text(const std::vector<std::string>& lines) {
  return fmt::format(
      "{}: in the tables and figures of this section the numbers of what follows are measured against ODE's "
      "own limit, for want of another reference: {}.",
      self_converged_origin, fmt::join(lines, "; "));
}

}  // namespace

std::span<const Experiment> experiments() { return table; }

report::Section section_of(const Experiment& experiment, Laboratory& laboratory, report::Findings& findings) {
  const catalogue::Suspects suspects;
  const catalogue::OwnLimits own_limits;
  report::Section section =
      report::section_of(std::string(experiment.name), experiment.prose, experiment.run(laboratory, findings));
  if (!suspects.lines().empty()) section.blocks.emplace_back(report::Text{suspects_text(suspects.lines())});
  if (!own_limits.lines().empty()) section.blocks.emplace_back(report::Text{own_limits_text(own_limits.lines())});
  return section;
}

}  // namespace odeval::experiments
