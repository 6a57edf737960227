#include "catalogue/methods.hpp"

#include <algorithm>
#include <array>

#include "catalogue/accurate_method.hpp"
#include "engines/ode/module.hpp"
#include "engines/simbody/accuracy.hpp"
#include "engines/tree/make.hpp"
#include "model/nearest.hpp"
#include "odeval/error.hpp"
#include "output/number.hpp"
#include "reference/closed_form/analytic.hpp"
#include "reference/dh/dh_ode45.hpp"
#include "reference/maximal/fixed_step.hpp"
#include "reference/maximal/ode_step_simulation.hpp"
#include "reference/planar/cvode.hpp"
#include "reference/planar/fixed_step.hpp"
#include "reference/planar/ode45.hpp"
#include "reference/planar/quad.hpp"
#include "reference/providers.hpp"

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

constexpr auto mass_matrix = SystemMatrix::mass_matrix;
constexpr auto hinge_rows = SystemMatrix::hinge_rows;
constexpr auto hinge_rows_cfm = SystemMatrix::hinge_rows_cfm;
constexpr auto planar_joints = SystemMatrix::planar_joints;

// What each can do, beyond one link that swings freely.
constexpr Features two_links{Feature::several_links};
constexpr Features any_chain{Feature::several_links, Feature::many_links};
constexpr Features chain_or_one_at_wall = any_chain | Features{Feature::wall};
constexpr Features any_planar = chain_or_one_at_wall | Features{Feature::wall_of_several};
constexpr Features touching_bodies = any_planar | Features{Feature::space, Feature::ground};
constexpr Features joined_bodies{Feature::space, Feature::joints_in_space, Feature::inertia};
constexpr Features trees_of_bodies = any_chain | joined_bodies | Features{Feature::loads};
constexpr Features driven_trees = trees_of_bodies | Features{Feature::motors};
constexpr Features bouncing_stops{Feature::stops, Feature::bouncing_stops};
constexpr Features touching_trees =
    trees_of_bodies | any_planar | Features{Feature::ground, Feature::friction, Feature::stops};
constexpr Features driven_bodies =
    joined_bodies | bouncing_stops |
    Features{Feature::motors, Feature::loads, Feature::loops, Feature::rare_joints, Feature::struts};
constexpr Features accurate =
    touching_bodies | driven_bodies | Features{Feature::friction, Feature::rare_shapes, Feature::axis_drives};
// What the accurate step does not read off ODE.
constexpr Features unread_of_ode{Feature::cross_stops, Feature::plane_motors};
constexpr Features soft_contacts{Feature::soft_contacts, Feature::sprung_contacts};
constexpr Features all_of_ode =
    accurate | unread_of_ode | soft_contacts | Features{Feature::constant_friction, Feature::open_joints};
constexpr Features closed_form{Feature::wall,
                               Feature::space,
                               Feature::ground,
                               Feature::friction,
                               Feature::constant_friction,
                               Feature::joints_in_space,
                               Feature::open_joints};

std::vector<Method> engines_of_ode() {
  const std::span<const EngineSetting> step = step_settings();
  const std::span<const EngineSetting> quickstep = quickstep_settings();
  const std::string_view single = without_single_precision;
  const std::string_view bodies = "ODE bodies and joints";
  return {
      {"ode-step-double", bodies, "dWorldStep, double precision", 1, 0, 0, all_of_ode, step_double, step,
       hinge_rows_cfm},
      {"ode-step-single", bodies, "dWorldStep, single precision", 1, 0, 0, all_of_ode, step_single, step,
       hinge_rows_cfm, single},
      {"ode-quickstep-double", bodies, "dWorldQuickStep, double precision", 1, 0, 0, all_of_ode, quickstep_double,
       quickstep, hinge_rows_cfm},
      {"ode-quickstep-single", bodies, "dWorldQuickStep, single precision", 1, 0, 0, all_of_ode, quickstep_single,
       quickstep, hinge_rows_cfm, single},
      {"ode-rk4-double", bodies, "odeval's Runge-Kutta step beside ODE's collision detection", 4, 0, 0, accurate,
       make_accurate_4, accurate_step_settings(), hinge_rows},
      {"ode-rk8-double", bodies, "the same of order 8, for smooth motion", 8, 0, 0, accurate, make_accurate_8,
       accurate_step_settings(), hinge_rows},
  };
}

