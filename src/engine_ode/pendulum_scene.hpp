#pragma once
// A scenario's pendulum as an ODE world, built the way the report's listings C.2 and C.5 build it.
#include <ode/ode.h>

#include <vector>

#include "odeval/scenario.hpp"

namespace odeval::engine_ode {

/// Pointers into ODE's body that stay valid as long as the body, read without a call.
struct BodyView {
  const dReal* position;
  const dReal* rotation;  // 3 x 4, by rows
  const dReal* velocity;
  const dReal* spin;
  const dReal* joint_force;  // of the link's joint on the link (of several in one place: the first)
};

/// Owns a world with its bodies, joints and space. Pinned in memory: ODE keeps pointers to it.
class PendulumScene {
 public:
  /// `hinges` of one kind in the place of each: all but the first say what is said already.
  explicit PendulumScene(const Scenario& scenario, int hinges = 1);
  ~PendulumScene();
  PendulumScene(const PendulumScene&) = delete;
  PendulumScene& operator=(const PendulumScene&) = delete;

  dWorldID world() const { return world_; }
  dSpaceID space() const { return space_; }
  const std::vector<BodyView>& bodies() const { return bodies_; }

  /// Finds the contacts of the current pose and makes a bounce joint of each; they act in the next step.
  void collide();
  /// Removes the contact joints again.
  void clear_contacts() { dJointGroupEmpty(contact_group_); }
  int contacts() const { return contacts_; }
  double depth() const { return depth_; }  // m, of the deepest contact

  /// After a Fault: forget the world without touching it again.
  void abandon();

 private:
  PendulumScene() = default;  // so that the destructor runs when ODE refuses a scenario half-way
  static void near_callback(void* scene, dGeomID first, dGeomID second);
  void set_world(const Scenario& scenario);
  void add_links(const Scenario& scenario, int hinges);
  void add_wall(const Scenario& scenario);

  dThreadingImplementationID threading_ = nullptr;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contact_group_ = nullptr;
  std::vector<BodyView> bodies_;
  std::vector<dJointFeedback> feedback_;
  dSurfaceParameters surface_{};
  int contacts_ = 0;
  double depth_ = 0;
};

}  // namespace odeval::engine_ode
