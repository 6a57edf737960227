#pragma once
// An ODE world with all its settings, and the contacts of its present pose.
#include <ode/ode.h>

#include <memory>
#include <vector>

#include "odeval/scenario.hpp"

namespace odeval::engine_ode {

constexpr dReal real(double value) { return static_cast<dReal>(value); }

/// Pointers into ODE's body that stay valid as long as the body, read without a call.
struct BodyView {
  const dReal* position;
  const dReal* rotation;  // 3 x 4, by rows
  const dReal* velocity;
  const dReal* spin;
  const dReal* joint_force;  // of the body's joint on the body; null: it has none
};

/// What a contact is like.
struct Surface {
  dSurfaceParameters parameters{};
  bool shared = false;         // mu is a force that the contacts of two geoms have together
  bool along_sliding = false;  // friction acts along the way a contact slides, and across
};

/// Owns a world with its bodies, joints and space; what they are, its builders say (pendulum_scene.hpp,
/// body_scene.hpp). Pinned in memory: ODE keeps pointers to it.
class Scene {
 public:
  /// A world without bodies, as the scenario's settings ask for it.
  explicit Scene(const Scenario& scenario);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  dWorldID world() const { return world_; }
  dSpaceID space() const { return space_; }
  const std::vector<BodyView>& bodies() const { return bodies_; }

  /// A body with every setting of its own as in all scenes, and with its geom.
  dBodyID add_body(const dMass& mass, dGeomID geom);
  /// Shows the body to those who record; `joint` is the one whose force they see, null: none.
  void show(dBodyID body, dJointID joint);
  /// How all that touches does so.
  void set_surface(const Surface& surface) { surface_ = surface; }

  /// Finds the contacts of the current pose and makes a joint of each; they act in the next step.
  void collide();
  /// Removes the contact joints again.
  void clear_contacts() { dJointGroupEmpty(contact_group_); }
  int contacts() const { return contacts_; }
  double depth() const { return depth_; }  // m, of the deepest contact

  /// After a Fault: forget the world without touching it again.
  void abandon();

 private:
  Scene() = default;  // so that the destructor runs when ODE refuses a scenario half-way
  static void near_callback(void* scene, dGeomID first, dGeomID second);
  void set_world(const Scenario& scenario);

  dThreadingImplementationID threading_ = nullptr;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contact_group_ = nullptr;
  std::vector<BodyView> bodies_;
  std::vector<std::unique_ptr<dJointFeedback>> feedback_;  // ODE keeps pointers to them
  bool gyroscopic_ = true;
  Surface surface_;
  int contacts_ = 0;
  double depth_ = 0;
};

}  // namespace odeval::engine_ode