std::vector<Method> methods_in_joint_coordinates() {
  const std::span<const EngineSetting> tolerances = tolerance_settings();
  const std::span<const EngineSetting> none;
  const auto tight = reference::tight_tolerances;
  const double rtol = reference::ode45_rtol;
  const double atol = reference::ode45_atol;
  const std::string_view lagrangian = "closed-form Lagrangian";
  const std::string_view ode45 = "Dormand-Prince 5(4) as MATLAB's ode45";
  return {
      {reference_method, lagrangian, "SUNDIALS CVODE, Adams: the reference", 0, tight.rtol, tight.atol,
       any_planar | Features{Feature::space}, reference::make_cvode, tolerances, mass_matrix},
      {"lagrange-quad", lagrangian, "extrapolation in quad precision: certifies the reference", 0, 0, 0, two_links,
       reference::make_quad, none, mass_matrix},
      {"lagrange-ode45", lagrangian, ode45, 0, rtol, atol, chain_or_one_at_wall, reference::make_ode45, tolerances,
       mass_matrix},
      {"dh-ode45", "recursive Newton-Euler from DH parameters", ode45, 0, rtol, atol, any_chain,
       reference::make_dh_ode45, tolerances, mass_matrix},
      {"lagrange-rk4", lagrangian, "classical Runge-Kutta, fixed step", 4, 0, 0, chain_or_one_at_wall,
       reference::make_rk4, none, mass_matrix},
      {"lagrange-euler", lagrangian, "explicit Euler, fixed step", 1, 0, 0, chain_or_one_at_wall, reference::make_euler,
       none, mass_matrix},
      {"lagrange-symplectic-euler", lagrangian, "symplectic Euler, fixed step", 1, 0, 0, chain_or_one_at_wall,
       reference::make_symplectic_euler, none, mass_matrix},
  };
}

std::vector<Method> methods_of_bodies() {
  const std::string_view multipliers = "Newton-Euler with Lagrange multipliers";
  const auto tight = reference::tight_tolerances;
  return {
      {"maximal-euler", multipliers, "explicit Euler, fixed step", 1, 0, 0, two_links, reference::make_maximal_euler,
       feedback_settings(), planar_joints},
      {"maximal-rk4", multipliers, "classical Runge-Kutta, fixed step", 4, 0, 0, two_links, reference::make_maximal_rk4,
       feedback_settings(), planar_joints},
      {"maximal-ode-step", "one dWorldStep rebuilt", "ODE's own scheme, fixed step", 1, 0, 0, chain_or_one_at_wall,
       reference::make_maximal_ode_step, rebuilt_step_settings(), hinge_rows_cfm},
      {"mechanism-cvode", "Simbody's equations of a tree", "SUNDIALS CVODE, Adams: the reference of trees of bodies", 0,
       tight.rtol, tight.atol,
       any_chain | driven_bodies | unread_of_ode |
           Features{Feature::ground, Feature::rare_shapes, Feature::axis_drives},
       reference::mechanism_cvode, tolerance_settings(), mass_matrix,
       "this build has no Simbody (libsimbody-dev); scripts/install-deps installs it, then configure again"},
      {"analytic", "closed form", "elliptic functions and the like", 0, 0, 0, closed_form, reference::make_analytic,
       closed_form_settings(), mass_matrix},
  };
}

#ifdef ODEVAL_HAVE_MUJOCO
constexpr bool has_mujoco = true;
#else
constexpr bool has_mujoco = false;
#endif
#ifdef ODEVAL_HAVE_BULLET
constexpr bool has_bullet = true;
#else
constexpr bool has_bullet = false;
#endif
#ifdef ODEVAL_HAVE_BULLET_SINGLE
constexpr bool has_bullet_single = true;
#else
constexpr bool has_bullet_single = false;
#endif
#ifdef ODEVAL_HAVE_DART
constexpr bool has_dart = true;
#else
constexpr bool has_dart = false;
#endif
#ifdef ODEVAL_HAVE_SIMBODY
constexpr bool has_simbody = true;
#else
constexpr bool has_simbody = false;
#endif

/// A row of an engine whose methods are in a module: its name twice, as that knows it and as the table does.
template <bool here, engine_tree::Word engine, engine_tree::Word method>
Method beside_ode(std::string_view formulation, std::string_view advanced_by, int order, Features can,
                  std::span<const EngineSetting> settings, SystemMatrix inverts, std::string_view why_missing,
                  double rtol = 0) {
  return {method.letters, formulation, advanced_by, order, rtol, 0, can, engine_tree::made_by<here, engine, method>,
          settings,       inverts,     why_missing, true};
}

