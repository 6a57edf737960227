#include "catalogue/methods.hpp"

#include <algorithm>
#include <array>

#include "catalogue/accurate_method.hpp"
#include "engine_ode/module.hpp"
#include "model/nearest.hpp"
#include "model/problems.hpp"
#include "odeval/error.hpp"
#include "reference/analytic.hpp"
#include "reference/bodies/newton_euler.hpp"
#include "reference/bodies/solution.hpp"
#include "reference/cvode.hpp"
#include "reference/dh_ode45.hpp"
#include "reference/fixed_step.hpp"
#include "reference/maximal/fixed_step.hpp"
#include "reference/maximal/ode_step_simulation.hpp"
#include "reference/ode45.hpp"
#include "reference/quad.hpp"

namespace odeval::catalogue {
namespace {

using engine_ode::Module;

template <const Module& (*module)(), MakeSimulation Module::*make>
std::unique_ptr<Simulation> in_module(const Scenario& scenario, const SampleGrid& grid) {
  return (module().*make)(scenario, grid);
}

constexpr MakeSimulation step_double = &in_module<&engine_ode::odeval_ode_double, &Module::make_step>;
constexpr MakeSimulation quickstep_double = &in_module<&engine_ode::odeval_ode_double, &Module::make_quickstep>;
#ifdef ODEVAL_HAVE_ODE_SINGLE
constexpr MakeSimulation step_single = &in_module<&engine_ode::odeval_ode_single, &Module::make_step>;
constexpr MakeSimulation quickstep_single = &in_module<&engine_ode::odeval_ode_single, &Module::make_quickstep>;
#else
constexpr MakeSimulation step_single = nullptr;
constexpr MakeSimulation quickstep_single = nullptr;
#endif

bool every(const Problem&) { return true; }
// What the accurate step does: no friction, and no joint that starts open.
bool for_accurate_step(const Problem& problem) { return !problem.friction && !problem.joint; }
bool pendulums(const Problem& problem) { return problem.family == Family::pendulum; }
bool without_wall(const Problem& problem) { return pendulums(problem) && !problem.wall; }
bool one_or_two_links_without_wall(const Problem& problem) { return problem.links != 0 && !problem.wall; }
bool one_link_or_no_wall(const Problem& problem) { return problem.links == 1 || without_wall(problem); }
bool closed_form(const Problem& problem) { return problem.links == 1 || problem.family == Family::bodies; }

bool in_free_flight(const Problem& problem) { return !pendulums(problem) && !problem.ground && !problem.joint; }
bool pendulums_or_free(const Problem& problem) { return pendulums(problem) || in_free_flight(problem); }

std::unique_ptr<Simulation> make_cvode(const Scenario& scenario, const SampleGrid& grid) {
  return scenario.family() == Family::bodies ? reference::make_free_cvode(scenario, grid)
                                             : reference::make_cvode(scenario, grid);
}

std::unique_ptr<Simulation> make_analytic(const Scenario& scenario, const SampleGrid& grid) {
  return scenario.family() == Family::bodies ? reference::make_body_analytic(scenario, grid)
                                             : reference::make_analytic(scenario, grid);
}

constexpr auto generalized = Coordinates::generalized;
constexpr auto cartesian = Coordinates::cartesian;

constexpr auto mass_matrix = SystemMatrix::mass_matrix;
constexpr auto hinge_rows = SystemMatrix::hinge_rows;
constexpr auto hinge_rows_cfm = SystemMatrix::hinge_rows_cfm;
constexpr auto planar_joints = SystemMatrix::planar_joints;

constexpr std::array table{
    Method{"ode-step-double", "ODE bodies and joints", "dWorldStep, double precision", cartesian, 1, 0, 0, every,
           step_double, step_settings, hinge_rows_cfm},
    Method{"ode-step-single", "ODE bodies and joints", "dWorldStep, single precision", cartesian, 1, 0, 0, every,
           step_single, step_settings, hinge_rows_cfm},
    Method{"ode-quickstep-double", "ODE bodies and joints", "dWorldQuickStep, double precision", cartesian, 1, 0, 0,
           every, quickstep_double, quickstep_settings, hinge_rows_cfm},
    Method{"ode-quickstep-single", "ODE bodies and joints", "dWorldQuickStep, single precision", cartesian, 1, 0, 0,
           every, quickstep_single, quickstep_settings, hinge_rows_cfm},
    Method{"ode-rk4-double", "ODE bodies and joints", "odeval's Runge-Kutta step beside ODE's collision detection",
           cartesian, 4, 0, 0, for_accurate_step, make_accurate, accurate_step_settings, hinge_rows},
    Method{reference_method, "closed-form Lagrangian", "SUNDIALS CVODE, Adams: the reference", generalized, 0,
           reference::tight_tolerances.rtol, reference::tight_tolerances.atol, pendulums_or_free, make_cvode,
           tolerance_settings, mass_matrix},
    Method{"lagrange-quad", "closed-form Lagrangian", "extrapolation in quad precision: certifies the reference",
           generalized, 0, 0, 0, one_or_two_links_without_wall, reference::make_quad, no_settings, mass_matrix},
    Method{"lagrange-ode45", "closed-form Lagrangian", "Dormand-Prince 5(4) as MATLAB's ode45", generalized, 0,
           reference::ode45_rtol, reference::ode45_atol, one_link_or_no_wall, reference::make_ode45, tolerance_settings,
           mass_matrix},
    Method{"dh-ode45", "recursive Newton-Euler from DH parameters", "Dormand-Prince 5(4) as MATLAB's ode45",
           generalized, 0, reference::ode45_rtol, reference::ode45_atol, without_wall, reference::make_dh_ode45,
           tolerance_settings, mass_matrix},
    Method{"lagrange-rk4", "closed-form Lagrangian", "classical Runge-Kutta, fixed step", generalized, 4, 0, 0,
           one_link_or_no_wall, reference::make_rk4, no_settings, mass_matrix},
    Method{"lagrange-euler", "closed-form Lagrangian", "explicit Euler, fixed step", generalized, 1, 0, 0,
           one_link_or_no_wall, reference::make_euler, no_settings, mass_matrix},
    Method{"lagrange-symplectic-euler", "closed-form Lagrangian", "symplectic Euler, fixed step", generalized, 1, 0, 0,
           one_link_or_no_wall, reference::make_symplectic_euler, no_settings, mass_matrix},
    Method{"maximal-euler", "Newton-Euler with Lagrange multipliers", "explicit Euler, fixed step", cartesian, 1, 0, 0,
           one_or_two_links_without_wall, reference::make_maximal_euler, feedback_settings, planar_joints},
    Method{"maximal-rk4", "Newton-Euler with Lagrange multipliers", "classical Runge-Kutta, fixed step", cartesian, 4,
           0, 0, one_or_two_links_without_wall, reference::make_maximal_rk4, feedback_settings, planar_joints},
    Method{"maximal-ode-step", "one dWorldStep rebuilt", "ODE's own scheme, fixed step", cartesian, 1, 0, 0,
           one_link_or_no_wall, reference::make_maximal_ode_step, step_settings, hinge_rows_cfm},
    Method{"analytic", "closed form", "elliptic functions and the like", generalized, 0, 0, 0, closed_form,
           make_analytic, closed_form_settings, mass_matrix},
};

}  // namespace

std::span<const Method> methods() { return table; }

bool has_setting(const Method& method, std::string_view key) {
  return std::ranges::any_of(method.settings(), [&](const EngineSetting& setting) { return setting.key == key; });
}

bool reads(const Method& method, std::string_view key, const Scenario& scenario) {
  const auto is_it = [&](const EngineSetting& setting) { return setting.key == key && setting.matters(scenario); };
  return std::ranges::any_of(method.settings(), is_it);
}

bool has_half_step_start(const Method& method) { return has_setting(method, "ode.start"); }

bool is_engine_setting(std::string_view key) {
  return std::ranges::any_of(table, [&](const Method& method) { return has_setting(method, key); });
}

std::string readers_of(std::string_view key) {
  std::string readers;
  std::string_view acts_on;
  for (const Method& method : table) {
    for (const EngineSetting& setting : method.settings()) {
      if (setting.key != key) continue;
      readers += (readers.empty() ? "" : ", ") + std::string(method.name);
      acts_on = setting.acts_on;
    }
  }
  return acts_on.empty() ? readers : readers + " where there are " + std::string(acts_on);
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : table) names.emplace_back(method.name);
  return names;
}

const Method& find_method(std::string_view name) {
  const auto* found = std::ranges::find(table, name, &Method::name);
  if (found == table.end()) {
    throw UserError("--method: no method named '" + std::string(name) + "'" + nearest_hint(name, method_names()) +
                    "; 'odeval list' shows all");
  }
  if (found->make == nullptr) {
    throw UserError("--method: method '" + std::string(name) + "' is left out: " + std::string(why_missing));
  }
  return *found;
}

void require_claim(const Method& method, const Problem& problem, const std::string& origin) {
  if (method.claims(problem)) return;
  std::string does;
  for (const Problem& other : problems) {
    if (method.claims(other)) does += (does.empty() ? "" : ", ") + std::string(other.name);
  }
  throw UserError(origin + ": method '" + std::string(method.name) + "' does not do problem '" +
                  std::string(problem.name) + "'; it does " + does);
}

}  // namespace odeval::catalogue
