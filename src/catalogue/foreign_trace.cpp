#include "catalogue/foreign_trace.hpp"

#include <algorithm>
#include <utility>

#include "measure/metrics.hpp"
#include "odeval/error.hpp"

namespace odeval::catalogue {
namespace {

template <std::size_t size>
bool has(const std::array<Column, size>& columns, std::size_t rows) {
  return std::ranges::all_of(columns, [rows](const Column& column) { return column.size() == rows; });
}

bool has_all(const Trace& trace, std::array<Column, 3> BodyColumns::*place) {
  return std::ranges::all_of(trace.bodies, [&](const BodyColumns& body) { return has(body.*place, trace.rows()); });
}

bool has_all_rotations(const Trace& trace) {
  return std::ranges::all_of(trace.bodies, [&](const BodyColumns& body) { return has(body.rotation, trace.rows()); });
}

/// In the place of what is missing, so that nothing reads beyond an end; what is taken from it is left out.
template <std::size_t size>
void fill(std::array<Column, size>& columns, std::size_t rows) {
  for (Column& column : columns) column.resize(rows);
}

void require_motion(const Trace& trace, const Scenario& scenario, const std::string& name) {
  const std::size_t angles = scenario.planar ? scenario.planar->links.size() : 0;
  if (trace.q.size() != angles) {
    const std::string has = trace.q.empty() ? "none" : std::to_string(trace.q.size());
    throw UserError(name + ": has " + has + " of the columns q1, q2, ...; '" + scenario.name + "' has " +
                    std::to_string(angles) + " angles");
  }
  const std::size_t bodies = scenario.mechanism.bodies.size();
  if (angles == 0 && (trace.bodies.size() != bodies || !has_all(trace, &BodyColumns::position))) {
    throw UserError(name + ": must have the columns x1, y1, z1 and so on of all " + std::to_string(bodies) +
                    " bodies of '" + scenario.name + "'");
  }
}

}  // namespace

ForeignTrace::ForeignTrace(Trace trace, Evaluator& evaluator, const std::string& name) : evaluator_(evaluator) {
  require_motion(trace, evaluator.scenario(), name);
  run_.trace = std::move(trace);
  complete();
  compare(run_.trace, evaluator.reference());
}

void ForeignTrace::complete() {
  using namespace quantity;
  Trace& trace = run_.trace;
  const std::size_t rows = trace.rows();
  const auto untold = [this](std::initializer_list<Id> ids) { untold_.insert(untold_.end(), ids); };
  if (trace.kinetic.empty() || trace.potential.empty()) {
    trace.kinetic.resize(rows);
    trace.potential.resize(rows);
    untold({max_energy_drift, rms_energy_drift, final_energy_drift});
  }
  // Of angles the bodies are an addition, and of use with all that belongs to them.
  const bool all_of_bodies = has_all(trace, &BodyColumns::position) && has_all_rotations(trace) &&
                             has_all(trace, &BodyColumns::velocity) && has_all(trace, &BodyColumns::spin);
  if (!trace.q.empty() && !all_of_bodies) trace.bodies.clear();
  untold({max_impact_error, impact_uncertainty});
  if (!has_all(trace, &BodyColumns::joint_force) || trace.contacts.empty()) untold({max_reaction_error});
  if (!has_all_rotations(trace)) untold({max_error_turn, turn_uncertainty});
  if (!has_all(trace, &BodyColumns::velocity)) {
    untold({rest_time, time_shift, time_shift_uncertainty, error_position_after_shift});
  }
  trace.contacts.resize(rows);
  for (BodyColumns& body : trace.bodies) {
    fill(body.rotation, rows);
    fill(body.velocity, rows);
    fill(body.spin, rows);
    fill(body.joint_force, rows);
  }
}

Metrics ForeignTrace::measure(double until_s) {
  Metrics metrics = evaluator_.measure(run_, until_s);
  for (const quantity::Id id : untold_) metrics[id].reset();
  return metrics;
}

}  // namespace odeval::catalogue
