#include "report/audit_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "output/audit_answer.hpp"
#include "report/prose.hpp"
#include "report/sections.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

using audit::Answer;
using audit::Estimate;
using audit::JointSummary;
using audit::Work;

/// audit/*.mustache: a section each.
constexpr Embedded prose[] = {
#include "audit_prose.inc"
};

// Colours of the palette. Runs have the first ones, by their refinements.
constexpr int ink = 4;
constexpr int first_energy = 5;
constexpr int first_work = 7;

/// Without what a sum of steps has rounded.
double time(double t_s) { return std::round(t_s * 1e6) / 1e6; }

std::string number(double value) { return std::isfinite(value) ? shown(value) : "not finite"; }

std::string run_name(int refinement) {
  return refinement == 1 ? "this run, steps of h" : fmt::format("steps of h/{}", refinement);
}

/// Refinements of the runs whose errors are told, this one's first.
std::vector<int> refinements(const Answer& answer) {
  std::vector<int> all;
  for (const audit::ProgramRun& run : answer.runs) {
    if (all.empty() || run.refinement > all.back()) all.push_back(run.refinement);
  }
  return all;
}

int colour_of_run(std::size_t run) {
  const int number = static_cast<int>(run);
  return number < ink ? number : (number + 1) % method_colours;
}

Cell cell(const Answer& answer, const Estimate& error) {
  if (error.convergence == audit::Convergence::none) return Missing{no_limit_text(answer)};
  if (std::isnan(error.value)) return Missing{"this run has ended before"};
  if (only_bounded(error)) return "at most " + most_text(error);
  return error.value;
}
Cell uncertainty(const Answer& answer, const Estimate& error) {
  if (error.convergence == audit::Convergence::none) return Missing{no_limit_text(answer)};
  if (std::isnan(error.value)) return Missing{"this run has ended before"};
  if (only_bounded(error)) return Missing{"it is as large as the error, of which only the most is known"};
  return error.uncertainty;
}

Figure errors_over_time(const Answer& answer) {
  Panel panel{.x_label = "time, s", .y_label = "error until then, m", .log_y = true};
  const std::vector<int> all = refinements(answer);
  for (std::size_t run = 0; run < all.size(); ++run) {
    Series series{.label = run_name(all[run]), .x = {}, .y = {}, .colour = colour_of_run(run)};
    for (const audit::ErrorPoint& point : answer.error_over_time) {
      series.x.push_back(point.t_s);
      series.y.push_back(run < point.distance_m.size() ? point.distance_m[run] : NAN);
    }
    panel.series.push_back(std::move(series));
  }
  Series limit{.label = "uncertainty of the limit", .x = {}, .y = {}, .colour = ink, .dashed = true};
  for (const audit::ErrorPoint& point : answer.error_over_time) {
    limit.x.push_back(point.t_s);
    limit.y.push_back(point.uncertainty_m);
  }
  panel.series.push_back(std::move(limit));
  if (answer.lost_at_s) panel.shade = Shade{*answer.lost_at_s, lost_text(answer)};
  return {.name = "error-over-time", .panels = {std::move(panel)}};
}

Figure order(const Answer& answer) {
  const audit::ErrorUntil& until = answer.error_at[answer.told_at];
  Panel panel{.x_label = "step, s", .y_label = "error, " + std::string(unit(answer)), .log_x = true, .log_y = true};
  const std::vector<int> all = refinements(answer);
  Series first{.label = "in proportion to the step", .x = {}, .y = {}, .colour = ink, .dashed = true};
  for (std::size_t run = 0; run < std::min(all.size(), until.of_runs.size()); ++run) {
    const double step = answer.h_s / all[run];
    panel.series.push_back({.label = run_name(all[run]),
                            .x = {step},
                            .y = {until.of_runs[run]},
                            .mark = Mark::points,
                            .colour = colour_of_run(run)});
    first.x.push_back(step);
    first.y.push_back(until.of_runs.front() / all[run]);
  }
  panel.series.push_back(std::move(first));
  return {.name = "order", .panels = {std::move(panel)}};
}

