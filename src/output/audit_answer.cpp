#include "output/audit_answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "output/number.hpp"
#include "output/table.hpp"

namespace odeval {
namespace {

using audit::Answer;
using audit::Convergence;
using audit::ErrorUntil;
using audit::Estimate;

constexpr std::size_t most_lines = 25;
// So that there is room for a limit, and for how many more there are.
constexpr std::size_t most_rows = 5;  // of errors
constexpr std::size_t most_tried = 4;

std::string count(std::uint64_t number, const char* one, const char* many) {
  return fmt::format("{} {}", number, number == 1 ? one : many);
}

/// "6 bodies, 1 at a time".
std::string made(std::uint64_t in_all, std::uint64_t at_a_time, const char* one, const char* many) {
  return count(std::max(in_all, at_a_time), one, many) +
         (in_all > at_a_time ? fmt::format(", {} at a time", at_a_time) : "");
}

std::string called(const char* kind, std::uint32_t number, const std::map<std::uint32_t, std::string>& names) {
  const auto name = names.find(number);
  return name == names.end() ? fmt::format("{} {}", kind, number)
                             : fmt::format("{} {} ({})", kind, number, name->second);
}

}  // namespace

std::string body_name(const Answer& answer, std::uint32_t body) { return called("body", body, answer.body_names); }
std::string joint_name(const Answer& answer, std::uint32_t joint) { return called("joint", joint, answer.joint_names); }

std::string audit_head(const Answer& answer) {
  const audit::ProgramRun& run = answer.runs.front();
  if (answer.bodies == 0) {
    const char* nothing = answer.unrecorded ? "nothing is recorded; " : "no step of ODE; ";
    return (run.steps == 0 ? nothing : "") + run.end;
  }
  const auto joints_made =
      std::ranges::count_if(answer.joint_summaries, [](const auto& its) { return its.number > 0; });
  std::string line = fmt::format(
      "{}, h = {:.4g} s{}, {}, {:.4g} s; {}, {}; {}", answer.stepper, answer.h_s, answer.h_varies ? " at first" : "",
      count(run.steps, "step", "steps") + (answer.worlds > 1 ? " at most" : ""), run.simulated_s,
      (answer.worlds > 1 ? fmt::format("{} worlds, ", answer.worlds) : "") +
          made(answer.bodies_made, answer.bodies, "body", "bodies"),
      made(static_cast<std::uint64_t>(joints_made), answer.joints, "joint", "joints"), run.end);
  if (answer.runs.size() > 1) line += answer.parting ? "; does not repeat" : "; repeats to the bit";
  return line;
}

const char* convergence_word(Convergence convergence) {
  switch (convergence) {
    case Convergence::settled:
      return "settled";
    case Convergence::rough:
      return "rough";
    case Convergence::none:
      break;
  }
  return "none";
}

std::string convergence_words(const ErrorUntil& row) {
  const bool placed = row.distance_m.convergence != Convergence::none;
  const bool turned = row.turn_rad.convergence != Convergence::none;
  if (placed == turned) return convergence_word(row.convergence());
  return fmt::format("{}, {} none", convergence_word((placed ? row.distance_m : row.turn_rad).convergence),
                     placed ? "turn" : "place");
}

bool only_bounded(const Estimate& error) {
  return error.convergence == Convergence::rough && error.uncertainty >= error.value;
}

int finest(const Answer& answer) {
  return std::ranges::max_element(answer.runs, {}, &audit::ProgramRun::refinement)->refinement;
}

bool stiff_contacts(const Answer& answer) {
  return answer.springs_held && answer.contact_s > 0 && answer.contact_s < answer.h_s / finest(answer);
}

bool has_limit(const Answer& answer, std::size_t at) {
  return !answer.error_at.empty() && answer.error_at[at].convergence() != Convergence::none;
}

std::string no_limit_text(const Answer& answer) {
  return fmt::format("steps down to h/{} do not bring the runs together", finest(answer));
}

std::string lost_text(const Answer& answer) {
  return fmt::format("{} is off by more than a tenth of how far it has {} until then",
                     body_name(answer, answer.lost_body), answer.lost_turned ? "turned" : "gone");
}

const audit::Tried* cheapest(const Answer& answer) {
  const double own = answer.error_at[answer.tried_at].by(answer.by_turn).value;
  const audit::Tried* best = nullptr;
  for (const audit::Tried& one : answer.tried) {
    const Estimate& error = one.error[answer.tried_at];
    const bool keeps = error.value <= 1.1 * own && error.convergence != Convergence::none;
    if (keeps && one.work < (best != nullptr ? best->work : 0.95)) best = &one;
  }
  return best;
}

const char* unit(const Answer& answer) { return answer.by_turn ? "rad" : "m"; }

std::string most_text(const Estimate& error) {
  const double most = error.value + error.uncertainty;
  const double digit = std::pow(10.0, std::floor(std::log10(most)) - 1);  // the second
  return fmt::format("{:.2g}", std::ceil(most / digit * (1 - 1e-12)) * digit);
}

namespace {

std::string error_cell(const Estimate& error) {
  if (error.convergence == Convergence::none) return "no limit";
  if (error.value + error.uncertainty < Estimate::nothing) return fmt::format("below {:g}", Estimate::nothing);
  if (only_bounded(error)) return "at most " + most_text(error);
  return with_uncertainty(error.value, error.uncertainty);
}

/// A billionth of the most energy that there was, J: what is less is rounding, or nobody's concern.
double energy_rounding(const Answer& answer) {
  double most = 1e-3;
  for (const audit::EnergyPoint& point : answer.energy_over_time) {
    for (const double energy : {point.kinetic_J, point.potential_J}) {
      if (std::isfinite(energy)) most = std::max(most, std::fabs(energy));
    }
  }
  return 1e-9 * most;
}

std::string energy_error(const Answer& answer) {
  const Estimate& error = answer.energy.error_J;
  const double rounding = energy_rounding(answer);
  if (error.value + error.uncertainty <= rounding) return fmt::format("below {:.0e} J", rounding);
  return error.convergence == Convergence::none ? "without a limit" : error_cell(error) + " J";
}

/// The last that steps are told by and the one after it, the end, and of the others the first.
std::vector<std::size_t> shown_rows(const Answer& answer) {
  const std::size_t count = answer.error_at.size();
  std::set<std::size_t> rows{answer.told_at, std::min(answer.told_at + 1, count - 1), count - 1};
  for (std::size_t i = 0; i < count && rows.size() < most_rows; ++i) rows.insert(i);
  return {rows.begin(), rows.end()};
}

std::string errors_table(const Answer& answer) {
  TextTable table("rrrrll", {"until t, s", "error, m", "turned, rad", "order", "", "largest"});
  for (const std::size_t i : shown_rows(answer)) {
    const ErrorUntil& row = answer.error_at[i];
    table.add({fmt::format("{:.4g}", row.t_s), error_cell(row.distance_m), error_cell(row.turn_rad),
               row.order ? fmt::format("{:.2f}", *row.order) : "-", convergence_words(row),
               body_name(answer, row.body)});
  }
  return table.text();
}

std::string motion_line(const Answer& answer) {
  if (!answer.lost_at_s) return "the same motion to the end";
  return fmt::format("lost at {:.3g} s: {}", *answer.lost_at_s, lost_text(answer));
}

/// Where the program's own run is no number any more.
std::string diverged_line(const Answer& answer) {
  if (!answer.diverged) return "";
  const audit::Parting& where = *answer.diverged;
  return fmt::format("{} is no finite number from step {} on, t = {:.4g} s: what is told is of the time before",
                     body_name(answer, where.body), where.step, where.t_s);
}

/// Of one that has no limit, or of which only the size is known.
const char* part_without(Convergence convergence, const ErrorUntil& row) {
  if (row.distance_m.convergence != convergence) return "turns";
  return row.turn_rad.convergence != convergence ? "places" : "runs";
}

/// How finer runs are asked for.
std::string finer_runs(const Answer& answer) {
  std::vector<int> refinements;
  for (const audit::ProgramRun& run : answer.runs) {
    if (refinements.empty() || run.refinement > refinements.back()) refinements.push_back(run.refinement);
  }
  constexpr int most = 1024;
  for (int more = 2; more > 0 && 2 * refinements.back() <= most; --more) refinements.push_back(2 * refinements.back());
  return fmt::format("--refine {}", fmt::join(refinements, ","));
}

/// What is first known to its size only, what first has no limit, and where the motion is lost.
std::string verdict_line(const Answer& answer) {
  const auto first = [&](Convergence convergence) {
    const auto its = [](const ErrorUntil& row) { return row.convergence(); };
    const auto row = std::ranges::find(answer.error_at, convergence, its);
    const bool is_after = row != answer.error_at.end() && row->t_s > answer.lost_at_s.value_or(HUGE_VAL);
    return is_after ? answer.error_at.end() : row;
  };
  std::vector<std::string> words;
  if (const auto rough = first(Convergence::rough); rough != answer.error_at.end()) {
    const std::string part = part_without(Convergence::rough, *rough);
    words.push_back(fmt::format("until {:.3g} s the {} known to its size only: ± is more than a tenth of it",
                                rough->t_s,
                                part == "turns"    ? "turn is"
                                : part == "places" ? "error is"
                                                   : "error and the turn are each"));
  }
  const auto none = first(Convergence::none);
  if (none != answer.error_at.end()) {
    std::string text = no_limit_text(answer);
    if (const std::string part = part_without(Convergence::none, *none); part != "runs")
      text.replace(text.find("the runs"), 8, "the " + part);
    words.push_back(fmt::format("until {:.3g} s {}: nothing is extrapolated there", none->t_s, text));
    const bool is_chaos = answer.chaos_from_s && *answer.chaos_from_s <= none->t_s;
    if (!is_chaos && finest(answer) < 1024) {
      const char* or_not = stiff_contacts(answer) ? ", or bring out how soft its contacts are" : "";
      words.back() += fmt::format(", and finer ones may do{} ({})", or_not, finer_runs(answer));
    }
  }
  const bool is_lost = answer.lost_at_s && *answer.lost_at_s < answer.until_s;
  if (is_lost && !(answer.chaos_from_s && *answer.chaos_from_s <= *answer.lost_at_s)) {
    words.push_back(
        fmt::format("h = {:.3g} s is too coarse for this motion from {:.3g} s on", answer.h_s, *answer.lost_at_s));
  }
  return fmt::format("{}", fmt::join(words, "; "));
}

/// Whether what is wrong is the motion's own, or the step's.
std::string chaos_line(const Answer& answer) {
  if (!answer.growth) return "";
  constexpr const char* starts = "starts that differ by 1e-10 m";
  if (answer.chaos_from_s) {
    return fmt::format("from {:.3g} s on {} part by as much as the error: no step helps", *answer.chaos_from_s, starts);
  }
  const double apart_m = 1e-10 * *answer.growth;
  if (answer.flies_apart) {
    return fmt::format("none: {} end {:.2g} m apart, as nothing does at the smallest step: the step makes the error",
                       starts, apart_m);
  }
  const bool is_wrong = answer.lost_at_s || answer.error_at.back().distance_m.value > apart_m;
  const char* so = is_wrong ? ", so the step makes the error" : "";
  if (*answer.growth < 2) return fmt::format("none: {} stay as close{}", starts, so);
  return fmt::format("not yet: {} are at most {:.2g} m apart{}", starts, apart_m, so);
}

std::string steps_line(const Answer& answer) {
  if (!has_limit(answer, answer.told_at))
    return "none is told, nor what other settings leave: there is no limit to hold them against";
  std::vector<std::string> words;
  std::vector<std::string> finer;  // errors that no run is known to keep
  for (const audit::StepFor& one : answer.steps_for) {
    const std::string size = answer.by_turn     ? fmt::format("{:g} mrad", 1e3 * one.error)
                             : one.error < 9e-3 ? "1 mm"
                             : one.error < 9e-2 ? "1 cm"
                                                : "10 cm";
    if (!one.h_s) {
      finer.push_back(size);
    } else {
      words.push_back(size + ": " + (*one.h_s >= answer.h_s ? "this one" : fmt::format("{:.2g} s", *one.h_s)));
    }
  }
  if (!finer.empty()) {
    words.insert(words.begin(), fmt::format("{}: none down to {:.2g} s is known to keep it", fmt::join(finer, ", of "),
                                            answer.h_s / finest(answer)));
  }
  return fmt::format("for {} until {:.3g} s of {}", answer.by_turn ? "a turn" : "an error", answer.steps_for_t_s,
                     fmt::join(words, ", of "));
}

/// What the user asked for, where nothing can be told of it.
std::string asked_in_vain(const Answer& answer) {
  std::vector<std::string> sets;
  for (const audit::Tried& one : answer.tried) {
    if (one.asked) sets.push_back(one.set);
  }
  return sets.empty() ? "" : fmt::format("{}: there is no limit to hold them against", fmt::join(sets, ", "));
}

/// The best of what was tried, and all that the user asked for, beside the program's own; what changes nothing in a
/// clause.
std::string tried_line(const Answer& answer) {
  std::vector<const audit::Tried*> order;
  for (const audit::Tried& one : answer.tried) {
    if (one.asked || !std::isnan(one.error[answer.tried_at].value)) order.push_back(&one);
  }
  const auto error = [&](const audit::Tried* one) { return one->error[answer.tried_at].value; };
  const auto ended = [&](const audit::Tried* one) { return std::isnan(error(one)); };
  std::ranges::stable_sort(order, [&](const audit::Tried* a, const audit::Tried* b) {
    return ended(a) || ended(b) ? ended(a) < ended(b) : error(a) < error(b);
  });
  if (!has_limit(answer, answer.tried_at)) return asked_in_vain(answer);
  if (order.empty()) return "";
  const auto shown = [&](const Estimate& its) {
    return (only_bounded(its) ? "at most " + most_text(its) : fmt::format("{:.3g}", its.value)) + " " + unit(answer);
  };
  const std::string own = shown(answer.error_at[answer.tried_at].by(answer.by_turn));
  std::vector<std::string> words{fmt::format("until {:.3g} s as it is: {}", answer.error_at[answer.tried_at].t_s, own)};
  std::vector<std::string> same;
  std::size_t told = 0;
  for (const audit::Tried* one : order) {
    const std::string text = ended(one)                  ? "has ended before"
                             : one->asked && one->is_own ? "changes nothing"
                                                         : shown(one->error[answer.tried_at]);
    if (text == own && !one->asked) {
      same.push_back(one->set);
    } else if (told++ < most_tried || one->asked) {
      words.push_back(one->set + ": " + text);
    }
  }
  std::string text = fmt::format("{}", fmt::join(words, ", "));
  if (!same.empty()) text += fmt::format("; the same to three digits: {}", fmt::join(same, ", "));
  if (const audit::Tried* one = cheapest(answer)) {
    text += fmt::format("; {} keeps it at {:.2g} of the solver's work", one->set, one->work);
  }
  return text;
}

std::string softness_line(const Answer& answer) {
  if (!answer.softness_m) return "";
  const double own = answer.error_at[answer.tried_at].distance_m.value;
  const double more = *answer.softness_m - answer.softness_of_step_m;
  if (!(more > 0.1 * own) || !(more > 1e-6)) return "";  // m: that no one asks for
  const bool damped = answer.work.damping != 0;
  const bool soft = answer.joints > 0 || answer.contacts > 0;
  return fmt::format("counts: with {} held as numbers a smaller step leads {:.2g} m elsewhere",
                     damped && soft ? "ERP, CFM and damping"
                     : damped       ? "damping"
                                    : "ERP and CFM",
                     more);
}

/// Where the energy goes; parts below a thousandth of the largest are left out.
std::string work_line(const Answer& answer) {
  const audit::Work& work = answer.work;
  const double of_step = answer.energy.end_J - answer.energy.begin_J - work.sum();
  const std::array<std::pair<const char*, double>, 8> parts{{{"added forces", work.added},
                                                             {"motors", work.motors},
                                                             {"stops", work.stops},
                                                             {"joints", work.joints},
                                                             {"contacts", work.contacts},
                                                             {"damping", work.damping},
                                                             {"the program's own changes", work.program},
                                                             {"the step's own", of_step}}};
  double largest = 1e3 * energy_rounding(answer);
  for (const auto& [name, value] : parts) largest = std::max(largest, std::fabs(value));
  std::vector<std::string> words;
  for (const auto& [name, value] : parts) {
    if (std::fabs(value) >= 1e-3 * largest) words.push_back(fmt::format("{} {:+.3g} J", name, value));
  }
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string percent(std::uint64_t part, std::uint64_t whole) {
  return fmt::format("{:.3g} %", 100.0 * static_cast<double>(part) / static_cast<double>(whole));
}

/// The widest gap, and the motor that is at its limit for longest.
std::string joints_line(const Answer& answer) {
  std::vector<std::string> words;
  constexpr double no_gap_m = 1e-6;  // nobody's concern
  if (answer.gap.joint > 0 && answer.gap.largest_m < no_gap_m) {
    words.push_back(fmt::format("none is more than {:g} m apart", no_gap_m));
  } else if (answer.gap.joint > 0) {
    words.push_back(fmt::format("{} is the worst: {:.3g} m apart at {:.3g} s", joint_name(answer, answer.gap.joint),
                                answer.gap.largest_m, answer.gap.t_s));
  }
  const auto motor = std::ranges::max_element(answer.joint_summaries, {}, &audit::JointSummary::at_limit);
  if (motor != answer.joint_summaries.end() && motor->at_limit.value_or(0) > 0) {
    words.push_back(fmt::format("the motor of {} is at its limit in {} of its steps", joint_name(answer, motor->number),
                                percent(*motor->at_limit, motor->steps)));
  }
  return fmt::format("{}", fmt::join(words, "; "));
}

/// Of the bodies that touch most deeply.
std::string contact_words(const Answer& answer) {
  const auto deepest = std::ranges::find(answer.joint_summaries, 0U, &audit::JointSummary::number);
  if (deepest == answer.joint_summaries.end()) return "";
  std::string text = ", " + body_name(answer, deepest->bodies[0]);
  text += deepest->bodies[1] == 0 ? " on the world" : " on " + body_name(answer, deepest->bodies[1]);
  if (deepest->rough > 0) text += ", sliding in " + percent(deepest->sliding, deepest->rough) + " of its steps";
  return text;
}

}  // namespace

AuditLines audit_lines(const Answer& answer) {
  AuditLines lines;
  const auto line = [&lines](const char* name, std::string what) {
    if (!what.empty()) lines.emplace_back(name, std::move(what));
  };
  if (!answer.reason.empty()) return lines;
  line("error",
       fmt::format("largest distance of a body from where it would be at a step of 0{} (steps to h/{}, {}{} held)",
                   stiff_contacts(answer) ? " with rigid contacts" : "", finest(answer),
                   answer.springs_held ? "springs" : "numbers", answer.contacts_held ? " and contacts" : ""));
  line("motion", motion_line(answer));
  line("diverged", diverged_line(answer));
  line("verdict", verdict_line(answer));
  line("step", steps_line(answer));
  line("chaos", chaos_line(answer));
  line("softness", softness_line(answer));
  line("settings", tried_line(answer));
  const auto but_for_rounding = [&](double energy) {
    return std::fabs(energy) <= energy_rounding(answer) ? 0 : energy;
  };
  line("energy",
       fmt::format("{:.4g} J at the start, {:.4g} J at the end, error {}", but_for_rounding(answer.energy.begin_J),
                   but_for_rounding(answer.energy.end_J), energy_error(answer)));
  line("work", work_line(answer));
  line("joints", joints_line(answer));
  if (answer.contacts > 0) {
    line("contacts",
         fmt::format("{} at a time, {:.3g} m deep at most{}", answer.contacts, answer.depth_m, contact_words(answer)));
  }
  return lines;
}

std::string audit_text(const Answer& answer) {
  std::string text = answer.program + "\n";
  text += audit_head(answer) + "\n";
  if (answer.parting) {
    const audit::Parting& parting = *answer.parting;
    text += fmt::format("two unchanged runs part at step {}, t = {:.4g} s{}\n", parting.step, parting.t_s,
                        parting.body > 0 ? ", with " + body_name(answer, parting.body)
                                         : ", in their steps or in what bodies there are");
  }
  if (!answer.reason.empty()) text += "no error can be told: " + answer.reason + "\n";
  if (answer.reason.empty()) text += "\n" + errors_table(answer) + "\n";
  for (const auto& [name, what] : audit_lines(answer)) text += fmt::format("{:<9}  {}\n", name, what);
  if (answer.messages > 0) {
    text += fmt::format("{:<9}  {}, the first at {:.4g} s: {}\n", "ODE says",
                        count(answer.messages, "message", "messages"), answer.first_message_t_s, answer.first_message);
  }
  const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n'));
  const std::size_t room = most_lines - std::min(most_lines, lines);
  const std::size_t told = answer.limits.size() <= room ? answer.limits.size() : room - std::min<std::size_t>(room, 1);
  for (std::size_t i = 0; i < told; ++i) {
    text += fmt::format("{:<9}  {}\n", i == 0 ? "limits" : "", answer.limits[i]);
  }
  if (told < answer.limits.size())
    text += fmt::format("{:<9}  and {} more on the page\n", "", answer.limits.size() - told);
  return text;
}

}  // namespace odeval
