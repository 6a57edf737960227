#pragma once
// The one table of quantities that a trace is judged by. Tolerances, summaries, sweeps, comparisons, help and tests
// read it; what takes a quantity from a trace is the function of its name in src/measure (measure/measurement.hpp).
#include <cstddef>
#include <optional>
#include <string_view>

namespace odeval {

/// What a quantity is a property of.
enum class Scope {
  coordinate,  // the joint coordinates, all together: of a run that has angles
  body,        // the bodies in space, all together
  mechanism,   // the whole mechanism, or the clock: of any run
  reference,   // the reference itself: how far it may be off. Such a row bounds others.
};

/// Which way a quantity is better.
enum class Direction {
  less,
  more,
  nearer_zero,  // it has a sign
  neither,      // it bounds, explains or dates an error, and none is the better run for it
};

// A row a quantity, in the order of every table and file: its name, unit (SI, as shown), scope, direction, the quantity
// that bounds how far the reference makes it be off (none: it is no error against the reference) and its meaning, as
// shown. A new quantity is a row here and a function std::optional<double> NAME(const Measurement&) in src/measure; it
// may ask for what the rows above it took. A macro, since a row has to make a name that the compiler knows.
//
// Errors and drifts of a trace that ends before the reference does are infinite; gap and distance from the plane, which
// need no reference to tell, are of the rows there are.
// clang-format off
#define ODEVAL_QUANTITIES(ROW) \
  /* Angles beside the reference's, not cut at +-pi: over all joints and all samples. */ \
  ROW(max_error_q,           "rad", coordinate, less,    reference_uncertainty, "largest angle error") \
  ROW(rms_error_q,           "rad", coordinate, less,    reference_uncertainty, "root mean square of the angle errors") \
  /* Of the reference's own rows until then, whether or not the trace reaches them; so are the bounds below. */ \
  ROW(reference_uncertainty, "rad", reference,  neither, none, "bound on the reference's own angle error") \
  /* No value: never lost, or nobody can tell, since the reference itself is no better known than that. */ \
  /* Of a trace that ended early it is the first sample that is missing. */ \
  ROW(divergence_time,       "s",   coordinate, more,    none, "first sample with an angle error above 0.1 rad") \
  /* Kinetic plus potential energy of the trace, which knows of weight and of no spring. */ \
  ROW(max_energy_drift,      "J",   mechanism,  less,    none, "largest difference from the energy at t = 0") \
  ROW(rms_energy_drift,      "J",   mechanism,  less,    none, "root mean square of that difference") \
  ROW(final_energy_drift,    "J",   mechanism,  nearer_zero, none, "that difference at the end, with its sign") \
  /* Of mechanisms, whose motors, stops, springs, dampers, torques, controllers and contacts do the work: what is */ \
  /* left of the reference is its own error, of ODE what its steps lose and gain. */ \
  ROW(max_unaccounted_energy, "J",  mechanism,  less,    none, "largest change of the energy that no work accounts for") \
  /* Of coordinates that let joints come apart and bodies leave the plane. */ \
  ROW(max_gap,               "m",   mechanism,  less,    none, "largest distance between the anchors of a joint") \
  ROW(max_out_of_plane,      "m",   body,       less,    none, "largest distance of a body from the plane") \
  /* Length of the difference of two forces, world frame; from row 1, as the force in row 0 belongs to no step. */ \
  ROW(max_reaction_error,    "N",   mechanism,  less,    none, "largest joint force error at samples without contact") \
  /* Of bodies in space the largest over all of them: distance of the centres, angle of the turn between attitudes. */ \
  ROW(max_error_position,    "m",   body,       less,    position_uncertainty, "largest distance of a body from the reference") \
  ROW(max_error_turn,        "rad", body,       less,    turn_uncertainty, "largest angle between a body's attitude and the reference's") \
  ROW(position_uncertainty,  "m",   reference,  neither, none, "bound on the reference's own distance") \
  ROW(turn_uncertainty,      "rad", reference,  neither, none, "bound on the reference's own angle of attitude") \
  /* |L - L at t = 0|, world frame, summed over the bodies; no value where torques act. */ \
  ROW(max_angular_momentum_drift, "N m s", mechanism, less, none, "largest change of the angular momentum about the centres") \
  /* Of links too, whose reference swings in a plane: it has no such spin, and no bound on one. */ \
  ROW(max_long_axis_spin,    "rad/s", body,     less,    spin_uncertainty, "largest spin about a body's longest side that the reference does not have") \
  ROW(spin_uncertainty,      "rad/s", reference, neither, none, "bound on the error of the reference's own spin") \
  /* How far below the ground's surface the lowest point of any body lies. */ \
  ROW(max_penetration,       "m",   body,       less,    none, "deepest overlap of a body with the ground") \
  /* The sample after the last one with motion. No value: a body still moves in the last sample. */ \
  ROW(rest_time,             "s",   mechanism,  neither, none, "from when on no body on a ground moves faster than 1 mm/s") \
  /* From where it is as the reference comes to rest. No value: the reference never does. */ \
  ROW(max_creep,             "m",   body,       less,    none, "farthest a body goes while the reference rests") \
  /* Largest distance in time between an impact and the nearest of the reference's, either way; one without a */ \
  /* counterpart may have it after the end, and counts as that late at least. No value: the reference has none. */ \
  ROW(max_impact_error,      "s",   mechanism,  less,    impact_uncertainty, "largest error of the time of an impact") \
  ROW(impact_uncertainty,    "s",   reference,  neither, none, "bound on the error of the times of the reference's own impacts") \
  /* Least squares over angles, or over coordinates of centres; within two rows either way, before the first impact. */ \
  /* No value: the run is lost, ends early or does not move. */ \
  ROW(time_shift,            "s",   mechanism,  neither, time_shift_uncertainty, "how far the trace's clock runs ahead, for the best fit until an impact") \
  ROW(time_shift_uncertainty, "s",  reference,  neither, none, "bound on what the reference's own error does to it") \
  /* One of these two: of a run with angles that of angles. */ \
  ROW(error_q_after_shift,   "rad", coordinate, neither, reference_uncertainty, "largest angle error that this shift leaves") \
  ROW(error_position_after_shift, "m", body,    neither, position_uncertainty, "largest error of a coordinate of a body that this shift leaves")
// clang-format on

/// The rows' names for the compiler, to look up a value in `Metrics`: `metrics[quantity::max_gap]`.
namespace quantity {
#define ODEVAL_NAME(name, ...) name,
/// In the order of the table; `count` is how many there are.
enum Id : std::size_t { ODEVAL_QUANTITIES(ODEVAL_NAME) count };
#undef ODEVAL_NAME
/// In the place of a bound: the quantity is no error against the reference.
inline constexpr std::nullopt_t none = std::nullopt;
}  // namespace quantity

/// A row of the table. What takes its value from a trace is no part of it: who only shows values need not measure.
struct Quantity {
  quantity::Id id;                          // its place in the table
  std::string_view name;                    // as users write and read it, in lists, files and tolerances
  std::string_view unit;                    // of its value
  Scope scope;                              // what it is a property of
  Direction direction;                      // which way is better
  std::optional<quantity::Id> uncertainty;  // of the same unit; empty: no error against the reference
  std::string_view meaning;                 // in words, for lists and help
};

// clang-format off
#define ODEVAL_ROW(name, unit, scope, direction, uncertainty, meaning) \
  Quantity{quantity::name, #name, unit, Scope::scope, Direction::direction, quantity::uncertainty, meaning},
/// All of them; `quantities[id]` is the row of that id.
inline constexpr Quantity quantities[] = {ODEVAL_QUANTITIES(ODEVAL_ROW)};
#undef ODEVAL_ROW
// clang-format on

/// The row of the name that users write; null where no row has it. Looks at every row: there are few.
constexpr const Quantity* quantity_named(std::string_view name) {
  for (const Quantity& row : quantities) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

}  // namespace odeval
