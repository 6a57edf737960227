#pragma once
// What touches in Bullet: shapes, who meets whom, and with how much bounce, friction and softness.
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "engines/bullet/bullet_numbers.hpp"
#include "engines/tree/touching.hpp"
#include "engines/tree/world.hpp"

namespace odeval::engine_bullet {

/// Of one world, which it outlives. Where nothing touches it does nothing, and every shape is an empty one.
class Meeting final : public btOverlapFilterCallback {
 public:
  Meeting(const Mechanism& mechanism, double step_s);
  Meeting(const Meeting&) = delete;
  Meeting& operator=(const Meeting&) = delete;

  bool empty() const { return touching_.empty(); }
  /// Of a body whose principal axes Bullet takes for its own.
  btCollisionShape* shape_of(const Body& body, const Principal& principal);
  /// A body's or a link's object, before it joins the world: what it is called by.
  void introduce(btCollisionObject& object, std::size_t number);
  /// Puts what stands still into the world, and this between it and its pairs.
  void open(btCollisionWorld& world, btDefaultCollisionConfiguration& configuration);
  /// Takes all that out again.
  void close(btCollisionWorld& world);
  /// In the last step: contacts that pressed, and the deepest.
  engine_tree::Touched touched(btCollisionDispatcher& dispatcher) const;
  /// What they gave each body, N, by its number; empty where nothing touches.
  std::vector<Vec3> forces(btCollisionDispatcher& dispatcher, double step_s) const;

  bool needBroadphaseCollision(btBroadphaseProxy* first, btBroadphaseProxy* second) const override;

 private:
  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape);
  btCollisionObject& add(btCollisionShape* shape, const btTransform& place, std::size_t number);

  engine_tree::Touching touching_;
  std::vector<Obstacle> obstacles_;
  std::size_t bodies_;
  btEmptyShape nothing_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> standing_;
};

}  // namespace odeval::engine_bullet
