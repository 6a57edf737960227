#pragma once
// Settings that belong to an engine: the keys of a scenario file that some methods read and the motion does not.
#include <span>
#include <string_view>

#include "odeval/scenario.hpp"

namespace odeval::catalogue {

/// A key that an engine reads, and where it makes a difference.
struct EngineSetting {
  std::string_view key;              // "ode.erp"
  bool (*matters)(const Scenario&);  // whether the engine finds in the scenario what the setting acts on
  std::string_view acts_on;          // that, in words: "joints or contacts"
};

std::span<const EngineSetting> no_settings();
/// What `dWorldStep` and its rebuilt twin read.
std::span<const EngineSetting> step_settings();
/// What `dWorldQuickStep` reads: the same, and how it iterates.
std::span<const EngineSetting> quickstep_settings();
/// What the accurate step reads: restitution alone, since it keeps joints and contacts exactly.
std::span<const EngineSetting> accurate_step_settings();
/// What the closed form of bodies at a joint reads: their spring is made of it.
std::span<const EngineSetting> closed_form_settings();
/// The feedback of joint errors.
std::span<const EngineSetting> feedback_settings();
/// Tolerances of adaptive methods.
std::span<const EngineSetting> tolerance_settings();

}  // namespace odeval::catalogue
