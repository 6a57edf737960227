#pragma once
// A mechanism in Bullet's bodies: btRigidBody and constraints between them.
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "engines/bullet/bullet_numbers.hpp"
#include "engines/bullet/meeting.hpp"
#include "engines/tree/joint_loads.hpp"
#include "engines/tree/world.hpp"
#include "odeval/scenario.hpp"

namespace odeval::engine_bullet {

/// The first body of a hinge or a slider against the second, or the world.
struct HeldPair {
  btRigidBody* first;
  btRigidBody* second;  // the fixed body where it is the world
  bool turns;           // a hinge, else a slider
  btVector3 axis;       // in the first
  // Directions across the axis, and points that meet at t = 0, in each of them.
  btVector3 across_first;
  btVector3 across_second;
  btVector3 anchor_first;
  btVector3 anchor_second;
  double near = 0;  // the angle at the last look: told within half a turn

  double way();
  double rate() const;
  void push(double force) const;

 private:
  btVector3 axis_in_world() const { return first->getWorldTransform().getBasis() * axis; }
};

class HingeWorld final : public engine_tree::World {
 public:
  HingeWorld(const Scenario& scenario, double step_s);
  ~HingeWorld() override;
  HingeWorld(const HingeWorld&) = delete;
  HingeWorld& operator=(const HingeWorld&) = delete;

  long step(double from, double to) override;
  const std::vector<engine_tree::Placed>& bodies() override;
  engine_tree::Touched touched() override { return meeting_.touched(dispatcher_); }
  std::vector<Vec3> contact_forces() override { return meeting_.forces(dispatcher_, double(step_s_)); }
  std::vector<Vec3> closing_forces() override;
  Told told() const override;

 private:
  void add(const Body& body);
  void watch(const std::vector<std::size_t>& closing);
  void add(const Joint& joint);

  Meeting meeting_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btScalar step_s_;
  std::vector<Principal> principal_;                 // by the numbers of bodies
  std::vector<std::unique_ptr<btRigidBody>> rigid_;  // likewise
  std::vector<std::unique_ptr<btTypedConstraint>> constraints_;
  std::vector<std::unique_ptr<btJointFeedback>> closing_;  // of joints that close loops
  std::vector<std::unique_ptr<HeldPair>> pairs_;
  engine_tree::JointLoads<HeldPair*> loads_;
  std::vector<engine_tree::Placed> bodies_;
};

}  // namespace odeval::engine_bullet