Table errors_until(const Answer& answer) {
  Table table{.name = "error-until",
              .columns = {"until t, s", "error, m", "±, m", "turned, rad", "±, rad", "order", "known", "largest"}};
  for (const audit::ErrorUntil& row : answer.error_at) {
    table.rows.push_back({time(row.t_s), cell(answer, row.distance_m), uncertainty(answer, row.distance_m),
                          cell(answer, row.turn_rad), uncertainty(answer, row.turn_rad),
                          row.order ? Cell(*row.order) : Missing{"the runs do not differ"}, convergence_words(row),
                          body_name(answer, row.body)});
  }
  return table;
}

Table steps_for(const Answer& answer) {
  Table table{.name = "steps-for", .columns = {answer.by_turn ? "turned, rad" : "error, m", "step, s"}};
  for (const audit::StepFor& one : answer.steps_for) {
    table.rows.push_back({one.error, one.h_s ? Cell(*one.h_s) : Missing{"none that was tried is known to keep it"}});
  }
  return table;
}

Content errors(const Answer& answer) {
  std::vector<Exhibit> exhibits{order(answer), errors_until(answer), steps_for(answer)};
  if (answer.by_turn) {
    exhibits.emplace_back(
        Lacking{"error-over-time", "next to nothing of it is a distance, and the table tells the turn"});
  } else {
    exhibits.emplace_back(errors_over_time(answer));
  }
  return {{{"step", number(answer.h_s)},
           {"until", number(time(answer.steps_for_t_s))},
           {"unit", unit(answer)},
           {"no_limit", no_limit_text(answer)},
           {"lost", answer.lost_at_s ? number(*answer.lost_at_s) : ""}},
          std::move(exhibits)};
}

Content bodies(const Answer& answer) {
  std::vector<const audit::BodyError*> rows;
  for (const audit::BodyError& row : answer.error_of_body) {
    if (row.t_s == answer.steps_for_t_s) rows.push_back(&row);
  }
  std::ranges::stable_sort(rows, std::ranges::greater(), [&](const audit::BodyError* row) {
    return (answer.by_turn ? row->turn_rad : row->distance_m).value;
  });
  Table table{.name = "bodies", .columns = {"body", "error, m", "±, m", "turned, rad", "±, rad"}};
  for (const audit::BodyError* row : rows) {
    table.rows.push_back({body_name(answer, row->body), cell(answer, row->distance_m),
                          uncertainty(answer, row->distance_m), cell(answer, row->turn_rad),
                          uncertainty(answer, row->turn_rad)});
  }
  return {{{"until", number(time(answer.steps_for_t_s))}}, {std::move(table)}};
}

Content settings(const Answer& answer) {
  const bool turned = answer.by_turn;
  Table table{.name = "settings",
              .columns = {"setting", turned ? "turned, rad" : "error, m", turned ? "±, rad" : "±, m", "work", "time"}};
  Estimate own = answer.error_at[answer.tried_at].by(turned);
  if (!has_limit(answer, answer.tried_at)) own.convergence = audit::Convergence::none;
  table.rows.push_back({"as it is", cell(answer, own), uncertainty(answer, own), 1.0, 1.0});
  for (const audit::Tried& tried : answer.tried) {
    const Estimate& error = tried.error[answer.tried_at];
    table.rows.push_back(
        {tried.set + (tried.is_own ? ", which changes nothing" : ""), cell(answer, error), uncertainty(answer, error),
         std::isnan(tried.work) ? Cell(Missing{"it is not ODE's solver"}) : Cell(tried.work), tried.cpu});
  }
  return {{{"until", number(time(answer.error_at[answer.tried_at].t_s))}}, {std::move(table)}};
}

/// A line over time of what `value` takes from a point.
template <class Take>
Series over_time(const Answer& answer, const char* label, int colour, const Take& value) {
  Series series{.label = label, .x = {}, .y = {}, .colour = colour};
  for (const audit::EnergyPoint& point : answer.energy_over_time) {
    series.x.push_back(point.t_s);
    series.y.push_back(value(point));
  }
  return series;
}

struct WorkRow {
  const char* name;
  double Work::*part;
};
constexpr WorkRow works[] = {{"forces that the program adds", &Work::added},
                             {"motors", &Work::motors},
                             {"stops", &Work::stops},
                             {"joints", &Work::joints},
                             {"contacts", &Work::contacts},
                             {"damping", &Work::damping},
                             {"the program's own changes", &Work::program}};

