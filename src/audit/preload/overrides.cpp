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
    const std::size_t sign = part.find('=');
    if (sign != std::string::npos) values_[part.substr(0, sign)] = part.substr(sign + 1);
  }
}

bool Overrides::says(const char* key, const char* word) const {
  const auto found = values_.find(key);
  return found != values_.end() && found->second == word;
}

void Overrides::begin(World& world, dReal h, Stepper stepper) const {
  if (says("start", "half-step")) start_half_a_step_earlier(world, h, stepper);
}

void Overrides::apply(World& world) const {
  if (values_.empty()) return;
  for (const Number& row : numbers) {
    const auto found = values_.find(row.key);
    if (found != values_.end()) row.set(world.id, std::strtod(found->second.c_str(), nullptr));
  }
  if (values_.find("rotation") == values_.end()) return;
  for (const Body& body : world.bodies) dBodySetFiniteRotationMode(body.id, says("rotation", "finite") ? 1 : 0);
}

Overrides::Stepper Overrides::chosen(Stepper of_program) const {
  if (says("stepper", "quick")) return ODEVAL_OWN(dWorldQuickStep);
  if (says("stepper", "accurate")) return Session::accurately;
  if (says("stepper", "step")) return ODEVAL_OWN(dWorldStep);
  return of_program;
}

}  // namespace odeval::audit
