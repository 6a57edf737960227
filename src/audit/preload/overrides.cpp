#include "audit/preload/overrides.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "audit/preload/own.hpp"
#include "audit/preload/session.hpp"

namespace odeval::audit {
namespace {

/// Numbers of a world.
struct Number {
  const char* key;
  void (*set)(dWorldID, dReal);
};
const std::array numbers{
    Number{"erp", dWorldSetERP},
    Number{"cfm", dWorldSetCFM},
    Number{"iterations", [](dWorldID world, dReal n) { dWorldSetQuickStepNumIterations(world, static_cast<int>(n)); }},
    Number{"w", dWorldSetQuickStepW},
    Number{"max_correcting_vel", dWorldSetContactMaxCorrectingVel},
    Number{"surface_layer", dWorldSetContactSurfaceLayer},
};

/// A body's place and motion.
struct State {
  dVector3 position;
  dQuaternion quaternion;
  dVector3 velocity;
  dVector3 spin;
};

State state_of(dBodyID body) {
  State state{};
  std::copy_n(dBodyGetPosition(body), 3, state.position);
  std::copy_n(dBodyGetQuaternion(body), 4, state.quaternion);
  std::copy_n(dBodyGetLinearVel(body), 3, state.velocity);
  std::copy_n(dBodyGetAngularVel(body), 3, state.spin);
  return state;
}

/// Velocities of half a step before: what a step changes, half of it, the other way. Poses and forces stay.
void start_half_a_step_earlier(World& world, dReal h, Overrides::Stepper stepper) {
  std::vector<State> before;
  world.keep_forces();
  for (const Body& body : world.bodies) before.push_back(state_of(body.id));
  stepper(world.id, h);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    dBodyID body = world.bodies[i].id;
    const State& old = before[i];
    const State now = state_of(body);
    const auto earlier = [](const dReal* was, const dReal* is, int k) { return was[k] - (is[k] - was[k]) / 2; };
    dBodySetPosition(body, old.position[0], old.position[1], old.position[2]);
    dBodySetQuaternion(body, old.quaternion);
    dBodySetLinearVel(body, earlier(old.velocity, now.velocity, 0), earlier(old.velocity, now.velocity, 1),
                      earlier(old.velocity, now.velocity, 2));
    dBodySetAngularVel(body, earlier(old.spin, now.spin, 0), earlier(old.spin, now.spin, 1),
                       earlier(old.spin, now.spin, 2));
  }
  world.put_forces_back();
}

}  // namespace

Overrides::Overrides(const std::string& text) {
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) {
    const std::string key = part.substr(0, part.find('='));
    const std::string value = part.substr(std::min(part.size(), key.size() + 1));
    for (const Number& row : numbers) {
      if (key == row.key) numbers_.emplace_back(row.set, std::strtod(value.c_str(), nullptr));
    }
    if (key == "rotation") finite_rotation_ = value == "finite" ? 1 : 0;
    if (part == "start=half-step") starts_half_a_step_earlier_ = true;
    if (part == "stepper=quick") stepper_ = ODEVAL_OWN(dWorldQuickStep);
    if (part == "stepper=step") stepper_ = ODEVAL_OWN(dWorldStep);
    if (part == "stepper=accurate") stepper_ = Session::accurately;
  }
}

void Overrides::begin(World& world, dReal h, Stepper stepper) const {
  if (starts_half_a_step_earlier_) start_half_a_step_earlier(world, h, stepper);
}

void Overrides::apply(World& world) const {
  for (const auto& [set, value] : numbers_) set(world.id, value);
  if (finite_rotation_ < 0) return;
  for (const Body& body : world.bodies) dBodySetFiniteRotationMode(body.id, finite_rotation_);
}

Overrides::Stepper Overrides::chosen(Stepper of_program) const { return stepper_ != nullptr ? stepper_ : of_program; }

}  // namespace odeval::audit
