#pragma once
// The catalogue of methods: one row each. Command line, help, list, tests and report read this table.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "catalogue/engine_settings.hpp"
#include "measure/conditioning.hpp"
#include "odeval/method.hpp"

namespace odeval::catalogue {

struct Method {
  std::string_view name;
  std::string_view formulation;
  std::string_view advanced_by;
  Coordinates coordinates;
  int order;    // of convergence in the step; 0: no fixed step
  double rtol;  // its own tolerances, which --rtol and --atol replace; 0: it has none
  double atol;
  bool (*claims)(const Problem&);  // which problems it does
  MakeSimulation make;             // null: left out of this build
  std::span<const EngineSetting> (*settings)() = no_settings;
  SystemMatrix inverts = SystemMatrix::none;  // whose condition number the trace shows
};

/// Whether a key of the scenario file is a setting of the method.
bool has_setting(const Method& method, std::string_view key);

/// Whether a key of the scenario file is a setting of the method that makes a difference in the scenario.
bool reads(const Method& method, std::string_view key, const Scenario& scenario);

/// Whether the method steps as ODE does: its stored velocities belong to half a step before (claim O1), and the
/// half-step start is for it.
bool has_half_step_start(const Method& method);

/// Whether a key is a setting of some method's engine.
bool is_engine_setting(std::string_view key);

/// Which methods read an engine's setting, with commas, and on what it acts where that is not everything:
/// "ode-step-double, ode-step-single where there are joints or contacts".
std::string readers_of(std::string_view key);

/// The name of the method that every error of a pendulum is measured against.
inline constexpr std::string_view reference_method = "lagrange-cvode";

/// The same for any problem: bodies are measured against their closed form.
inline constexpr std::string_view reference_method_of(const Problem& problem) {
  return problem.family == Family::bodies ? "analytic" : reference_method;
}

std::span<const Method> methods();

/// Throws UserError with the nearest name, or why the build lacks the method.
const Method& find_method(std::string_view name);

/// Throws UserError when the method does not do the problem. `origin` is where the method was named.
void require_claim(const Method& method, const Problem& problem, const std::string& origin);

/// Why a method has no `make`.
inline constexpr std::string_view why_missing =
    "this build has no single-precision ODE; scripts/build-ode-single makes one, then configure again";

std::vector<std::string> method_names();

}  // namespace odeval::catalogue
