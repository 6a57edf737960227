// DART alone.
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/simulation/World.hpp>

#include <numbers>
#include <string>

#include "tests/benchmark/bare_engine.h"

namespace {

namespace dd = dart::dynamics;

dart::simulation::WorldPtr world;
dd::BodyNode* last;

// A link's own axes are the world's when it is level; it lies along y.
dd::BodyNode* hang(const dd::SkeletonPtr& skeleton, dd::BodyNode* parent, const Eigen::Vector3d& at, double angle) {
  const std::string name = parent == nullptr ? "first" : "last";
  dd::RevoluteJoint::Properties joint;
  joint.mName = "hinge of " + name;
  joint.mAxis = Eigen::Vector3d::UnitX();
  joint.mT_ParentBodyToJoint.translation() = at;
  joint.mT_ChildBodyToJoint.translation() = Eigen::Vector3d(0, -0.5, 0);
  dd::BodyNode::Properties body;
  body.mName = name;
  body.mInertia = dd::Inertia(1, 0, 0, 0, 1.01 / 12, 0.02 / 12, 1.01 / 12, 0, 0, 0);
  const auto [made, node] = skeleton->createJointAndBodyNodePair<dd::RevoluteJoint>(parent, joint, body);
  made->setPosition(0, angle);
  return node;
}

}  // namespace

void bare_create(const char*) {
  world = dart::simulation::World::create();
  const dd::SkeletonPtr skeleton = dd::Skeleton::create();
  dd::BodyNode* const first = hang(skeleton, nullptr, {0, 0, 2.1}, std::numbers::pi / 4);
  last = hang(skeleton, first, {0, 0.5, 0}, -std::numbers::pi / 4);
  world->setGravity({0, 0, -9.81});
  world->setTimeStep(1e-3);
  world->addSkeleton(skeleton);
}

void bare_run(long steps) {
  for (long k = 0; k < steps; ++k) world->step(true);
}

double bare_height() { return last->getWorldTransform().translation().z(); }

void bare_destroy() { world.reset(); }
