#pragma once
// The catalogue of methods: one row each. Command line, help, list, tests and report read this table.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "measure/conditioning.hpp"
#include "odeval/method.hpp"

namespace odeval::catalogue {

/// The table of the scenario file that a method obeys besides what holds for all. Those that obey [ode] step as ODE
/// does: their stored velocities belong to half a step before (claim O1), and the half-step start is for them.
enum class Settings {
  none,
  ode,
  ode_bounce,  // of [ode] the bounce alone
  maximal,
};

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
  Settings settings = Settings::none;
  SystemMatrix inverts = SystemMatrix::none;  // whose condition number the trace shows
};

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
