#pragma once
// A fourth-order step for worlds of the Open Dynamics Engine: what one calls instead of dWorldStep when the motion has
// to be right. Collision detection, bodies, joints and geoms stay ODE's own.
//
//   odeval::AccurateStep step(world, space, {.contact = [](dGeomID, dGeomID) { return odeval::Bounce{0.8}; }});
//   step(1e-3);  // instead of dSpaceCollide, dWorldStep, dJointGroupEmpty
//
// Bodies are moved by the Newton-Euler equations with Lagrange multipliers and classical Runge-Kutta; at the end of
// each step positions and velocities are projected onto the joints, mass-weighted, so that a joint's gap stays at
// rounding. ODE's ERP and CFM have no part in it.
//
// Double precision only: link with a double-precision ODE.
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

struct dxBody;   // ODE's dBodyID is dxBody*
struct dxGeom;   // dGeomID
struct dxSpace;  // dSpaceID
struct dxWorld;  // dWorldID

namespace odeval {

/// The world holds what this step can not do, or a state it can not start from. The message names the body or joint by
/// its number in the order of discovery and says what would be right. The world is as it was before the call.
class AccurateStepError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What happens where two geoms touch. Friction is not modelled.
struct Bounce {
  double restitution = 0;  // 0..1, of the normal velocity (Newton's law)
};

/// One located impact.
struct Touch {
  double t;          // s, since the step began
  double approach;   // m/s, normal speed at the fastest contact point before it
  double departure;  // m/s, of the same point after it
  std::size_t contacts;
};

struct AccurateStepOptions {
  /// Asked for each pair of geoms whose bodies no joint connects; nothing: they pass through each other. Without the
  /// function nothing touches anything.
  std::function<std::optional<Bounce>(dxGeom*, dxGeom*)> contact;
  /// Called at each impact, while ODE's bodies show poses and velocities just before it, and just after it.
  std::function<void(const Touch&)> before_impact;
  std::function<void(const Touch&)> after_impact;
  /// Bodies that neither a geom of the space nor a joint leads to: ODE has no list of a world's bodies.
  std::vector<dxBody*> bodies;
  /// m and rad. Larger joint errors than this are an AccurateStepError; smaller ones the first step's projection mends.
  double start_gap = 1e-3;
  /// m/s. A body that comes to a contact slower than this does not bounce but rests.
  double rest_speed = 1e-3;
  /// Impacts located in one step; further ones in the same step do not bounce.
  int most_impacts = 64;
};

/// Steps one world. The world, its space, bodies and joints stay the user's: poses, velocities and forces are read from
/// ODE at the start of each call and written back at its end, so everything else a program does with them goes on
/// working. Joints and bodies that come and go are noticed.
class AccurateStep {
 public:
  /// Throws AccurateStepError for what is not supported: joints other than ball, hinge, slider, universal and fixed;
  /// motors and stops; kinematic or disabled bodies; damping and speed limits.
  explicit AccurateStep(dxWorld* world, dxSpace* space = nullptr, AccurateStepOptions options = {});
  ~AccurateStep();
  AccurateStep(AccurateStep&&) noexcept;
  AccurateStep& operator=(AccurateStep&&) noexcept;

  /// Advances the world by h > 0 seconds. Forces and torques added to the bodies act throughout the step and are then
  /// cleared, as dWorldStep does. Joint feedback structures get the forces at the end of the step.
  void operator()(double h);

  /// Impacts of the last step, in order.
  const std::vector<Touch>& touches() const;
  std::size_t bodies() const;
  std::size_t joints() const;

 private:
  class World;
  std::unique_ptr<World> world_;
};

}  // namespace odeval