std::vector<Method> engines_beside_ode() {
  const std::string_view joint_coordinates = "joint coordinates";
  const std::string_view constraints = "Bullet bodies and constraints";
  const std::string_view no_mujoco =
      "this build has no MuJoCo (libmujoco-dev); scripts/install-deps installs it, then configure again";
  const std::string_view no_bullet =
      "this build has no Bullet (libbullet-dev); scripts/install-deps installs it, then configure again";
  const std::string_view no_dart =
      "this build has no DART (libdart-dev); scripts/install-deps --engines installs it, then configure again";
  const std::string_view no_simbody =
      "this build has no Simbody (libsimbody-dev); scripts/install-deps installs it, then configure again";
  const std::span<const EngineSetting> none;
  const auto inverts = SystemMatrix::mass_matrix;
  const Features mujoco = touching_trees | bouncing_stops | Features{Feature::loops};
  const Features hinge = touching_trees | soft_contacts | Features{Feature::motors, Feature::loops};
  const Features multibody = touching_trees | soft_contacts | Features{Feature::motors};
  const Features simbody = trees_of_bodies | Features{Feature::loops};
  const double accuracy = engine_simbody::default_accuracy;
  return {
      beside_ode<has_mujoco, "mujoco", "mujoco-euler">(joint_coordinates, "MuJoCo's semi-implicit Euler", 1, mujoco,
                                                       mujoco_settings(), inverts, no_mujoco),
      beside_ode<has_mujoco, "mujoco", "mujoco-implicit">(joint_coordinates, "MuJoCo's Euler, implicit in velocities",
                                                          1, mujoco, mujoco_settings(), inverts, no_mujoco),
      beside_ode<has_mujoco, "mujoco", "mujoco-rk4">(joint_coordinates, "MuJoCo's Runge-Kutta", 4, mujoco,
                                                     mujoco_settings(), inverts, no_mujoco),
      beside_ode<has_bullet, "bullet", "bullet-hinge-double">(constraints, "btDiscreteDynamicsWorld, double precision",
                                                              1, hinge, bullet_settings(), hinge_rows, no_bullet),
      beside_ode<has_bullet_single, "bullet_single", "bullet-hinge-single">(
          constraints, "btDiscreteDynamicsWorld, single precision", 1, hinge, bullet_settings(), hinge_rows, no_bullet),
      beside_ode<has_bullet, "bullet", "bullet-multibody-double">(joint_coordinates, "btMultiBody, double precision", 1,
                                                                  multibody, bullet_multibody_settings(), inverts,
                                                                  no_bullet),
      beside_ode<has_bullet_single, "bullet_single", "bullet-multibody-single">(
          joint_coordinates, "btMultiBody, single precision", 1, multibody, bullet_multibody_settings(), inverts,
          no_bullet),
      beside_ode<has_bullet, "bullet", "bullet-multibody-rk4-double">(
          joint_coordinates, "btMultiBody with its Runge-Kutta, double precision", 4, trees_of_bodies, none, inverts,
          no_bullet),
      beside_ode<has_dart, "dart", "dart-step">(joint_coordinates, "DART's World::step", 1,
                                                touching_trees | Features{Feature::motors}, none, inverts, no_dart),
      beside_ode<has_simbody, "simbody", "simbody-semi-explicit">(joint_coordinates, "Simbody's semi-explicit Euler", 1,
                                                                  simbody, none, inverts, no_simbody),
      beside_ode<has_simbody, "simbody", "simbody-merson">(joint_coordinates,
                                                           "Simbody's Kutta-Merson, steps of its own", 0, simbody,
                                                           accuracy_settings(), inverts, no_simbody, accuracy),
  };
}

/// In the order of every list.
std::vector<Method> make_table() {
  std::vector<Method> table = engines_of_ode();
  std::ranges::move(engines_beside_ode(), std::back_inserter(table));
  std::ranges::move(methods_in_joint_coordinates(), std::back_inserter(table));
  std::ranges::move(methods_of_bodies(), std::back_inserter(table));
  return table;
}

}  // namespace

std::span<const Method> methods() {
  static const std::vector<Method> table = make_table();
  return table;
}

bool has_setting(const Method& method, std::string_view key) {
  return std::ranges::any_of(method.settings, [&](const EngineSetting& setting) { return setting.key == key; });
}

