#include "catalogue/foreign_trace.hpp"

#include <algorithm>
#include <utility>

#include "measure/metrics.hpp"
#include "odeval/error.hpp"

namespace odeval::catalogue {
namespace {

std::string joined(const std::vector<std::string>& words, const std::string& by) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : by) + word;
  return text;
}

}  // namespace

/// Quantities that are taken from the same columns.
struct ForeignTrace::Need {
  enum class Of { whole, angles, bodies };
  Of of;
  std::vector<quantity::Id> ids;
  std::vector<std::string> columns;          // of one of them, by their names in the table of columns
  bool (*has)(const Trace&, std::size_t i);  // the angle or the body
  bool all_or_none = false;                  // some of the bodies tell nothing

  /// As files call them: "q1", "vx1", "r111", "arm.vx"; what is the whole trace's has no number.
  std::vector<std::string> cells(const Trace& trace, std::size_t i) const {
    std::vector<std::string> cells;
    for (const std::string& column : columns) {
      const bool whole_trace = of == Of::whole || column == "..." || column == "penetration" || column == "contacts";
      const bool matrix = column.starts_with("r");
      cells.push_back(whole_trace                 ? column
                      : !trace.body_names.empty() ? trace.body_names[i] + "." + column
                      : matrix                    ? "r" + std::to_string(i + 1) + column.substr(1)
                                                  : column + std::to_string(i + 1));
    }
    return cells;
  }
};

namespace {

template <std::size_t size>
bool has(const std::array<Column, size>& columns, std::size_t rows) {
  return std::ranges::all_of(columns, [rows](const Column& column) { return column.size() == rows; });
}

bool has(const Trace& trace, const Column& column) { return column.size() == trace.rows(); }

/// In the place of what is missing, so that nothing reads beyond an end; nothing is taken from it.
template <std::size_t size>
void fill(std::array<Column, size>& columns, std::size_t rows) {
  for (Column& column : columns) column.resize(rows);
}

/// Those of the numbers, where there are as many as angles or bodies.
template <class Item>
void keep(std::vector<Item>& items, const std::vector<std::size_t>& numbers, std::size_t all) {
  std::vector<Item> kept;
  for (const std::size_t i : numbers) {
    if (items.size() == all) kept.push_back(std::move(items[i]));
  }
  items = std::move(kept);
}

std::string names_of(const std::vector<quantity::Id>& ids) {
  std::vector<std::string> names;
  for (const quantity::Id id : ids) {
    if (quantities[id].scope != Scope::reference) names.emplace_back(quantities[id].name);
  }
  return joined(names, ", ");
}

std::vector<std::string> along_axes(const std::string& name) { return {name + "x", name + "y", name + "z"}; }

bool has_ground(const Mechanism& mechanism) {
  return std::ranges::any_of(
      mechanism.obstacles, [](const Obstacle& obstacle) { return std::holds_alternative<HalfSpace>(obstacle.shape); });
}

void complete(Trace& trace) {
  for (Column* column : {&trace.kinetic, &trace.potential, &trace.contacts}) column->resize(trace.rows());
  for (BodyColumns& body : trace.bodies) {
    fill(body.position, trace.rows());
    fill(body.rotation, trace.rows());
    fill(body.velocity, trace.rows());
    fill(body.spin, trace.rows());
    fill(body.joint_force, trace.rows());
  }
}

bool has_angle(const Trace& t, std::size_t i) { return has(t, t.q[i]); }
bool has_angle_and_rate(const Trace& t, std::size_t i) { return has(t, t.q[i]) && has(t, t.qd[i]); }
bool has_position(const Trace& t, std::size_t i) { return has(t.bodies[i].position, t.rows()); }
bool has_rotation(const Trace& t, std::size_t i) { return has(t.bodies[i].rotation, t.rows()); }
bool has_velocity(const Trace& t, std::size_t i) { return has(t.bodies[i].velocity, t.rows()); }
bool has_both(const Trace& t, std::size_t i) { return has_position(t, i) && has_velocity(t, i); }
bool has_force(const Trace& t, std::size_t i) { return has(t.bodies[i].joint_force, t.rows()) && has(t, t.contacts); }

}  // namespace

