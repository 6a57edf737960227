#pragma once
// The catalogue of methods: one row each. Command line, help, list, tests and report read this table.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "catalogue/engine_settings.hpp"
#include "odeval/engine.hpp"

namespace odeval::catalogue {

/// The command line's word for a way of moving a scenario.
using Method = Engine;

/// Whether a key of the scenario file is a setting of the method.
bool has_setting(const Method& method, std::string_view key);

/// Whether a key of the scenario file is a setting of the method that makes a difference in the scenario.
bool reads(const Method& method, std::string_view key, const Scenario& scenario);

/// Whether the method steps as ODE does: its stored velocities belong to half a step before (claim O1), and the
/// half-step start is for it.
bool has_half_step_start(const Method& method);

/// Whether it is ODE's own stepping, `dWorldStep` or `dWorldQuickStep`, which every program with ODE can call.
bool is_plain_ode(std::string_view method);

/// Whether a key is a setting of some method's engine.
bool is_engine_setting(std::string_view key);

/// Which methods read an engine's setting, with commas, and on what it acts where that is not everything:
/// "ode-step-double, ode-step-single where there are joints or contacts".
std::string readers_of(std::string_view key);

/// The name of the method that every error of a motion in joint coordinates is measured against.
inline constexpr std::string_view reference_method = "lagrange-cvode";

std::span<const Method> methods();

/// Throws UserError with the nearest name, or why the build lacks the method.
const Method& find_method(std::string_view name);

/// Whether the method can do all that the scenario asks.
bool does(const Method& method, const Scenario& scenario);

/// Throws UserError with what each of the methods lacks, and which methods have it, or for a setting that one of them
/// would not take as it is. `origin` is where the methods were named.
void require_does(std::span<const Method* const> methods, const Scenario& scenario, const std::string& origin);
void require_does(const Method& method, const Scenario& scenario, const std::string& origin);

/// Why methods of single precision have no `make`.
inline constexpr std::string_view without_single_precision =
    "this build has no single-precision ODE; scripts/build-ode-single makes one, then configure again";

std::vector<std::string> method_names();

}  // namespace odeval::catalogue
