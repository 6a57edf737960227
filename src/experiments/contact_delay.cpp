// When ODE sees the wall, and what moves that: claims C11a and C11b, the report's Figures 6.3 and 6.4.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"
#include "model/generate.hpp"
#include "reference/closed_form/analytic.hpp"
#include "reference/planar/wall_bounce.hpp"
#include "report/claims.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;
using report::Cell;
using report::Figure;
using report::Missing;
using report::Panel;
using report::Table;

constexpr const char* scenario_name = "wall_pendulum";
constexpr const char* steppers[] = {"ode-step-double", "ode-quickstep-double"};
constexpr int claimed_steps = 10;  // report, 6.3
constexpr double vertical_rad = -std::numbers::pi / 2;

/// Where the side of the hanging link is, m.
double side_of_link(const Scenario& scenario) {
  return scenario.planar->frame.hinge_m[0] - scenario.planar->links.front().width_m / 2;
}

struct Setting {
  std::string name;
  OdeSettings ode;
};

std::vector<Setting> settings(const OdeSettings& file) {
  std::vector<Setting> all(5, Setting{{}, file});
  all[0].name = "as in the file";
  all[1].name = "ERP 0";
  all[1].ode.erp = 0;
  all[2].name = "CFM 0";
  all[2].ode.cfm = 0;
  all[3].name = "ERP 0 and CFM 0";
  all[3].ode.erp = 0;
  all[3].ode.cfm = 0;
  all[4].name = "ERP 0.8";
  all[4].ode.erp = 0.8;
  return all;
}

/// What mathematics says about the first swing of the scenario.
struct Truth {
  double vertical_s;  // when the link hangs; a wall may have stopped it before, which this ignores
  double touch_s;
};

Truth truth_of(const Scenario& scenario) {
  const reference::FreePendulum swing(scenario, {scenario.planar->q0.front(), scenario.planar->qd0.front()});
  const double touch = reference::free_arc(scenario).low;
  return {swing.passage(vertical_rad, false).value().t_s, swing.passage(touch, false).value().t_s};
}

struct Contact {
  double face_m;
  double step_s;
  std::size_t setting;
  const char* stepper;
  Truth truth;
  std::optional<long> step;  // the step that found the first contact
  double gap_m = 0;          // of the hinge at that time
  double time_s() const { return static_cast<double>(step.value()) * step_s; }
  double after(double t_s) const { return (time_s() - t_s) / step_s; }
};

Scenario first_swing(const Scenario& file, double face_m, double step_s) {
  Scenario scenario = file;
  change_planar(scenario, [face_m](PlanarView& view) { view.wall->face_m = face_m; });
  scenario.step_s = step_s;
  scenario.duration_s = 0.6;  // the first touch is near 0.49 s
  return scenario;
}

std::vector<Contact> measure_all(const Scenario& file, const std::vector<Setting>& all) {
  std::vector<Contact> contacts;
  for (const double face_m : {file.planar->wall->face_m, side_of_link(file)}) {
    for (const double step_s : {file.step_s, file.step_s / 10}) {
      const Scenario scenario = first_swing(file, face_m, step_s);
      Evaluator evaluator(scenario);
      const Truth truth = truth_of(scenario);
      for (std::size_t s = 0; s < all.size(); ++s) {
        for (const char* stepper : steppers) {
          const Evaluation run = evaluator.evaluate(*available(stepper), all[s].ode);
          Contact contact{face_m, step_s, s, stepper, truth, std::nullopt};
          if (!run.outcome.impacts.empty()) {
            contact.step = std::lround(run.outcome.impacts.front().t / step_s);
            contact.gap_m = run.trace.gap.at(static_cast<std::size_t>(*contact.step));
          }
          contacts.push_back(contact);
        }
      }
    }
  }
  return contacts;
}

const Contact& find(const std::vector<Contact>& contacts, double face_m, double step_s, std::size_t setting,
                    const char* stepper) {
  return *std::ranges::find_if(contacts, [&](const Contact& contact) {
    return contact.face_m == face_m && contact.step_s == step_s && contact.setting == setting &&
           contact.stepper == stepper;
  });
}

/// With the digits that tell steps apart.
std::string shown_time(double t_s) { return fmt::format("{:.6f}", t_s); }

