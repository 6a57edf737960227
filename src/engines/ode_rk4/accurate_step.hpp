#pragma once
// A fourth-order step for worlds of the Open Dynamics Engine (eighth on request): what one calls instead of dWorldStep
// when the motion has to be right. Collision detection, bodies, joints and geoms stay ODE's own.
//
//   odeval::AccurateStep step(world, space, {.contact = [](dGeomID, dGeomID) { return odeval::Bounce{0.8}; }});
//   step(1e-3);  // instead of dSpaceCollide, dWorldStep, dJointGroupEmpty
//
// Bodies are moved by the Newton-Euler equations with Lagrange multipliers (solved along the joints where these make
// trees) and a Runge-Kutta formula; at the end of each step positions and velocities are projected onto the joints,
// mass-weighted, so that a joint's gap stays at rounding. ODE's ERP and CFM have no part in it.
//
// A motor (dParamVel, dParamFMax) keeps its velocity as a joint keeps its axis, and pushes with its limit where it can
// not; it reaches and leaves its limit where that happens within the step. A stop (dParamLoStop, dParamHiStop) is a
// contact with the restitution dParamBounce. Velocities and limits may change at every step.
//
// Double precision only: link with a double-precision ODE.
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

struct dxBody;   // ODE's dBodyID is dxBody*
struct dxGeom;   // dGeomID
struct dxJoint;  // dJointID
struct dxSpace;  // dSpaceID
struct dxWorld;  // dWorldID

namespace odeval {

/// The world holds what this step can not do, or a state it can not start from or come to. The message says what would
/// be right. It numbers bodies: AccurateStepOptions::bodies in their order, then those of the space's geoms in the
/// order the geoms were made or last moved, then what joints lead to; a body keeps its number. The world is as it was
/// before the call, to the last bit.
class AccurateStepError : public std::runtime_error {
 public:
  explicit AccurateStepError(const std::string& what, dxBody* of_body = nullptr, dxJoint* of_joint = nullptr)
      : std::runtime_error(what), body(of_body), joint(of_joint) {}