Content energy(const Answer& answer) {
  using Point = audit::EnergyPoint;
  const auto whole = [](const Point& point) { return point.kinetic_J + point.potential_J; };
  const double begin = answer.energy.begin_J;
  Panel energies{.x_label = "time, s", .y_label = "energy, J"};
  energies.series.push_back(over_time(answer, "kinetic", first_energy, [](const Point& p) { return p.kinetic_J; }));
  energies.series.push_back(
      over_time(answer, "of gravity", first_energy + 1, [](const Point& p) { return p.potential_J; }));
  energies.series.push_back(over_time(answer, "both", ink, whole));
  Panel work{.x_label = "time, s", .y_label = "work since the start, J"};
  Table table{.name = "work-total", .columns = {"by", "work, J"}};
  int colour = first_work;
  for (const WorkRow& row : works) {
    Series series = over_time(answer, row.name, colour++, [&](const Point& p) { return p.work.*row.part; });
    const bool is_there = std::ranges::any_of(series.y, [](double y) { return y != 0; });
    if (is_there) work.series.push_back(std::move(series));
    table.rows.push_back({row.name, answer.work.*row.part});
  }
  work.series.push_back(
      over_time(answer, "the step's own", ink, [&](const Point& p) { return whole(p) - begin - p.work.sum(); }));
  table.rows.push_back({"the step's own", answer.energy.end_J - begin - answer.work.sum()});
  return {{{"end", number(time(answer.runs.front().simulated_s))}},
          {Figure{.name = "energy", .panels = {std::move(energies)}},
           Figure{.name = "work", .panels = {std::move(work)}}, std::move(table)}};
}

Content joints(const Answer& answer) {
  Panel panel{.x_label = "time, s", .y_label = "gap, m"};
  panel.series.push_back(over_time(answer, "", ink, [](const audit::EnergyPoint& point) { return point.gap_m; }));
  Table table{.name = "joints",
              .columns = {"joint", "kind", "gap, m", "at t, s", "force, N", "torque, N m", "work, J", "of motors, J",
                          "of stops, J", "steps at its limit", "steps at a stop"}};
  const auto cell = [](double number) { return std::isnan(number) ? Cell(Missing{"not followed"}) : Cell(number); };
  const auto steps = [&](const std::optional<std::uint64_t>& of) { return cell(of ? static_cast<double>(*of) : NAN); };
  for (const JointSummary& joint : answer.joint_summaries) {
    if (joint.number == 0) continue;
    table.rows.push_back({joint_name(answer, joint.number), joint.kind, cell(joint.largest_m), cell(joint.largest_t_s),
                          joint.force_N, joint.torque_Nm, joint.work_J, cell(joint.motor_work_J),
                          cell(joint.stop_work_J), steps(joint.at_limit), steps(joint.at_stop)});
  }
  return {{}, {Figure{.name = "gaps", .panels = {std::move(panel)}}, std::move(table)}};
}

std::string touching(const Answer& answer, const JointSummary& contact) {
  const auto name = [&](std::uint32_t body) { return body == 0 ? std::string("the world") : body_name(answer, body); };
  return name(contact.bodies[0]) + ", " + name(contact.bodies[1]);
}

Content contacts(const Answer& answer) {
  Panel panel{.x_label = "time, s", .y_label = "depth, m"};
  panel.series.push_back(over_time(answer, "", ink, [](const audit::EnergyPoint& point) { return point.depth_m; }));
  Table table{.name = "contacts",
              .columns = {"bodies", "depth, m", "at t, s", "steps", "normal force, N", "work, J", "share of friction",
                          "sliding, %"}};
  for (const JointSummary& contact : answer.joint_summaries) {
    if (contact.number != 0) continue;
    const bool rough = contact.rough > 0;
    const double sliding = 100.0 * static_cast<double>(contact.sliding) / static_cast<double>(contact.rough);
    table.rows.push_back({touching(answer, contact), contact.largest_m, contact.largest_t_s,
                          static_cast<double>(contact.steps), contact.force_N, contact.work_J,
                          rough ? Cell(contact.friction_share) : Missing{"without friction, or with all there may be"},
                          rough ? Cell(sliding) : Missing{"without friction, or with all there may be"}});
  }
  return {{}, {Figure{.name = "depth", .panels = {std::move(panel)}}, std::move(table)}};
}

Content runs(const Answer& answer) {
  Table table{.name = "runs", .columns = {"run", "end", "steps", "until t, s", "CPU, s"}};
  for (const audit::ProgramRun& run : answer.runs) {
    table.rows.push_back({run.what, run.end, static_cast<double>(run.steps), time(run.simulated_s), run.cpu_s});
  }
  return {{}, {std::move(table)}};
}

