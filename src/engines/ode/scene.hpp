#pragma once
// An ODE world with all its settings, and the contacts of its present pose.
#include <ode/ode.h>

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engines/ode/build_mechanism.hpp"
#include "engines/ode/joint_loads.hpp"
#include "odeval/scenario.hpp"

namespace odeval::engine_ode {

/// Pointers into ODE's body that stay valid as long as the body, read without a call.
struct BodyView {
  const dReal* position;
  const dReal* rotation;  // 3 x 4, by rows
  const dReal* velocity;
  const dReal* spin;
};

/// What a contact is like.
struct Surface {
  dSurfaceParameters parameters{};
  bool shared = false;         // mu is a force that the contacts of two geoms have together
  bool along_sliding = false;  // friction acts along the way a contact slides, and across
};

/// A contact of the last step, and what it gave.
struct Touch {
  dBodyID first;
  dBodyID second;  // either may be null: the world
  dJointFeedback feedback{};
};

/// Owns a world with a mechanism's bodies, joints and obstacles. Pinned in memory: ODE keeps pointers to it.
class Scene {
 public:
  /// As the scenario's settings ask for it.
  explicit Scene(const Scenario& scenario);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  dWorldID world() const { return world_; }
  dSpaceID space() const { return space_; }
  const std::vector<BodyView>& bodies() const { return bodies_; }

  /// Of each joint on the body that it carries (Joint::carried), N, as of the last step.
  const std::vector<const dReal*>& joint_forces() const { return joint_forces_; }

  /// Of a joint of the mechanism.
  dJointID joint(std::size_t number) const { return joints_[number]; }
  const dJointFeedback& feedback(std::size_t number) const { return *feedback_[number]; }

  /// What acts on joints; empty where nothing does.
  JointLoads& loads() { return loads_; }

  /// How two geoms touch; null: they pass through each other.
  const Surface* surface_between(dGeomID first, dGeomID second) const;

  /// Finds the contacts of the current pose and makes a joint of each; they act in the next step.
  void collide();
  /// Removes the contact joints again.
  void clear_contacts() { dJointGroupEmpty(contact_group_); }
  int contacts() const { return contacts_; }
  double depth() const { return depth_; }  // m, of the deepest contact

  /// From now on contacts tell what they give.
  void keep_touches() { keeps_touches_ = true; }
  /// Those that were found last.
  const std::deque<Touch>& touches() const { return touches_; }

  /// After a Fault: forget the world without touching it again.
  void abandon();

 private:
  Scene() = default;  // so that the destructor runs when ODE refuses a scenario half-way
  static void near_callback(void* scene, dGeomID first, dGeomID second);
  void set_world(const Scenario& scenario);
  void add_mechanism(const Scenario& scenario);
  void add_joint(const Joint& joint, dJointID made);
  void number(dGeomID geom, std::string_view name);
  void set_surfaces(const Scenario& scenario);

  dThreadingImplementationID threading_ = nullptr;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contact_group_ = nullptr;
  std::vector<BodyView> bodies_;
  std::vector<std::unique_ptr<dJointFeedback>> feedback_;  // ODE keeps pointers to them
  std::vector<const dReal*> joint_forces_;
  std::vector<dJointID> joints_;
  bool keeps_touches_ = false;
  std::deque<Touch> touches_;  // ODE keeps pointers to them
  JointLoads loads_;
  std::vector<std::string> names_;       // of geoms, by number
  std::vector<Surface> surfaces_;        // one a contact of the mechanism
  std::vector<const Surface*> of_pair_;  // by the numbers of two geoms; null: they pass through each other
  int contacts_ = 0;
  double depth_ = 0;
};

}  // namespace odeval::engine_ode