bool reads(const Method& method, std::string_view key, const Scenario& scenario) {
  const auto is_it = [&](const EngineSetting& setting) { return setting.key == key && setting.matters(scenario); };
  return std::ranges::any_of(method.settings, is_it);
}

bool has_half_step_start(const Method& method) { return has_setting(method, "ode.start"); }

bool is_plain_ode(std::string_view method) {
  const auto found = std::ranges::find(methods(), method, &Method::name);
  return found != methods().end() && method.starts_with("ode-") && has_half_step_start(*found);
}

bool is_engine_setting(std::string_view key) {
  return std::ranges::any_of(methods(), [&](const Method& method) { return has_setting(method, key); });
}

std::string readers_of(std::string_view key) {
  std::vector<std::pair<std::string_view, std::string>> groups;  // what it acts on, and the methods that read it there
  for (const Method& method : methods()) {
    for (const EngineSetting& setting : method.settings) {
      if (setting.key != key) continue;
      auto group = std::ranges::find(groups, setting.acts_on, [](const auto& one) { return one.first; });
      if (group == groups.end()) group = groups.insert(group, {setting.acts_on, ""});
      group->second += (group->second.empty() ? "" : ", ") + std::string(method.name);
    }
  }
  std::string readers;
  for (const auto& [acts_on, names] : groups) {
    readers += (readers.empty() ? "" : "; ") + names;
    if (!acts_on.empty()) readers += " where there are " + std::string(acts_on);
  }
  return readers;
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.emplace_back(method.name);
  return names;
}

const Method& find_method(std::string_view name) {
  const auto found = std::ranges::find(methods(), name, &Method::name);
  if (found == methods().end()) {
    throw UserError("--method: no method named '" + std::string(name) + "'" + nearest_hint(name, method_names()) +
                    "; 'odeval list' shows all");
  }
  if (found->make == nullptr) {
    throw UserError("--method: method '" + std::string(name) + "' is left out: " + std::string(found->why_missing));
  }
  return *found;
}

bool does(const Method& method, const Scenario& scenario) { return (features_of(scenario) - method.can).empty(); }

namespace {

/// What MuJoCo would take for two steps without a word, its own time constant at a long step as well.
void require_slow_enough(const Method& method, const Scenario& scenario) {
  const double asked_s = scenario.mujoco.time_constant_s;
  const double least_s = 2 * scenario.step_s;
  if (asked_s >= least_s) return;
  if (!reads(method, "mujoco.time_constant", scenario)) return;
  throw UserError(scenario.file + ": mujoco.time_constant is " + number_text(asked_s) + " s and step is " +
                  number_text(scenario.step_s) + " s: must be at least two steps, " + number_text(least_s) +
                  " s, for " + std::string(method.name));
}

}  // namespace

namespace {

/// Whether it takes the scenario for a start: features are not all that a method may ask for, such as a box alone.
bool takes(const Method& method, const Scenario& scenario) {
  if (method.make == nullptr || !does(method, scenario)) return false;
  try {
    require_slow_enough(method, scenario);
    method.make(scenario, sample_grid(scenario));
    return true;
  } catch (const UserError&) {
    return false;
  } catch (const MachineError&) {
    return false;
  }
}

}  // namespace

void require_does(std::span<const Method* const> methods, const Scenario& scenario, const std::string& origin) {
  std::string lacks;
  for (const Method* const method : methods) {
    require_slow_enough(*method, scenario);
    const Features missing = features_of(scenario) - method->can;
    if (missing.empty()) continue;
    const std::string name = "'" + std::string(method->name) + "'";
    lacks += lacks.empty()
                 ? "method " + name + " can not do scenario '" + scenario.name + "', which has " + listed(missing)
                 : ", nor can " + name + " (" + listed(missing) + ")";
  }
  if (lacks.empty()) return;
  std::string others;
  for (const Method& other : catalogue::methods()) {
    if (takes(other, scenario)) others += (others.empty() ? "" : ", ") + std::string(other.name);
  }
  throw UserError(origin + ": " + lacks +
                  (others.empty() ? "; no method of this build can" : "; these can: " + others));
}

void require_does(const Method& method, const Scenario& scenario, const std::string& origin) {
  const Method* const one = &method;
  require_does(std::span(&one, 1), scenario, origin);
}

}  // namespace odeval::catalogue
