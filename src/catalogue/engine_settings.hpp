#pragma once
// Settings that belong to an engine: the keys of a scenario file that some methods read and the motion does not.
#include <span>
#include <string_view>

#include "odeval/engine.hpp"

namespace odeval::catalogue {

/// What `dWorldStep` reads.
std::span<const EngineSetting> step_settings();
/// What its rebuilt twin reads: the same, but it turns bodies in one way alone.
std::span<const EngineSetting> rebuilt_step_settings();
/// What `dWorldQuickStep` reads: the same, and how it iterates.
std::span<const EngineSetting> quickstep_settings();
/// What the accurate step reads of [ode]: the bounce alone, since it keeps joints and contacts exactly.
std::span<const EngineSetting> accurate_step_settings();
/// What the closed form of bodies at a joint reads: their spring is made of it.
std::span<const EngineSetting> closed_form_settings();
/// Whether the scenario's joints are springs, of which the true motion is made: those of the closed form.
bool joints_are_springs(const Scenario& scenario);
/// Whether a key makes such a spring: the same keys.
bool is_of_spring(std::string_view key);
/// The feedback of joint errors.
std::span<const EngineSetting> feedback_settings();
/// What Bullet reads where its bodies are held by constraints.
std::span<const EngineSetting> bullet_settings();
std::span<const EngineSetting> bullet_multibody_settings();
std::span<const EngineSetting> mujoco_settings();
/// The one tolerance of a method that has no absolute one.
std::span<const EngineSetting> accuracy_settings();
/// Tolerances of adaptive methods.
std::span<const EngineSetting> tolerance_settings();

}  // namespace odeval::catalogue
