#pragma once
// The true motion of a scenario's bodies: what method `analytic` shows and every error is measured against.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "odeval/engine.hpp"
#include "odeval/scenario.hpp"

namespace odeval::reference {

/// How far a motion may itself be off, of the worst body.
struct BodyUncertainty {
  double position_m = 0;
  double turn_rad = 0;
  double spin_rad_s = 0;
};

/// Where a scenario's bodies are at any time from one step before the start on (the half-step start asks for that).
class BodyMotion {
 public:
  virtual ~BodyMotion() = default;

  /// States of all bodies and joints, in the mechanism's order, at t seconds. At an impact: after it.
  virtual void at(double t, std::span<BodyState> bodies, std::span<JointState> joints) const = 0;

  /// Bound on the error of `at`.
  virtual BodyUncertainty uncertainty(double t) const = 0;

  /// Of the first body with the ground, up to a time.
  virtual std::vector<Impact> impacts(double) const { return {}; }

  /// From when on the first body rests on the ground, s; < 0: never.
  virtual double at_rest_from() const { return -1; }

  /// Where it comes from, in a few words for tables and summaries.
  virtual std::string origin() const = 0;
};

/// What closed forms of bodies know.
inline constexpr Features known_of_bodies{
    Feature::space,           Feature::ground,      Feature::friction,     Feature::constant_friction,
    Feature::joints_in_space, Feature::open_joints, Feature::soft_contacts};

/// Whether there is a closed form for bodies, joints and contacts like the scenario's. A chain in a plane has none
/// here.
bool has_body_motion(const Scenario& scenario);

/// Throws UserError when the scenario asks for what has no closed form.
std::unique_ptr<BodyMotion> make_body_motion(const Scenario& scenario);

}  // namespace odeval::reference
