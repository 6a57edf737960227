#pragma once
// The door for steppers that are not ODE's own: they move a world that the adapter has built.
#include <functional>
#include <memory>
#include <optional>

struct dxGeom;
struct dxSpace;
struct dxWorld;

namespace odeval::engine_ode {

/// How two geoms touch.
struct Touching {
  double restitution = 0;
  double friction = 0;  // Coulomb's coefficient
};

/// What a stepper is given. Handles only; no ODE type crosses the modules' border.
struct SteppedWorld {
  dxWorld* world;
  dxSpace* space;
  std::function<std::optional<Touching>(dxGeom*, dxGeom*)> contact;  // nothing: they pass through each other
  std::function<void(double after_s)> loads;          // adds forces to the bodies as they are; empty: there are none
  std::function<void(double after_s)> before_impact;  // called with the world's bodies as they are just before
  std::function<void()> after_impact;                 // and just after
};

class WorldStepper {
 public:
  virtual ~WorldStepper() = default;

  /// Advances the world by h seconds. Throws std::exception when it can not; the run has then diverged.
  virtual void step(double h) = 0;
};

using MakeStepper = std::unique_ptr<WorldStepper> (*)(const SteppedWorld&);

}  // namespace odeval::engine_ode
