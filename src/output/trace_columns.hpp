#pragma once
// The one table of a trace's columns: what they are called in files, their units, and where they stand in a `Trace`.
// Whoever names a column of a file reads it. A new column is a member of `Trace` and a row here.
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "odeval/quantity.hpp"
#include "odeval/trace.hpp"
#include "odeval/work.hpp"

namespace odeval {

/// Kinetic plus potential energy, J: as many values as the trace has rows.
inline Column energy_of(const Trace& trace) {
  Column energy = trace.kinetic;
  for (std::size_t k = 0; k < energy.size(); ++k) energy[k] += trace.potential[k];
  return energy;
}

/// That energy minus the one at t = 0, J.
inline Column energy_drift_of(const Trace& trace) {
  Column drift = energy_of(trace);
  const double start = drift.empty() ? 0 : drift[0];
  for (double& value : drift) value -= start;
  return drift;
}

/// A kind of work, J.
template <Work kind>
Column work_of(const Trace& trace) {
  return trace.works.empty() ? Column() : trace.works[static_cast<std::size_t>(kind)];
}

/// Where a column stands in a trace, and with that how files call it. Where bodies and joints have names (ARM, ELBOW),
/// these stand in the place of numbers.
using ColumnPlace = std::variant<Column Trace::*,                       // of the whole mechanism: NAME
                                 Column (*)(const Trace&),              // the same, made from others
                                 std::vector<Column> Trace::*,          // of coordinate or body i: NAMEi, ARM.NAME
                                 std::array<Column, 3> BodyColumns::*,  // a vector of body i: NAMExi..., ARM.NAMEx...
                                 std::array<Column, 9> BodyColumns::*,  // a matrix by rows: NAMEi11..., ARM.NAME11...
                                 Column JointColumns::*>;               // of a joint: ELBOW.NAME

/// A row of the table. A column that a trace does not have is in no file.
struct TraceColumn {
  std::string_view name;
  std::string_view unit;
  ColumnPlace place;
  std::optional<quantity::Id> uncertainty = {};  // bounds how far the reference may be off, and with it this column
  bool exact = false;                            // given or counted: two runs that are the same have the same
};

/// In the order of the file, which has all vectors and matrices of body 1 before those of body 2, and all of joints at
/// the end.
// clang-format off
inline constexpr TraceColumn trace_columns[] = {
    {"t",                      "s",     &Trace::t, quantity::none, true},
    {"q",                      "rad",   &Trace::q, quantity::reference_uncertainty},
    {"qd",                     "rad/s", &Trace::qd},
    {"kinetic",                "J",     &Trace::kinetic},
    {"potential",              "J",     &Trace::potential},
    {"energy",                 "J",     energy_of},
    {"energy_drift",           "J",     energy_drift_of},
    {"work_motors",            "J",     work_of<Work::motors>},
    {"work_stops",             "J",     work_of<Work::stops>},
    {"work_springs",           "J",     work_of<Work::springs>},
    {"work_dampers",           "J",     work_of<Work::dampers>},
    {"work_torques",           "J",     work_of<Work::torques>},
    {"work_controllers",       "J",     work_of<Work::controllers>},
    {"work_contacts",          "J",     work_of<Work::contacts>},
    {"unaccounted",            "J",     &Trace::unaccounted},
    {"gap",                    "m",     &Trace::gap},
    {"out_of_plane",           "m",     &Trace::out_of_plane},
    {"error_q",                "rad",   &Trace::error_q, quantity::reference_uncertainty},
    {"error_position",         "m",     &Trace::error_position},
    {"error_turn",             "rad",   &Trace::error_turn},
    {"angular_momentum_drift", "N m s", &Trace::angular_momentum_drift},
    {"penetration",            "m",     &Trace::penetration},
    {"contacts",               "",      &Trace::contacts, quantity::none, true},
    {"condition",              "",      &Trace::condition},
    {"manipulability",         "",      &Trace::manipulability},
    {"",                       "m",     &BodyColumns::position},
    {"r",                      "",      &BodyColumns::rotation},
    {"v",                      "m/s",   &BodyColumns::velocity},
    {"w",                      "rad/s", &BodyColumns::spin},
    {"f",                      "N",     &BodyColumns::joint_force},
    {"q",                      "rad or m", &JointColumns::q},
    {"qd",                     "rad/s or m/s", &JointColumns::qd},
    {"torque",                 "N m or N", &JointColumns::load},
    {"gap",                    "m",     &JointColumns::gap},
    {"error_q",                "rad or m", &JointColumns::error_q},
};
// clang-format on

}  // namespace odeval