Content limits(const Answer& answer) {
  Items items;
  for (const std::string& limit : answer.limits) items.push_back({{"limit", limit}});
  return {{{"limits", std::move(items)}}, {}};
}

std::vector<Section> sections(const Answer& answer) {
  std::vector<Section> all;
  const auto add = [&](std::string_view name, Content content) {
    const auto* const text = std::ranges::find(prose, name, &Embedded::name);
    all.push_back(section_of(std::string(name), text->text, std::move(content)));
  };
  const bool judged = answer.reason.empty();
  if (judged) add("error", errors(answer));
  if (judged) add("settings", settings(answer));
  if (answer.bodies > 0) add("energy", energy(answer));
  if (answer.joints > 0) add("joints", joints(answer));
  if (answer.contacts > 0) add("contacts", contacts(answer));
  if (judged) add("bodies", bodies(answer));
  if (!answer.limits.empty()) add("limits", limits(answer));
  add("runs", runs(answer));
  return all;
}

/// The answer in a sentence.
std::string lead(const Answer& answer) {
  if (!answer.reason.empty()) return "No error can be told: " + answer.reason + ".";
  const audit::ErrorUntil& row = answer.error_at[answer.told_at];
  if (row.convergence() == audit::Convergence::none) {
    return fmt::format("Until {} s {}: no error can be told.", number(time(row.t_s)), no_limit_text(answer));
  }
  const Estimate& off = row.by(answer.by_turn);
  const std::string far = only_bounded(off)
                              ? fmt::format("at most {} {}", most_text(off), unit(answer))
                              : "up to " + shown(Finding{"", unit(answer), off.value, off.uncertainty, ""});
  std::string text =
      fmt::format(fmt::runtime(answer.by_turn ? "Until {} s {} is turned {} from how it would be at a step "
                                                "of 0; it is where it would be, to a thousandth of that."
                                              : "Until {} s {} is {} from where it would be at a step of 0."),
                  number(time(row.t_s)), body_name(answer, row.body), far);
  if (answer.diverged) {
    text += fmt::format(" From {} s on {} is no finite number.", number(answer.diverged->t_s),
                        body_name(answer, answer.diverged->body));
  }
  const bool loses_its_limit = std::ranges::any_of(answer.error_at, [&](const audit::ErrorUntil& its) {
    return its.convergence() == audit::Convergence::none && its.t_s <= answer.lost_at_s.value_or(HUGE_VAL);
  });
  if (loses_its_limit) text += fmt::format(" After that {}.", no_limit_text(answer));
  if (answer.lost_at_s) text += fmt::format(" From {} s on it is another motion.", number(*answer.lost_at_s));
  return text;
}

}  // namespace

Page audit_page(const Answer& answer, const AuditPageParts& parts) {
  Anchors anchors;
  for (const char* const fixed : {"files", "made-with"}) anchors.take(fixed);
  SectionWriter writer(anchors);
  const auto written = [&](const std::vector<Section>& all) {
    for (const Section& section : all) anchors.take(section.name);
    Items items;
    for (const Section& section : all) items.push_back(writer.values(section));
    return items;
  };
  Items items = written(sections(answer));
  if (parts.pictures) {
    Items pictures = written(parts.pictures());
    const auto behind_errors = items.begin() + (answer.reason.empty() ? 1 : 0);
    items.insert(behind_errors, std::make_move_iterator(pictures.begin()), std::make_move_iterator(pictures.end()));
  }
  Items lines;
  for (const auto& [name, what] : audit_lines(answer)) lines.push_back({{"name", name}, {"what", what}});
  Items environment;
  for (const auto& [name, what] : parts.environment) environment.push_back({{"name", name}, {"what", what}});
  const Values values{{"title", "How wrong is this simulation?"},
                      {"style", page_layout("style")},
                      {"lead", lead(answer)},
                      {"program", answer.program},
                      {"about", audit_head(answer)},
                      {"lines", std::move(lines)},
                      {"sections", std::move(items)},
                      {"command", parts.command},
                      {"environment", std::move(environment)}};
  return {filled("audit", page_layout("audit"), values, escaped), writer.missing()};
}

}  // namespace odeval::report