Table delays(const std::vector<Contact>& contacts, const std::vector<Setting>& all) {
  Table table{.name = "contact-delay",
              .columns = {"wall's face at, m", "h, s", "settings", "true touch, s", "dWorldStep: contact, s",
                          "steps after q = -pi/2", "steps after the true touch", "gap of the hinge then, m",
                          "QuickStep: contact, s", "QuickStep: steps after the true touch"}};
  for (const Contact& contact : contacts) {
    if (contact.stepper != steppers[0]) continue;
    const Contact& quick = find(contacts, contact.face_m, contact.step_s, contact.setting, steppers[1]);
    std::vector<Cell> row{contact.face_m, contact.step_s, all[contact.setting].name, shown_time(contact.truth.touch_s)};
    const Missing none{"no contact was found"};
    if (contact.step) {
      row.insert(row.end(), {shown_time(contact.time_s()), contact.after(contact.truth.vertical_s),
                             contact.after(contact.truth.touch_s), contact.gap_m});
    } else {
      row.insert(row.end(), {none, none, none, none});
    }
    if (quick.step) {
      row.insert(row.end(), {shown_time(quick.time_s()), quick.after(quick.truth.touch_s)});
    } else {
      row.insert(row.end(), {none, none});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// A move of the first contact. Contacts are found at the ends of steps, so each of the two times it lies between is
/// known to one step, and the move to one step either way.
struct Move {
  double s;
  double step_s;
};

std::optional<Move> move_between(const Contact& one, const Contact& other) {
  if (!one.step || !other.step) return std::nullopt;
  return Move{std::fabs(one.time_s() - other.time_s()), std::max(one.step_s, other.step_s)};
}

/// The largest that ERP and CFM make at that step, for both faces and steppers; nothing when a run found no contact.
std::optional<Move> moved_by_settings(const std::vector<Contact>& contacts, double step_s) {
  Move most{0, step_s};
  for (const Contact& contact : contacts) {
    if (contact.step_s != step_s) continue;
    const auto move = move_between(contact, find(contacts, contact.face_m, step_s, 0, contact.stepper));
    if (!move) return std::nullopt;
    most.s = std::max(most.s, move->s);
  }
  return most;
}

std::optional<Move> moved_by_face(const std::vector<Contact>& contacts, const Scenario& file, double step_s) {
  return move_between(find(contacts, file.planar->wall->face_m, step_s, 0, steppers[0]),
                      find(contacts, side_of_link(file), step_s, 0, steppers[0]));
}

/// The delay that the report saw: of the first contact after q = -pi/2, at its wall, step and settings.
std::optional<Move> delay_of(const std::vector<Contact>& contacts, const Scenario& file) {
  const Contact& usual = find(contacts, file.planar->wall->face_m, file.step_s, 0, steppers[0]);
  if (!usual.step) return std::nullopt;
  return Move{usual.time_s() - usual.truth.vertical_s, usual.step_s};
}

void add_findings(Findings& findings, const std::vector<Contact>& contacts, const Scenario& file) {
  const double face_m = file.planar->wall->face_m;
  const Contact& usual = find(contacts, face_m, file.step_s, 0, steppers[0]);
  const std::string settings = fmt::format("face at {} m, h = {} s", face_m, file.step_s);
  const std::string none = "a run found no contact";
  const auto add = [&](const std::string& name, const std::string& meaning, std::optional<double> value) {
    findings.add(name, value ? measured(meaning, "steps", *value) : unavailable(meaning, "steps", none));
  };
  const auto from = [](const Contact& contact, double t_s) {
    return contact.step ? std::optional(contact.after(t_s)) : std::nullopt;
  };
  add("C11a.after_vertical", "first contact after q = -pi/2, " + settings, from(usual, usual.truth.vertical_s));
  add("C11a.after_touch", "first contact after the true touch, " + settings, from(usual, usual.truth.touch_s));

  const std::optional<Move> delay = delay_of(contacts, file);
  const auto add_share = [&](const std::string& name, const std::string& meaning, const std::optional<Move>& move) {
    const std::string whole = meaning + fmt::format(", as a share of the delay after q = -pi/2, {}", settings);
    findings.add(name, move && delay ? known_by(report::Source::step,
                                                measured_ratio(whole, move->s, delay->s, move->step_s, delay->step_s))
                                     : unavailable(whole, "", none));
  };
  add_share("C11b.by_settings", "largest move of the first contact by ERP and CFM, both faces and steppers",
            moved_by_settings(contacts, file.step_s));
  add_share("C11b.by_face",
            fmt::format("move of the first contact by the face from {} to {} m", face_m, side_of_link(file)),
            moved_by_face(contacts, file, file.step_s));
}

/// The moves at both steps, ms.
std::vector<report::Values> moves(const std::vector<Contact>& contacts, const Scenario& file) {
  std::vector<report::Values> all;
  for (const double step_s : {file.step_s, file.step_s / 10}) {
    const auto by_settings = moved_by_settings(contacts, step_s);
    const auto by_face = moved_by_face(contacts, file, step_s);
    if (!by_settings || !by_face) continue;
    all.push_back({{"step", step_s},
                   {"by_settings", shown(1e3 * by_settings->s)},
                   {"by_face", shown(1e3 * by_face->s)},
                   {"known_to", shown(1e3 * step_s)}});
  }
  return all;
}

Panel angle_panel(const Trace& trace, const Reference& reference, double from_s, double until_s, bool points) {
  const Span rows = rows_between(trace.t, from_s, until_s);
  Panel panel{.x_label = "t, s", .y_label = "q, rad"};
  panel.series.push_back(curve("reference", part(reference.trace.t, rows), part(reference.trace.q.front(), rows),
                               colour_of(catalogue::reference_method), true));
  panel.series.push_back(curve(steppers[0], part(trace.t, rows), part(trace.q.front(), rows), colour_of(steppers[0])));
  if (points) panel.series.back().mark = report::Mark::line_and_points;
  panel.series.push_back(curve("q = -pi/2", {trace.t[rows.first], trace.t[rows.end - 1]}, {vertical_rad, vertical_rad},
                               guide_colour, true));
  return panel;
}

Figure whole_motion(Evaluator& evaluator, const Evaluation& run) {
  Figure figure{.name = "fig-6-3"};
  figure.panels.push_back(angle_panel(run.trace, evaluator.reference(), 0, evaluator.scenario().duration_s, false));
  figure.panels.back().shade = lost_shade(evaluator, run);
  return figure;
}

Figure first_contact(Evaluator& evaluator, const Evaluation& run, const Evaluation& flush_run,
                     Evaluator& flush_evaluator) {
  const Scenario& scenario = evaluator.scenario();
  const auto panel = [](Evaluator& of, const Evaluation& trace) {
    const double touch_s = truth_of(of.scenario()).touch_s;
    const double h = of.scenario().step_s;
    return angle_panel(trace.trace, of.reference(), touch_s - 15 * h, touch_s + 10 * h, true);
  };
  Figure figure{.name = "fig-6-4", .columns = 2};
  figure.panels.push_back(panel(evaluator, run));
  figure.panels.push_back(panel(flush_evaluator, flush_run));
  figure.panels[0].title = fmt::format("face at {} m", scenario.planar->wall->face_m);
  figure.panels[1].title = fmt::format("face at {} m", side_of_link(scenario));
  return figure;
}

Table bounces(Evaluator& evaluator, const Evaluation& run) {
  const Reference& reference = evaluator.reference();
  const Column drift = energy_drift(run.trace);
  Table table{.name = "contact-bounces",
              .columns = {"bounce", "contact, s", "after the reference's touch, steps", "rate before, rad/s",
                          "rate after, rad/s", "restitution delivered", "deepest overlap at contact, m",
                          "energy drift before, J", "energy drift after, J",
                          "energy drift between this bounce and the next (rms), J"}};
  const double h = evaluator.grid().step_s;
  for (std::size_t i = 0; i < run.outcome.impacts.size(); ++i) {
    const Impact& impact = run.outcome.impacts[i];
    const Span at = rows_between(run.trace.t, impact.t, impact.t + h);
    const double next = i + 1 < run.outcome.impacts.size() ? run.outcome.impacts[i + 1].t : run.trace.t.back();
    const Column between = part(drift, rows_between(run.trace.t, impact.t + h, next));
    double squares = 0;
    for (const double value : between) squares += value * value;
    const Cell late = i < reference.impacts.size() ? Cell((impact.t - reference.impacts[i].t) / h)
                                                   : Cell(Missing{"the reference has no such touch"});
    table.rows.push_back({static_cast<double>(i + 1), impact.t, late, impact.qd_before, impact.qd_after,
                          -impact.qd_after / impact.qd_before, impact.depth, drift[at.first], drift[at.end - 1],
                          std::sqrt(squares / static_cast<double>(between.size()))});
  }
  return table;
}

}  // namespace

Content contact_delay(Laboratory& laboratory, Findings& findings) {
  Evaluator& evaluator = laboratory.evaluator(scenario_name);
  const Scenario& file = evaluator.scenario();
  const Evaluation& run = *laboratory.run(scenario_name, steppers[0]);
  const std::vector<Setting> all = settings(file.ode);
  const std::vector<Contact> contacts = measure_all(file, all);
  add_findings(findings, contacts, file);

  const Truth truth = truth_of(file);
  const double touch_rad = reference::free_arc(file).low;
  const std::optional<Move> delay = delay_of(contacts, file);
  const Metrics metrics = evaluator.measure(run, file.duration_s);
  Content content;
  const auto claim = std::ranges::find(report::claims(), "C11b", &report::Claim::id);
  content.values = {{"restitution", file.planar->wall->restitution},
                    {"claimed_steps", claimed_steps},
                    {"gravity", file.gravity},
                    {"cause_percent", 100 * claim->confirmed_if.front().bound},
                    {"no_cause_percent", 100 * claim->refuted_if.front().bound},
                    {"duration", file.duration_s},
                    {"difference", shown(metrics[quantity::max_error_q].value_or(NAN))},
                    {"face", file.planar->wall->face_m},
                    {"side", side_of_link(file)},
                    {"touch", fmt::format("{:.5f}", touch_rad)},
                    {"touch_after", shown(truth.touch_s - truth.vertical_s)},
                    {"touch_steps", fmt::format("{:.1f}", (truth.touch_s - truth.vertical_s) / file.step_s)},
                    {"delay", delay ? shown(1e3 * delay->s) : ""},
                    {"moves", moves(contacts, file)}};
  content.exhibits.emplace_back(delays(contacts, all));
  content.exhibits.emplace_back(whole_motion(evaluator, run));

  Evaluator flush(first_swing(file, side_of_link(file), file.step_s));
  const Evaluation flush_run = flush.evaluate(*available(steppers[0]));
  content.exhibits.emplace_back(first_contact(evaluator, run, flush_run, flush));
  content.exhibits.emplace_back(bounces(evaluator, run));
  return content;
}

}  // namespace odeval::experiments
