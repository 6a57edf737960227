#pragma once
// One run in one page: settings, versions, errors. Nothing in it depends on the clock: same command, same bytes.
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "odeval/metrics.hpp"
#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "odeval/told.hpp"

namespace odeval {

using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// Errors are given over the whole run and until these times, s, where they lie within it.
inline constexpr std::array<double, 5> error_times{1, 2, 3, 5, 10};

/// The error times that a run of this grid reaches.
std::vector<double> error_times_within(const SampleGrid& grid);

/// What a joint of a mechanism came to in a run, the largest sizes.
struct JointSummary {
  double max_gap = 0;                     // m
  std::optional<double> max_error = {};   // of its way against the reference, rad or m
  std::optional<double> max_torque = {};  // along its axis, N m or N
};

/// Of a mechanism whose parts have names.
struct PartsSummary {
  std::vector<JointSummary> joints;  // in the mechanism's order
  std::optional<Works> works;        // J, until the end; nothing where nobody tells them
  double energy_gained = 0;          // J, likewise
  double unaccounted = 0;            // J, likewise
};

struct RunSummary {
  Scenario scenario;  // with the command line's settings in place
  SampleGrid grid;
  std::string method;
  bool is_reference = false;   // the others' errors are differences from this run
  bool uses_ode = false;       // whether [ode] settings took effect
  bool uses_bounce = false;    // of those the bounce alone
  bool uses_bullet = false;    // whether [bullet] settings took effect
  bool uses_mujoco = false;    // likewise
  bool uses_maximal = false;   // whether [maximal] settings took effect
  std::optional<double> rtol;  // in effect; absent for a fixed step
  std::optional<double> atol;
  Told told;  // to the engine beside all that
  Outcome outcome;
  Metrics metrics;                // over the whole run
  std::vector<Metrics> error_at;  // one per error time within the run
  std::string reference;          // how it was solved; empty without one
  NamedTexts versions;
  PartsSummary parts;
};

/// Why not to believe a run that ODE itself complained of: "736 messages of ODE (LCP internal error)". Empty: it did
/// not.
std::string suspicion(const Outcome& outcome);

/// What an impact kept of the speed it found; empty when it found none.
std::optional<double> restitution(const Impact& impact);

/// Object with the keys of the result files. Metrics without meaning are null, infinite numbers the string "inf".
std::string summary_json(const RunSummary& run);

/// The first setting, or version, of a run that a METHOD.json has otherwise: "step = 0.001, not 0.01". Empty: none has.
std::string unlike(const std::string& json, const RunSummary& run);

/// A header and one row a method. Metrics without meaning are empty cells.
std::string summary_csv(const std::vector<RunSummary>& runs);

}  // namespace odeval