  dxBody* body;    // that the message speaks of, if any
  dxJoint* joint;  // likewise
};

/// What happens where two geoms touch.
struct Bounce {
  double restitution = 0;  // 0..1, of the normal velocity (Newton's law)
  double friction = 0;     // >= 0 and finite, Coulomb's coefficient, sticking and sliding: a round cone
  /// m, >= 0, at each contact point, as ODE has them with dContactRolling and dContactApprox1: the torque about axes in
  /// the contact's plane is at most rho times the normal force, in a round disc, and acts against rolling there; that
  /// about the normal is at most rhoN times the normal force, against spinning there.
  double rho = 0;
  double rhoN = 0;
};

/// What several contacts at one moment do (touching rows, corners, what leans on each other). Either way kinetic energy
/// after is at most what it was, the same where every restitution is 1, and no contact pulls; through joints too. The
/// outcome does not hang on the step or on the order in which geoms were made. Friction acts on what bounces after
/// that, within the cones of these impulses: it may slow what leaves, and what it makes to close stops without a
/// bounce. Where nothing bounces, Coulomb's law holds of all impulses at once.
enum class ImpactOrder {
  /// One impact, by Newton's law with complementarity: every contact leaves at least as fast as its restitution says,
  /// and at just that speed where it pushes. A ball that hits a row of four equal ones comes back at 3/5 of its speed,
  /// and the row leaves together.
  together,
  /// Pairs of geoms one after the other, the fastest first, equally fast ones together: Newton's cradle. A ball that
  /// hits a row stops, and the last one leaves.
  in_turn,
};

/// One located impact.
struct Touch {
  double t;          // s, since the step began
  double approach;   // m/s, normal speed at the fastest contact point before it; rad/s at the stop of a turn
  double departure;  // likewise, of the same point after it
  std::size_t contacts;
};

/// Its functions are called during a step. They may throw: the step then puts the world back and lets it pass. They
/// must not change what they are not asked for.
struct AccurateStepOptions {
  /// Asked for each pair of geoms, in spaces within the space too, whose bodies no joint connects; nothing: they pass
  /// through each other. Without the function nothing touches anything.
  std::function<std::optional<Bounce>(dxGeom*, dxGeom*)> contact;
  /// Forces that change within a step: springs, drag, controllers. Called at each stage (four a step, twelve of order
  /// 8, more where an impact is looked for) with the seconds since the step began, while ODE's bodies show poses and
  /// velocities of that moment; adds to the bodies' forces and torques. What was added before the step acts besides.
  std::function<void(double t)> forces;
  /// Called at each impact, while ODE's bodies show poses and velocities just before it, and just after it.
  std::function<void(const Touch&)> before_impact;
  std::function<void(const Touch&)> after_impact;
  /// Of a linear motor's axis: the `rel` that dJointSetLMotorAxis was given for it (0: fixed to the world, 1 or 2: to
  /// the first or the second body), which ODE has no function to ask for. Called when joints are read. Without it a
  /// linear motor with a force is refused.
  std::function<int(dxJoint* lmotor, int axis)> lmotor_axis_rel;
  /// Bodies that neither a geom of the space nor a joint leads to, for ODE has no list of a world's bodies; others may
  /// be named too. They must live as long as the step. A world that has more bodies than were found is refused when it
  /// is read: at first, and where geoms, joints or bodies have changed.
  std::vector<dxBody*> bodies;
  /// m and rad, > 0. A larger error of a joint at the start of a step, and a larger overlap at the start of a run that
  /// can not be pushed out, are an AccurateStepError; smaller errors are mended by projection.
  double start_gap = 1e-3;
  /// m/s, >= 0. What comes to a contact slower than this does not bounce, and what leaves it slower rests.
  double rest_speed = 1e-3;
  /// Of contacts that are closed at the moment of an impact, or nearer than 1e-9 m and closed by it.
  ImpactOrder impact_order = ImpactOrder::together;
  /// Impacts located in one step, at least 1; further ones in the same step do not bounce.
  int most_impacts = 64;
  /// Of the error in the step: 4 (classical Runge-Kutta, 4 stages) or 8 (Dormand and Prince, 12 stages), which pays
  /// where motion is smooth and has to be right to 1e-7 or better. Impacts, stops and motors' limits are located by
  /// steps of the same formula that end at them; rest and friction keep the order that they have.
  int order = 4;
};

/// Steps one world. The world, its space, bodies and joints stay the user's: poses, velocities and forces are read from
/// ODE at the start of each call and written back at its end, so everything else a program does with them goes on
/// working. Joints, bodies and geoms that come and go or are changed are noticed at the next call.
class AccurateStep {
 public:
  /// Throws AccurateStepError for what is not supported: contact joints of the user's, double balls of no length;
  /// linear motors of which lmotor_axis_rel does not tell, dAMotorEuler; stops of universal joints, of the turns of PU
  /// joints, and of angular and linear motors, stops the wrong way round, a dParamBounce that is not 0 to 1;
  /// transmissions with backlash, with wheels that do not lie in one plane, or with bevel wheels whose axes do not
  /// meet; piston, PR, PU and plane2d joints with the world as their first body; limits of angular speed, damping that
  /// is not at least 0 and less than 1, masses that are not positive, the gyroscopic term off; options out of their
  /// range, bodies of another world. The step throws it for suspensions that are stiffer than it follows.
  explicit AccurateStep(dxWorld* world, dxSpace* space = nullptr, AccurateStepOptions options = {});
  ~AccurateStep();
  AccurateStep(AccurateStep&&) noexcept;
  AccurateStep& operator=(AccurateStep&&) noexcept;

  /// Advances the world by h > 0 seconds. Forces and torques added to the bodies act throughout the step and are then
  /// cleared, as dWorldStep does. Joint feedback structures get the forces at the end of the step.
  void operator()(double h);

  /// Impacts of the last step, in order.
  const std::vector<Touch>& touches() const;
  /// Steps so far in which contacts crowded (impacts of more than 48 bodies and contacts in a step, but for one after
  /// ten steps without any, or more friction to solve than a counted amount of work, and until nothing has bounced for
  /// ten steps): the rest of such a step is done by the time-stepping scheme of Moreau and Jean, first order, with
  /// joints kept, in which impacts are not located and not told.
  std::size_t crowded_steps() const;
  /// How many it moves, and how many it keeps.
  std::size_t bodies() const;
  std::size_t joints() const;

 private:
  class World;
  std::unique_ptr<World> world_;
};

}  // namespace odeval
