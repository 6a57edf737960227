#pragma once
// Impacts as a scenario wants them told, seen in an ODE world.
#include <vector>

#include "engines/ode/link_angles.hpp"
#include "engines/ode/scene.hpp"
#include "odeval/motion.hpp"

namespace odeval::engine_ode {

/// Watches what has impacts of its own. An impact is a run of steps in which it touches something; the first of them
/// carries the bounce.
class Impacts {
 public:
  Impacts(const Scenario& scenario, const Scene& scene, const LinkAngles& angles);

  /// Before a step from t seconds, with the contacts that act in it: begins the impacts that begin.
  void before_step(double t);
  /// After it: their rates.
  void after_step();

  // Of a stepper that locates its impacts: just before one, and just after.
  void begin(double t);
  void end() { after_step(); }

  std::vector<Impact> take() { return std::move(impacts_); }

 private:
  double along_normal(const ImpactView& view, const dReal* vector) const;
  double depth_of(const ImpactView& view) const;
  double rate_of(const ImpactView& view) const;
  /// Whether what touches was there before the run began, and does not approach.
  bool lies(double t, const ImpactView& view) const;
  void add(double t, std::size_t view, double depth);

  std::vector<ImpactView> views_;
  const Scene& scene_;
  const LinkAngles& angles_;
  std::vector<Impact> impacts_;
  std::vector<char> touching_;      // by view, in the last step
  std::vector<std::size_t> begun_;  // views of the impacts of this step
};

}  // namespace odeval::engine_ode
