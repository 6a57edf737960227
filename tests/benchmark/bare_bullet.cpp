// Bullet alone.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstring>
#include <memory>

#include "tests/benchmark/bare_engine.h"

namespace {

const btVector3 moments(btScalar(1.01 / 12), btScalar(0.02 / 12), btScalar(1.01 / 12));
const btVector3 x(1, 0, 0);
const btVector3 to_centre(0, btScalar(0.5), 0);
const btVector3 hinge(0, 0, btScalar(2.1));
const btVector3 gravity(0, 0, btScalar(-9.81));
constexpr btScalar h = btScalar(1e-3);

struct Pendulum {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;

  virtual ~Pendulum() = default;
  virtual void step() = 0;
  virtual double height() = 0;
};

struct Bodies final : Pendulum {
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btEmptyShape shape;
  std::array<std::unique_ptr<btRigidBody>, 2> links;
  std::array<std::unique_ptr<btHingeConstraint>, 2> hinges;

  Bodies() {
    world.setGravity(gravity);
    btTransform end(btQuaternion::getIdentity(), hinge);
    for (std::size_t i = 0; i < 2; ++i) {
      btRigidBody::btRigidBodyConstructionInfo what(1, nullptr, &shape, moments);
      const btTransform place(btQuaternion(x, i == 0 ? SIMD_PI / 4 : 0), end.getOrigin());
      what.m_startWorldTransform = place * btTransform(btQuaternion::getIdentity(), to_centre);
      links[i] = std::make_unique<btRigidBody>(what);
      links[i]->setActivationState(DISABLE_DEACTIVATION);
      world.addRigidBody(links[i].get(), 0, 0);
      hinges[i] = i == 0 ? std::make_unique<btHingeConstraint>(*links[0], -to_centre, x)
                         : std::make_unique<btHingeConstraint>(*links[1], *links[0], -to_centre, to_centre, x, x);
      world.addConstraint(hinges[i].get(), true);
      end.setOrigin(links[i]->getWorldTransform() * to_centre);
    }
  }
  ~Bodies() override {
    for (const auto& constraint : hinges) world.removeConstraint(constraint.get());
    for (const auto& link : links) world.removeRigidBody(link.get());
  }
  void step() override { world.stepSimulation(h, 0); }
  double height() override { return links[1]->getWorldTransform().getOrigin().z(); }
};

struct Tree final : Pendulum {
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btMultiBody tree{2, 0, btVector3(0, 0, 0), true, false};

  explicit Tree(bool rk4) {
    world.setGravity(gravity);
    const btQuaternion level = btQuaternion::getIdentity();
    tree.setupRevolute(0, 1, moments, -1, level, x, hinge, to_centre, true);
    tree.setupRevolute(1, 1, moments, 0, level, x, to_centre, to_centre, true);
    tree.finalizeMultiDof();
    tree.setLinearDamping(0);
    tree.setAngularDamping(0);
    tree.setMaxCoordinateVelocity(SIMD_INFINITY);
    tree.useRK4Integration(rk4);
    tree.setJointPos(0, SIMD_PI / 4);
    tree.setJointPos(1, -SIMD_PI / 4);
    world.addMultiBody(&tree);
  }
  ~Tree() override { world.removeMultiBody(&tree); }

  void step() override { world.stepSimulation(h, 0); }
  double height() override { return tree.localPosToWorld(1, btVector3(0, 0, 0)).z(); }
};

std::unique_ptr<Pendulum> pendulum;

}  // namespace

void bare_create(const char* method) {
  if (std::strstr(method, "hinge") != nullptr) {
    pendulum = std::make_unique<Bodies>();
  } else {
    pendulum = std::make_unique<Tree>(std::strstr(method, "rk4") != nullptr);
  }
}

void bare_run(long steps) {
  for (long k = 0; k < steps; ++k) pendulum->step();
}

double bare_height() { return pendulum->height(); }

void bare_destroy() { pendulum.reset(); }
