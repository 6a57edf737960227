#include "catalogue/engine_settings.hpp"

#include <algorithm>
#include <array>

#include "reference/closed_form/body_motion.hpp"

namespace odeval::catalogue {
namespace {

bool anywhere(const Scenario&) { return true; }
bool touching(const Scenario& scenario) { return !scenario.mechanism.contacts.empty(); }
bool constrained(const Scenario& scenario) { return !scenario.mechanism.joints.empty() || touching(scenario); }
/// Whether ODE's bounce acts: what a spring and a damper give back is theirs.
bool may_bounce(const Scenario& scenario) {
  return !std::ranges::all_of(scenario.mechanism.contacts, [](const Contact& contact) { return !!contact.spring; });
}
bool bouncing(const Scenario& scenario) {
  return std::ranges::any_of(scenario.mechanism.contacts, [&](const Contact& contact) {
    return !contact.spring && scenario.ode.bounce.value_or(contact.restitution) > 0;
  });
}
bool rubbing(const Scenario& scenario) {
  return std::ranges::any_of(scenario.mechanism.contacts,
                             [](const Contact& contact) { return contact.friction && contact.friction->limit > 0; });
}

/// Whether contacts have not all an ERP and a CFM of their own.
bool has_worlds_softness(const Scenario& scenario) {
  return std::ranges::any_of(scenario.mechanism.contacts,
                             [](const Contact& contact) { return !contact.softness && !contact.spring; });
}
/// Whether the world's ERP acts.
bool corrected(const Scenario& scenario) { return !scenario.mechanism.joints.empty() || has_worlds_softness(scenario); }
/// The same of what has no rows for its joints.
bool pressed_by_erp(const Scenario& scenario) {
  return features_of(scenario).has(Feature::stops) || has_worlds_softness(scenario);
}
/// Whether the world's CFM acts, which is that of friction as well.
bool softened(const Scenario& scenario) { return corrected(scenario) || rubbing(scenario); }

bool pressed(const Scenario& scenario) { return touching(scenario) || features_of(scenario).has(Feature::stops); }
bool held(const Scenario& scenario) { return pressed(scenario) || features_of(scenario).has(Feature::motors); }
bool soft(const Scenario& scenario) { return pressed(scenario) || features_of(scenario).has(Feature::loops); }

constexpr EngineSetting on_constraints(std::string_view key) { return {key, constrained, "joints or contacts"}; }
constexpr EngineSetting on_contacts(std::string_view key) { return {key, touching, "contacts"}; }

constexpr std::string_view soft_rows = "joints or contacts";

constexpr std::array of_quickstep{
    on_constraints("ode.iterations"), on_constraints("ode.sor_w"), on_constraints("ode.seed"),
    // and what dWorldStep reads as well:
    EngineSetting{"ode.rotation", anywhere, ""},
    // and its rebuilt twin:
    EngineSetting{"ode.erp", corrected, soft_rows}, EngineSetting{"ode.cfm", softened, soft_rows},
    EngineSetting{"ode.kp", softened, soft_rows}, EngineSetting{"ode.kd", softened, soft_rows},
    EngineSetting{"ode.bounce", may_bounce, "contacts"},
    EngineSetting{"ode.bounce_vel", bouncing, "contacts that bounce"}, on_contacts("ode.max_correcting_vel"),
    on_contacts("ode.surface_layer"), EngineSetting{"ode.friction_axes", rubbing, "contacts with friction"},
    EngineSetting{"ode.start", anywhere, ""}, EngineSetting{"ode.gyroscopic", anywhere, ""}};
constexpr std::size_t only_quickstep = 3;
constexpr std::size_t only_ode = only_quickstep + 1;
constexpr std::array of_accurate_step{on_contacts("ode.bounce")};
constexpr EngineSetting on_spring(std::string_view key) { return {key, joints_are_springs, "joints that are springs"}; }
constexpr std::array of_closed_form{on_spring("ode.erp"), on_spring("ode.cfm"), on_spring("ode.kp"),
                                    on_spring("ode.kd")};
constexpr std::array of_feedback{EngineSetting{"maximal.ks", anywhere, ""}, EngineSetting{"maximal.kd", anywhere, ""}};
constexpr std::array of_bullet{on_constraints("bullet.iterations"), EngineSetting{"bullet.erp", corrected, soft_rows}};
constexpr std::array of_multibody{EngineSetting{"bullet.iterations", held, "contacts, stops or motors"},
                                  EngineSetting{"bullet.erp", pressed_by_erp, "contacts or stops"}};
constexpr std::array of_mujoco{EngineSetting{"mujoco.time_constant", soft, "contacts, stops or loops"},
                               EngineSetting{"mujoco.cone", rubbing, "contacts with friction"}};
constexpr std::array of_tolerances{EngineSetting{"rtol", anywhere, ""}, EngineSetting{"atol", anywhere, ""}};

}  // namespace

std::span<const EngineSetting> step_settings() { return quickstep_settings().subspan(only_quickstep); }
std::span<const EngineSetting> rebuilt_step_settings() { return quickstep_settings().subspan(only_ode); }
std::span<const EngineSetting> quickstep_settings() { return of_quickstep; }
std::span<const EngineSetting> accurate_step_settings() { return of_accurate_step; }
std::span<const EngineSetting> closed_form_settings() { return of_closed_form; }
bool joints_are_springs(const Scenario& scenario) {
  return !scenario.mechanism.joints.empty() && reference::has_body_motion(scenario);
}
bool is_of_spring(std::string_view key) {
  return std::ranges::find(of_closed_form, key, &EngineSetting::key) != of_closed_form.end();
}
std::span<const EngineSetting> feedback_settings() { return of_feedback; }
std::span<const EngineSetting> bullet_settings() { return of_bullet; }
std::span<const EngineSetting> bullet_multibody_settings() { return of_multibody; }
std::span<const EngineSetting> mujoco_settings() { return of_mujoco; }
std::span<const EngineSetting> accuracy_settings() { return tolerance_settings().first(1); }
std::span<const EngineSetting> tolerance_settings() { return of_tolerances; }

}  // namespace odeval::catalogue