std::vector<ForeignTrace::Need> ForeignTrace::needs_of(const Scenario& scenario, const Reference& reference) {
  using namespace quantity;
  using enum Need::Of;
  const Mechanism& mechanism = scenario.mechanism;
  const bool planar = scenario.planar != nullptr;
  const bool ground = !planar && has_ground(mechanism);
  const bool drifts = !planar && mechanism.contacts.empty() && mechanism.joints.empty();
  std::vector<Need> needs;
  const auto add = [&needs](bool applies, Need need) {
    if (applies) needs.push_back(std::move(need));
  };
  add(planar, {angles, {max_error_q, rms_error_q, reference_uncertainty, divergence_time}, {"q"}, has_angle});
  add(planar, {angles, {time_shift, time_shift_uncertainty, error_q_after_shift}, {"q", "qd"}, has_angle_and_rate});
  add(!planar, {bodies, {max_error_position, position_uncertainty}, along_axes(""), has_position});
  add(!planar, {bodies, {max_error_turn, turn_uncertainty}, {"r11", "...", "r33"}, has_rotation});
  add(!planar, {bodies,
                {time_shift, time_shift_uncertainty, error_position_after_shift},
                {"x", "y", "z", "vx", "vy", "vz"},
                has_both});
  add(true, {whole,
             {max_energy_drift, rms_energy_drift, final_energy_drift},
             {"kinetic", "potential"},
             [](const Trace& t, std::size_t) { return has(t, t.kinetic) && has(t, t.potential); }});
  add(!reference.trace.unaccounted.empty(),
      {whole, {max_unaccounted_energy}, {"unaccounted"}, [](const Trace& t, std::size_t) {
         return has(t, t.unaccounted);
       }});
  add(planar || !mechanism.joints.empty(),
      {whole, {max_gap}, {"gap"}, [](const Trace& t, std::size_t) { return has(t, t.gap); }});
  add(planar, {whole, {max_out_of_plane}, {"out_of_plane"}, [](const Trace& t, std::size_t) {
                 return has(t, t.out_of_plane);
               }});
  add(drifts, {whole, {max_angular_momentum_drift}, {"angular_momentum_drift"}, [](const Trace& t, std::size_t) {
                 return has(t, t.angular_momentum_drift);
               }});
  add(ground,
      {whole, {max_penetration}, {"penetration"}, [](const Trace& t, std::size_t) { return has(t, t.penetration); }});
  add(ground, {bodies, {max_creep}, {"x", "y", "z", "penetration"}, [](const Trace& t, std::size_t i) {
                 return has_position(t, i) && has(t, t.penetration);
               }});
  add(ground, {bodies,
               {rest_time},
               {"vx", "vy", "vz", "penetration"},
               [](const Trace& t, std::size_t i) { return has_velocity(t, i) && has(t, t.penetration); },
               true});
  add(!reference.joint_force.empty(), {bodies, {max_reaction_error}, {"fx", "fy", "fz", "contacts"}, has_force});
  return needs;
}

ForeignTrace::ForeignTrace(Trace trace, Evaluator& evaluator, const std::string& name) {
  const Scenario& scenario = evaluator.scenario();
  const Reference& reference = evaluator.reference();
  std::vector<std::string> columns;
  for (const Need& need : needs_of(scenario, reference)) {
    take(need, trace, reference);
    columns.push_back(joined(need.cells(trace, 0), ", "));
  }
  if (!parts_.empty()) return;
  throw UserError(name + ": has no column that '" + scenario.name + "' is judged by: must have " +
                  joined(columns, ", or "));
}

void ForeignTrace::take(const Need& need, const Trace& trace, const Reference& reference) {
  const bool of_angles = need.of == Need::Of::angles;
  const std::size_t all = need.of == Need::Of::whole ? 1 : of_angles ? trace.q.size() : trace.bodies.size();
  std::vector<std::size_t> there;
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < all; ++i) (need.has(trace, i) ? there : missing).push_back(i);
  if (!missing.empty()) {
    const bool some = !there.empty() && !need.all_or_none;
    untold_.push_back(names_of(need.ids) + (some ? " (told without " : " (needs ") +
                      joined(need.cells(trace, missing.front()), ", ") + (missing.size() > 1 ? " and so on)" : ")"));
  }
  if (there.empty() || (need.all_or_none && !missing.empty())) return;
  Part part{trace, reference, need.ids};
  const std::vector<std::size_t> none;
  const std::vector<std::size_t>& angles = of_angles ? there : none;
  const std::vector<std::size_t>& bodies = need.of == Need::Of::bodies ? there : none;
  for (Trace* one : {&part.trace, &part.reference.trace}) {
    keep(one->q, angles, trace.q.size());
    keep(one->qd, angles, trace.q.size());
    keep(one->bodies, bodies, trace.bodies.size());
    keep(one->long_axis_spin, bodies, trace.bodies.size());
    one->joints.clear();
  }
  keep(part.reference.joint_force, bodies, trace.bodies.size());
  complete(part.trace);
  compare(part.trace, part.reference);
  parts_.push_back(std::move(part));
}

Metrics ForeignTrace::measure(double until_s) const {
  Metrics metrics;
  metrics.until_s = until_s;
  for (const Part& part : parts_) {
    const Metrics taken = odeval::measure(part.trace, &part.reference, until_s);
    for (const quantity::Id id : part.ids) metrics[id] = taken[id];
    if (!part.trace.q.empty()) metrics.reference_lost_at = taken.reference_lost_at;
  }
  return metrics;
}

}  // namespace odeval::catalogue
