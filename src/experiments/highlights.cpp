#include "experiments/highlights.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "report/template.hpp"
#include "report/text.hpp"

namespace odeval::experiments {
namespace {

using report::Condition;
using report::Relation;

constexpr auto at_most = Relation::at_most;
constexpr auto at_least = Relation::at_least;

// clang-format off
constexpr Condition first_order[] = {{"C1.order_off", at_most, 0.1}};
constexpr Condition half_step[]   = {{"O1.gain", at_least, 10}};
constexpr Condition erp[]         = {{"O2.gain", at_least, 2}};
constexpr Condition feedback[]    = {{"coordinates.feedback_gain", at_least, 10}};
constexpr Condition quickstep[]   = {{"C2.error_ratio", at_most, 1.01}, {"C2.chain_error_ratio", at_least, 1.5}};
constexpr Condition friction[]    = {{"C14.anisotropy", at_least, 0.1}, {"friction.told_off", at_most, 0.01}};
constexpr Condition friction_told[] = {{"C14.anisotropy", at_least, 0.1}, {"friction.told_off", at_least, 0.01}};
constexpr Condition contact[]     = {{"potra.late_steps", at_most, 2}, {"answer.impact_steps", at_least, 3}};
constexpr Condition contact_alone[] = {{"potra.late_steps", at_most, 2}, {"answer.impact_steps", at_most, 3}};
constexpr Condition single[]      = {{"C4.long_axis_spin_single", at_least, 1}, {"C4.long_axis_spin_double", at_most, 1e-3}};
constexpr Condition energy[]      = {{"O3.drift_ratio", at_least, 1.2}};
constexpr Condition remedy[]      = {{"C12.smooth_gain", at_least, 1000}, {"C12.impact_gain", at_least, 1000}};

constexpr Condition lost[]          = {{"answer.lost", at_least, 1}, {"answer.energy_share", at_most, 0.1}};
constexpr Condition lost_energy[]   = {{"answer.lost", at_least, 1}, {"answer.energy_share", at_least, 0.1}};
constexpr Condition never_lost[]    = {{"answer.lost", at_most, 0}};
constexpr Condition arm_start[]     = {{"answer.arm_gain", at_least, 1.5}, {"answer.arm_half_step", at_least, 1}};
constexpr Condition arm_erp[]       = {{"answer.arm_gain", at_least, 1.5}, {"answer.arm_half_step", at_most, 0}};
constexpr Condition arm_defaults[]  = {{"answer.arm_gain", at_most, 1.5}};
constexpr Condition arm_no_default[] = {{"answer.arm_keeps", at_least, 1}, {"answer.arm_default_keeps", at_most, 0}};
constexpr Condition arm_none[]      = {{"answer.arm_keeps", at_most, 0}};
constexpr Condition impact[]        = {{"answer.impact_steps", at_least, 0.5}, {"C14.anisotropy", at_least, 0.1}};
constexpr Condition impact_round[]  = {{"answer.impact_steps", at_least, 0.5}, {"C14.anisotropy", at_most, 0.1}};
constexpr Condition impact_right[]  = {{"answer.impact_steps", at_most, 0.5}};
constexpr Condition same_single[]   = {{"answer.single_ratio", at_most, 1.1}, {"C4.long_axis_spin_single", at_least, 1}};
constexpr Condition safe_single[]   = {{"answer.single_ratio", at_most, 1.1}, {"C4.long_axis_spin_single", at_most, 1}};
constexpr Condition unsafe_single[] = {{"answer.single_ratio", at_least, 1.1}};
constexpr Condition other_arms[]    = {{"answer.arm_keeps", at_least, 1}, {"answer.arm_of_puma", at_least, 0}};

/// The box: no figures. Of each group of rows one holds, whatever was measured.
constexpr std::array box{
    Row{"accuracy", "", 0, lost,
        "With ODE's defaults and a step of {{answer_step}} the angles of the 2010 report's double pendulum, of metre size, are off by up to {{answer_error}} in {{answer_early}}; after {{answer_lost_at}} it is another motion. Its energy is right to {{answer_energy_drift}}, {{answer_energy_share_percent}} of its largest kinetic energy, and tells nothing of it.", "Accuracy"},
    Row{"accuracy", "", 0, lost_energy,
        "With ODE's defaults and a step of {{answer_step}} the angles of the 2010 report's double pendulum, of metre size, are off by up to {{answer_error}} in {{answer_early}}; after {{answer_lost_at}} it is another motion. Its energy drifts by {{answer_energy_drift}} meanwhile, {{answer_energy_share_percent}} of its largest kinetic energy.", "Accuracy"},
    Row{"accuracy", "", 0, never_lost,
        "With ODE's defaults and a step of {{answer_step}} the angles of the 2010 report's double pendulum, of metre size, are off by up to {{answer_error}} in {{answer_early}}, and until {{answer_until}} it stays the same motion. Its energy is right to {{answer_energy_drift}}, {{answer_energy_share_percent}} of its largest kinetic energy.", "Accuracy"},
    Row{"answer-evidence", "", 0, arm_start,
        "To keep {{answer_arm_budget}} for {{answer_arm_until}} it needs a step of {{answer_arm_step}}, ERP {{answer_arm_erp}} and the half-step start (take from each starting velocity what the weights add in half a step); with ODE's defaults a step of {{answer_arm_default_step}}.", "An arm"},
    Row{"answer-evidence", "", 0, arm_erp,
        "To keep {{answer_arm_budget}} for {{answer_arm_until}} it needs a step of {{answer_arm_step}} and ERP {{answer_arm_erp}}; with ODE's defaults a step of {{answer_arm_default_step}}.", "An arm"},
    Row{"answer-evidence", "", 0, arm_defaults,
        "To keep {{answer_arm_budget}} for {{answer_arm_until}} it needs a step of {{answer_arm_default_step}} with ODE's defaults, and no settings that were tried allow a much larger one.", "An arm"},
    Row{"answer-evidence", "", 0, arm_no_default,
        "To keep {{answer_arm_budget}} for {{answer_arm_until}} it needs a step of {{answer_arm_step}} and ERP {{answer_arm_erp}}, with what else the table says; with ODE's defaults no step that was tried is small enough.", "An arm"},
    Row{"answer-evidence", "", 0, arm_none,
        "No settings that were tried keep {{answer_arm_budget}} for {{answer_arm_until}} of it: take the accurate step.", "An arm"},
    Row{"answer-evidence", "", 0, other_arms,
        "Those settings are for that motion, not for every arm: they leave {{answer_arm_of_acrobot}} on an acrobot, {{answer_arm_of_three_link}} on an arm that turns in space (three_link_arm) and {{answer_arm_of_puma}} on a falling PUMA robot; the accurate step at the same step at most {{answer_arms_accurate}}. Yours is told by odeval audit -- PROGRAM.", "Other arms"},
    Row{"answer-evidence", "", 0, impact,
        "At a step of {{answer_wall_step}} the first impact of a link on a wall is off by up to {{answer_impact_first}}, the worst of {{answer_impacts}} in {{answer_wall_until}} by {{answer_impact_error}} and the angles by {{answer_impact_angle}} (the most of {{answer_wall_steps}} steps within {{answer_wall_nearby}} of it): ODE sees a contact at the end of a step, and each error goes into the next. Friction is up to {{C14_anisotropy_percent}} too strong along the diagonal of its axes.", "Impacts and friction"},
    Row{"answer-evidence", "", 0, impact_round,
        "At a step of {{answer_wall_step}} the first impact of a link on a wall is off by up to {{answer_impact_first}}, the worst of {{answer_impacts}} in {{answer_wall_until}} by {{answer_impact_error}} and the angles by {{answer_impact_angle}} (the most of {{answer_wall_steps}} steps within {{answer_wall_nearby}} of it): ODE sees a contact at the end of a step, and each error goes into the next. Friction is the same in all directions, to {{C14_anisotropy_percent}}.", "Impacts and friction"},
    Row{"answer-evidence", "", 0, impact_right,
        "At a step of {{answer_wall_step}} an impact of a link on a wall is right to {{answer_impact_error}}, less than the step, and the angles to {{answer_impact_angle}} until {{answer_wall_until}} (the most of {{answer_wall_steps}} steps within {{answer_wall_nearby}} of it).", "Impacts"},
    Row{"answer-evidence", "", 0, same_single,
        "Single precision is safe for the double pendulum at {{answer_single_step}}, where its error until {{answer_single_until}} is {{answer_single_ratio}} times that of double precision with the same settings (at {{answer_single_fine_step}} {{answer_single_fine_ratio}} times); not for long thin bodies, which it spins up.", "Precision"},
    Row{"answer-evidence", "", 0, safe_single,
        "Single precision is safe for the double pendulum at {{answer_single_step}}, where its error until {{answer_single_until}} is {{answer_single_ratio}} times that of double precision with the same settings (at {{answer_single_fine_step}} {{answer_single_fine_ratio}} times), and for long thin bodies.", "Precision"},
    Row{"answer-evidence", "", 0, unsafe_single,
        "Single precision is not safe: at {{answer_single_step}} the error of the double pendulum until {{answer_single_until}} is {{answer_single_ratio}} times that of double precision with the same settings.", "Precision"},
};

constexpr std::array table{
    Row{"order", "order-lines", 0, first_order,
        "ODE is first order: half the step, half the error, twice the cost. Order of dWorldStep: {{order_ode_step_double}}."},
    Row{"half-step", "half-step-figure", 0, half_step,
        "Most of that error is a clock half a step off. Starting with the velocities of half a step before the start divides the error of a double pendulum by {{O1_gain}} at the finest step tried, for nothing."},
    Row{"half-step-erp", "half-step-erp-figure", 1, erp,
        "With that start, at a step of {{O2_step}}, an ERP of {{O2_erp}} instead of the default {{O2_default_erp}} divides the error of a double pendulum until {{O2_until}} by {{O2_gain}} again; until {{O2_late_until}} by {{O2_late_gain}}."},
    Row{"coordinates", "coordinates-erp", 0, feedback,
        "Leave the feedback on: with ERP 0 the error of a double pendulum is {{coordinates_feedback_gain}} times as large."},
    Row{"quickstep-chain", "quickstep-chain-figure", 0, quickstep,
        "QuickStep is as good as dWorldStep on a double pendulum; on a chain of {{C2_chain_links}} links it needs more than its {{C2_iterations}} iterations, with which its error is {{C2_chain_error_ratio}} times dWorldStep's."},
    Row{"friction", "friction-figure", 0, friction,
        "Friction is a pyramid: along the diagonal of its axes it is {{C14_anisotropy_percent}} stronger. Where each contact is told the way it slides, a box slides as far as it should in every direction, to {{friction_told_off_percent}}."},
    Row{"friction", "friction-figure", 0, friction_told,
        "Friction is a pyramid: along the diagonal of its axes it is {{C14_anisotropy_percent}} stronger, and telling each contact the way it slides leaves the way of a box {{friction_told_off_percent}} off."},
    Row{"potra", "potra-figure", 1, contact,
        "Where two points on rods hit a wall, each of the {{potra_impacts}} impacts until {{potra_until}} stands within {{potra_late_steps}} steps of the true one, at a step of {{potra_step}}. Another motion is worse off: of the {{answer_impacts}} impacts on the wall of the box at the top the worst is {{answer_impact_steps}} steps off."},
    Row{"potra", "potra-figure", 1, contact_alone,
        "Where two points on rods hit a wall, each of the {{potra_impacts}} impacts until {{potra_until}} stands within {{potra_late_steps}} steps of the true one, at a step of {{potra_step}}."},
    Row{"thin-body", "thin-body-figure", 0, single,
        "Single precision is not safe for long thin bodies: a box {{C4_aspect}} times as long as thick takes up {{C4_long_axis_spin_single}} times its own spin about its length, in double precision {{C4_long_axis_spin_double}}."},
    Row{"half-step-energy", "half-step-energy-figure", 0, energy,
        "Energy does not tell how wrong a motion is: that of a double pendulum drifts {{O3_drift_ratio}} times as far by the velocities that ODE stores as by those in the middle of its steps, and the motion is the same."},
    Row{"remedy", "remedy-errors", 0, remedy,
        "odeval's fourth-order step moves the same ODE world at least {{C12_smooth_gain}} times as accurately at the same step, through impacts at least {{C12_impact_gain}} times."},
};
// clang-format on

constexpr std::string_view of_colours =
    "A method has the same colour in every figure of this page; methods that a figure does not tell apart are grey. "
    "Violet and pink are never a method: they are what one figure alone varies, as its legend says.";

bool holds(const Row& row, const report::Findings& findings) {
  return std::ranges::all_of(row.holds_if, [&](const Condition& condition) {
    const report::Finding* const finding = findings.find(condition.finding);
    return finding != nullptr && finding->value && report::holds(condition, *finding).value_or(false);
  });
}

/// A finding's name as templates can have it.
std::string in_template(std::string_view name) {
  std::string out(name);
  std::ranges::replace_if(
      out, [](char letter) { return letter == '.' || letter == '-'; }, '_');
  return out;
}

std::string percent(const report::Finding& finding) {
  return report::shown_plainly({"", "%", 100 * *finding.value, 100 * finding.uncertainty, ""});
}

/// Nothing where its conditions do not hold, or a number that it names was not measured.
std::optional<std::string> sentence_of(const Row& row, const report::Findings& findings) {
  if (!holds(row, findings)) return std::nullopt;
  report::Values values;
  for (const std::string& wanted : report::names_in(row.sentence)) {
    constexpr std::string_view as_percent = "_percent";
    const bool is_percent = wanted.ends_with(as_percent);
    const std::string_view name =
        std::string_view(wanted).substr(0, wanted.size() - (is_percent ? as_percent.size() : 0));
    const auto found =
        std::ranges::find_if(findings.all(), [&](const auto& one) { return in_template(one.first) == name; });
    if (found == findings.all().end() || !found->second.value) return std::nullopt;
    values.insert({wanted, is_percent ? percent(found->second) : report::shown_plainly(found->second)});
  }
  return report::filled(row.section, row.sentence, values, [](std::string_view text) { return std::string(text); });
}

const report::Figure* figure_of(const Row& row, std::span<const report::Section> sections) {
  for (const report::Section& section : sections) {
    if (section.name != row.section) continue;
    for (const report::Block& block : section.blocks) {
      const auto* const figure = std::get_if<report::Figure>(&block);
      if (figure != nullptr && figure->name == row.figure && row.panel < figure->panels.size()) return figure;
    }
  }
  return nullptr;
}

}  // namespace

std::span<const Row> highlights() { return table; }
std::span<const Row> box_sentences() { return box; }

std::vector<report::Section> front_of(std::vector<report::Section>& sections, const report::Findings& findings) {
  report::Section answer{"answer", "Which settings?", {}};
  for (const Row& row : box) {
    if (const auto sentence = sentence_of(row, findings))
      answer.blocks.emplace_back(report::Text{*sentence, std::string(row.section), std::string(row.lead)});
  }
  const auto measured = std::ranges::find(sections, answer.name, &report::Section::name);
  if (measured != sections.end()) {
    answer.title = measured->title;
    // The film, its table and what is said of both; the runs behind them stay where they are folded.
    const auto folded =
        std::stable_partition(measured->blocks.begin(), measured->blocks.end(), [&](const report::Block& block) {
          const auto* const table = std::get_if<report::Table>(&block);
          return table == nullptr || table->name == answer.name;
        });
    std::move(measured->blocks.begin(), folded, std::back_inserter(answer.blocks));
    measured->blocks.erase(measured->blocks.begin(), folded);
    measured->name = "answer-evidence";
    measured->title = "Which settings: the runs behind the answer";
  }
  report::Section in_short{"in-short", "In short", {}};
  in_short.blocks.emplace_back(report::Text{std::string(of_colours)});
  for (const Row& row : table) {
    const report::Figure* const figure = figure_of(row, sections);
    const std::optional<std::string> sentence = sentence_of(row, findings);
    if (figure == nullptr || !sentence) continue;
    in_short.blocks.emplace_back(report::Highlight{
        *sentence, {figure->name, figure->title, "", {figure->panels[row.panel]}, 1}, std::string(row.section)});
  }
  // Of what there is to say to whoever thinks of leaving, the advice; its evidence stays where it is folded.
  report::Section leaving{"should-i-switch", "Should I switch?", {}};
  if (const auto found = std::ranges::find(sections, "switch", &report::Section::name); found != sections.end()) {
    for (auto& block : found->blocks) {
      const auto* const table = std::get_if<report::Table>(&block);
      if (table == nullptr || table->name != "switch") continue;
      leaving.blocks.push_back(std::move(block));
      found->blocks.erase(found->blocks.begin() + (&block - found->blocks.data()));
      break;
    }
    found->title = "ODE beside other engines";
  }
  return {std::move(answer), std::move(leaving), std::move(in_short)};
}

}  // namespace odeval::experiments
