#pragma once
// A mechanism in Bullet's joint coordinates: btMultiBody, Featherstone's algorithm.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <memory>
#include <optional>
#include <vector>

#include "engines/bullet/bullet_numbers.hpp"
#include "engines/bullet/meeting.hpp"
#include "engines/tree/joint_loads.hpp"
#include "engines/tree/world.hpp"
#include "odeval/scenario.hpp"

namespace odeval::engine_bullet {

class MultibodyWorld final : public engine_tree::World {
 public:
  MultibodyWorld(const Scenario& scenario, double step_s, bool rk4);
  ~MultibodyWorld() override;
  MultibodyWorld(const MultibodyWorld&) = delete;
  MultibodyWorld& operator=(const MultibodyWorld&) = delete;

  long step(double from, double to) override;
  const std::vector<engine_tree::Placed>& bodies() override;
  engine_tree::Touched touched() override { return meeting_.touched(dispatcher_); }
  std::vector<Vec3> contact_forces() override { return meeting_.forces(dispatcher_, double(step_s_)); }
  Told told() const override;

 private:
  /// What a body is in Bullet: a link of a tree, or its base (-1).
  struct Link {
    btMultiBody* tree = nullptr;
    int number = -1;
  };

  void plant(const Mechanism& mechanism, const std::vector<engine_tree::Hanging>& hangings);
  btMultiBody* add(int links, const Principal* base, double mass_kg);
  void hang(const engine_tree::Hanging& hanging, double mass_kg, int first_link);
  void drive(const Joint& joint, const Link& link);
  void collide(const Mechanism& mechanism, std::size_t body);
  void load(double t);
  void start(const Mechanism& mechanism, const std::vector<engine_tree::Hanging>& hangings);

  Meeting meeting_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btScalar step_s_;
  bool rk4_;
  std::vector<std::unique_ptr<btMultiBody>> trees_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> drives_;       // motors and stops
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;  // of links with those, or that touch
  std::vector<Principal> principal_;                                 // by the numbers of bodies, as all that follows
  std::vector<Link> links_;
  engine_tree::JointLoads<Link> loads_;
  std::vector<engine_tree::Placed> bodies_;
  std::vector<btVector3> spins_;  // of the links of one tree
  std::vector<btVector3> velocities_;
};

}  // namespace odeval::engine_bullet
