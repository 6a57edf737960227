#include "engines/bullet/meeting.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace odeval::engine_bullet {
namespace {

/// Numbers of objects count from 1, as Bullet has -1 and 0 for those that nobody numbered.
std::size_t number_of(const btCollisionObject& object) { return static_cast<std::size_t>(object.getUserIndex()) - 1; }

/// What Bullet calls when it finds a contact: of two numbers of a pair it would make its own, a product.
bool set_surface(btManifoldPoint& point, const btCollisionObjectWrapper* first, int, int,
                 const btCollisionObjectWrapper* second, int, int) {
  const btCollisionObject& a = *first->getCollisionObject();
  const btCollisionObject& b = *second->getCollisionObject();
  const auto& touching = *static_cast<const engine_tree::Touching*>(a.getUserPointer());
  const Contact* const contact = touching.between(number_of(a), number_of(b));
  if (contact == nullptr) return true;
  point.m_combinedRestitution = btScalar(contact->restitution);
  point.m_combinedFriction = btScalar(contact->friction ? contact->friction->limit : 0);
  point.m_combinedRollingFriction = 0;
  point.m_combinedSpinningFriction = 0;
  if (contact->softness) {
    point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP | BT_CONTACT_FLAG_HAS_CONTACT_CFM;
    point.m_contactERP = btScalar(contact->softness->erp);
    point.m_contactCFM = btScalar(contact->softness->cfm);
  }
  return true;
}

/// Of a point that is apart, which Bullet did not solve for, the impulse is one of an earlier step.
bool presses(const btManifoldPoint& point) { return point.getDistance() <= 0 && point.getAppliedImpulse() > 0; }

/// Bullet's ERP and CFM of a contact are ODE's: m/s that 1 N opens a row by, and it makes stiffness and damping into
/// them by the same equations (btSequentialImpulseConstraintSolver::setupContactConstraint).
Mechanism at_step(Mechanism mechanism, double step_s) {
  for (Contact& contact : mechanism.contacts) contact.softness = contact.softness_at(step_s);
  return mechanism;
}

btVector3 half(const Vec3& sides) { return bullet(0.5 * sides); }

}  // namespace

Meeting::Meeting(const Mechanism& mechanism, double step_s)
    : touching_(at_step(mechanism, step_s)), obstacles_(mechanism.obstacles), bodies_(mechanism.bodies.size()) {}

btCollisionShape* Meeting::keep(std::unique_ptr<btCollisionShape> shape) {
  return shapes_.emplace_back(std::move(shape)).get();
}

btCollisionShape* Meeting::shape_of(const Body& body, const Principal& principal) {
  if (empty()) return &nothing_;
  if (const auto* const ball = std::get_if<Sphere>(&body.shape)) {
    return keep(std::make_unique<btSphereShape>(btScalar(ball->diameter_m / 2)));
  }
  btCollisionShape* const box = keep(std::make_unique<btBoxShape>(half(sides_m(body.shape))));
  if (!body.inertia_kgm2) return box;
  auto turned = std::make_unique<btCompoundShape>();
  turned->addChildShape(btTransform(principal.axes.transpose()), box);
  return keep(std::move(turned));
}

void Meeting::introduce(btCollisionObject& object, std::size_t number) {
  // Bullet's own, without a limit, takes off part of the speed of what is about to touch, and with it the bounce.
  object.setContactProcessingThreshold(0);
  object.setUserPointer(&touching_);
  object.setUserIndex(static_cast<int>(number) + 1);
  object.setCollisionFlags(object.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
}

btCollisionObject& Meeting::add(btCollisionShape* shape, const btTransform& place, std::size_t number) {
  btCollisionObject& object = *standing_.emplace_back(std::make_unique<btCollisionObject>());
  object.setCollisionShape(shape);
  object.setWorldTransform(place);
  introduce(object, number);
  return object;
}

void Meeting::open(btCollisionWorld& world, btDefaultCollisionConfiguration& configuration) {
  if (empty()) return;
  gContactAddedCallback = &set_surface;  // of all worlds of the process
  // One point a step is Bullet's own, on which a box that lies flat tilts until it has found four.
  configuration.setPlaneConvexMultipointIterations(3, 3);
  world.getPairCache()->setOverlapFilterCallback(this);
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    const std::size_t number = bodies_ + k;
    btTransform place = btTransform::getIdentity();
    btCollisionShape* shape = nullptr;
    if (const auto* const plane = std::get_if<HalfSpace>(&obstacles_[k].shape)) {
      shape = keep(std::make_unique<btStaticPlaneShape>(bullet(plane->normal), btScalar(plane->offset_m)));
    } else {
      const auto& box = std::get<FixedBox>(obstacles_[k].shape);
      place.setOrigin(bullet(box.centre_m));
      shape = keep(std::make_unique<btBoxShape>(half(box.sides_m)));
    }
    world.addCollisionObject(&add(shape, place, number));
  }
}

void Meeting::close(btCollisionWorld& world) {
  for (const auto& object : standing_) world.removeCollisionObject(object.get());
}

engine_tree::Touched Meeting::touched(btCollisionDispatcher& dispatcher) const {
  engine_tree::Touched touched;
  if (empty()) return touched;
  for (int k = 0; k < dispatcher.getNumManifolds(); ++k) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(k);
    for (int i = 0; i < manifold.getNumContacts(); ++i) {
      const btManifoldPoint& point = manifold.getContactPoint(i);
      if (!presses(point)) continue;
      ++touched.contacts;
      touched.depth = std::max(touched.depth, -double(point.getDistance()));
    }
  }
  return touched;
}

// Its normal points from the second to the first.
std::vector<Vec3> Meeting::forces(btCollisionDispatcher& dispatcher, double step_s) const {
  if (empty()) return {};
  std::vector<Vec3> forces(bodies_);
  for (int k = 0; k < dispatcher.getNumManifolds(); ++k) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(k);
    btVector3 impulse(0, 0, 0);
    for (int i = 0; i < manifold.getNumContacts(); ++i) {
      const btManifoldPoint& point = manifold.getContactPoint(i);
      if (!presses(point)) continue;
      impulse += point.m_appliedImpulse * point.m_normalWorldOnB +
                 point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
                 point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
    }
    const Vec3 force = (1 / step_s) * ours(impulse);
    for (const auto& [object, sign] : {std::pair{manifold.getBody0(), 1.0}, std::pair{manifold.getBody1(), -1.0}}) {
      const std::size_t number = number_of(*object);
      if (number < bodies_) forces[number] = forces[number] + sign * force;
    }
  }
  return forces;
}

bool Meeting::needBroadphaseCollision(btBroadphaseProxy* first, btBroadphaseProxy* second) const {
  const auto number = [](const btBroadphaseProxy* proxy) {
    return number_of(*static_cast<const btCollisionObject*>(proxy->m_clientObject));
  };
  return touching_.between(number(first), number(second)) != nullptr;
}

}  // namespace odeval::engine_bullet
