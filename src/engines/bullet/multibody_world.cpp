#include "engines/bullet/multibody_world.hpp"

#include <limits>

#include "engines/bullet/world_settings.hpp"

namespace odeval::engine_bullet {

using engine_tree::Degree;
using engine_tree::Hanging;
using engine_tree::Placed;

namespace {

constexpr btScalar without_limit = std::numeric_limits<btScalar>::max();

/// Of a body that hangs: one a motion that its joint leaves, all but the last without mass.
int links_of(const Hanging& hanging) {
  return hanging.joint ? std::max(1, static_cast<int>(hanging.degrees.size())) : 0;
}

}  // namespace

MultibodyWorld::MultibodyWorld(const Scenario& scenario, double step_s, bool rk4)
    : meeting_(scenario.mechanism, step_s),
      step_s_(btScalar(step_s)),
      rk4_(rk4),
      bodies_(scenario.mechanism.bodies.size()) {
  meeting_.open(world_, configuration_);
  world_.setGravity(btVector3(0, 0, btScalar(-scenario.gravity)));
  set(world_.getSolverInfo(), scenario.bullet);
  plant(scenario.mechanism, engine_tree::hang(scenario.mechanism));
}

MultibodyWorld::~MultibodyWorld() {
  for (const auto& drive : drives_) world_.removeMultiBodyConstraint(drive.get());
  for (const auto& collider : colliders_) world_.removeCollisionObject(collider.get());
  for (const auto& tree : trees_) world_.removeMultiBody(tree.get());
  meeting_.close(world_);
}

void MultibodyWorld::plant(const Mechanism& mechanism, const std::vector<Hanging>& hangings) {
  std::vector<engine_tree::Place> places(bodies_.size());
  std::vector<std::size_t> root(bodies_.size());  // the free body at the root, or the number of bodies: the world
  std::vector<int> count(bodies_.size() + 1);
  for (const Hanging& hanging : hangings) {
    places[hanging.body] = hanging.place;
    const std::size_t of_parent = hanging.parent ? root[*hanging.parent] : bodies_.size();
    root[hanging.body] = hanging.joint ? of_parent : hanging.body;
    count[root[hanging.body]] += links_of(hanging);
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) principal_.emplace_back(mechanism.bodies[i], places[i]);

  links_.resize(bodies_.size());
  btMultiBody* const on_world = count.back() > 0 ? add(count.back(), nullptr, 0) : nullptr;
  std::vector<int> next(bodies_.size() + 1);
  for (const Hanging& hanging : hangings) {
    const std::size_t i = hanging.body;
    const Body& body = mechanism.bodies[i];
    if (!hanging.joint) {
      links_[i] = {add(count[i], &principal_[i], body.mass_kg), -1};
      continue;
    }
    links_[i] = {hanging.parent ? links_[*hanging.parent].tree : on_world, next[root[i]] + links_of(hanging) - 1};
    hang(hanging, body.mass_kg, next[root[i]]);
    next[root[i]] += links_of(hanging);
    if (hanging.degrees.size() == 1) loads_.add(mechanism.joints[*hanging.joint], links_[i]);
  }
  start(mechanism, hangings);
}

/// On a free body, or on the world.
btMultiBody* MultibodyWorld::add(int links, const Principal* base, double mass_kg) {
  const btVector3 moments = base != nullptr ? base->moments : btVector3(0, 0, 0);
  btMultiBody* const tree =
      trees_.emplace_back(std::make_unique<btMultiBody>(links, btScalar(mass_kg), moments, base == nullptr, false))
          .get();
  if (base != nullptr) {
    tree->setBaseWorldTransform(btTransform(base->start, base->centre));
  }
  tree->setHasSelfCollision(true);  // all that hangs on the world is one tree, and Meeting says who meets whom
  tree->setLinearDamping(0);
  tree->setAngularDamping(0);
  tree->setMaxAppliedImpulse(without_limit);
  tree->setMaxCoordinateVelocity(without_limit);
  tree->setUseGyroTerm(true);
  tree->useRK4Integration(rk4_);
  tree->useGlobalVelocities(false);
  return tree;
}

void MultibodyWorld::hang(const Hanging& hanging, double mass_kg, int first_link) {
  const Link& link = links_[hanging.body];
  btMultiBody& tree = *link.tree;
  const Principal& own = principal_[hanging.body];
  const Principal* const parent = hanging.parent ? &principal_[*hanging.parent] : nullptr;
  int carrier = hanging.parent ? links_[*hanging.parent].number : -1;
  btQuaternion turn;  // from the carrier's axes to the link's
  const btMatrix3x3 from_parent = parent != nullptr ? parent->start : btMatrix3x3::getIdentity();
  (own.start.transpose() * from_parent).getRotation(turn);
  btVector3 to_pivot = parent != nullptr ? parent->from_centre(hanging.anchor_m) : bullet(hanging.anchor_m);
  const btVector3 to_centre = -own.from_centre(hanging.anchor_m);
  const btScalar mass = btScalar(mass_kg);
  if (hanging.ball) {
    tree.setupSpherical(first_link, mass, own.moments, carrier, turn, to_pivot, to_centre);
  } else if (hanging.degrees.empty()) {
    tree.setupFixed(first_link, mass, own.moments, carrier, turn, to_pivot, to_centre);
  }
  for (std::size_t k = 0; k < hanging.degrees.size(); ++k) {
    const bool last = k + 1 == hanging.degrees.size();  // the body itself; the others stand at the anchor
    const btVector3 none(0, 0, 0);
    const int number = first_link + static_cast<int>(k);
    const auto set_up = hanging.degrees[k].turns ? &btMultiBody::setupRevolute : &btMultiBody::setupPrismatic;
    (tree.*set_up)(number, last ? mass : 0, last ? own.moments : none, carrier, turn,
                   own.along(hanging.degrees[k].axis), to_pivot, last ? to_centre : none, true);
    carrier = number;
    turn = btQuaternion::getIdentity();
    to_pivot = none;
  }
}

void MultibodyWorld::start(const Mechanism& mechanism, const std::vector<Hanging>& hangings) {
  for (const Hanging& hanging : hangings) {
    const bool driven =
        hanging.joint && (mechanism.joints[*hanging.joint].motor || mechanism.joints[*hanging.joint].stop);
    if (driven || !meeting_.empty()) collide(mechanism, hanging.body);
  }
  for (const auto& tree : trees_) {
    tree->finalizeMultiDof();
    world_.addMultiBody(tree.get());
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> origins;
    tree->forwardKinematics(turns, origins);
    tree->updateCollisionObjectWorldTransforms(turns, origins);
  }
  for (const auto& collider : colliders_) world_.addCollisionObject(collider.get(), 0, 0);
  for (const Hanging& hanging : hangings) {
    const Link& link = links_[hanging.body];
    if (hanging.joint) drive(mechanism.joints[*hanging.joint], link);
    if (!hanging.joint) {
      link.tree->setBaseVel(bullet(mechanism.bodies[hanging.body].velocity_m_s));
      link.tree->setBaseOmega(bullet(hanging.spin_rad_s));
    }
    const int first = link.number + 1 - links_of(hanging);
    for (std::size_t k = 0; k < hanging.degrees.size(); ++k) {
      link.tree->setJointVel(first + static_cast<int>(k), btScalar(hanging.degrees[k].rate));
    }
    if (hanging.ball) {
      const btVector3 spin = principal_[hanging.body].along(hanging.spin_rad_s);
      link.tree->setJointVelMultiDof(link.number, static_cast<const btScalar*>(spin));
    }
  }
}

void MultibodyWorld::drive(const Joint& joint, const Link& link) {
  const auto add = [&](std::unique_ptr<btMultiBodyConstraint> made) {
    made->finalizeMultiDof();
    world_.addMultiBodyConstraint(made.get());
    drives_.push_back(std::move(made));
  };
  if (const auto& motor = joint.motor) {
    const btScalar most = btScalar(motor->most) * step_s_;  // an impulse
    auto made = std::make_unique<btMultiBodyJointMotor>(link.tree, link.number, btScalar(motor->speed), most);
    made->setVelocityTarget(btScalar(motor->speed), 1);
    made->setPositionTarget(0, 0);
    made->setErp(0);
    made->setRhsClamp(without_limit);
    add(std::move(made));
  }
  if (const auto& stop = joint.stop) {
    add(std::make_unique<btMultiBodyJointLimitConstraint>(link.tree, link.number, btScalar(stop->low),
                                                          btScalar(stop->high)));
  }
}

/// Bullet solves for the joints of what may collide alone, so that a link with a motor or a stop has a shape as well.
void MultibodyWorld::collide(const Mechanism& mechanism, std::size_t body) {
  const Link& link = links_[body];
  btMultiBodyLinkCollider& collider =
      *colliders_.emplace_back(std::make_unique<btMultiBodyLinkCollider>(link.tree, link.number));
  collider.setCollisionShape(meeting_.shape_of(mechanism.bodies[body], principal_[body]));
  meeting_.introduce(collider, body);
  if (link.number < 0) {
    link.tree->setBaseCollider(&collider);
  } else {
    link.tree->getLink(link.number).m_collider = &collider;
  }
}

void MultibodyWorld::load(double t) {
  const auto way = [](const Link& link) { return double(link.tree->getJointPos(link.number)); };
  const auto rate = [](const Link& link) { return double(link.tree->getJointVel(link.number)); };
  loads_.sample(t, way, rate);
  loads_.apply(t, way, rate,
               [](const Link& link, double force) { link.tree->addJointTorque(link.number, btScalar(force)); });
}

long MultibodyWorld::step(double from, double) {
  if (!loads_.empty()) load(from);
  world_.stepSimulation(step_s_, 0);  // which forgets the forces
  double sum = 0;
  for (const auto& tree : trees_) {
    const btScalar* const speeds = tree->getVelocityVector();
    for (int k = 0; k < 6 + tree->getNumDofs(); ++k) sum += double(speeds[k]) * double(speeds[k]);
  }
  engine_tree::require_finite(sum);
  return 1;
}

const std::vector<Placed>& MultibodyWorld::bodies() {
  for (const auto& tree : trees_) {
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> origins;
    tree->forwardKinematics(turns, origins);
  }
  const btMultiBody* known = nullptr;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Link& link = links_[i];
    if (link.tree != known) {
      known = link.tree;
      spins_.resize(static_cast<std::size_t>(known->getNumLinks()) + 1);
      velocities_.resize(spins_.size());
      known->compTreeLinkVelocities(spins_.data(), velocities_.data());
    }
    const btTransform place =
        link.number < 0 ? known->getBaseWorldTransform() : known->getLink(link.number).m_cachedWorldTransform;
    const std::size_t place_of_speed = static_cast<std::size_t>(link.number + 1);
    bodies_[i] = {ours(place.getOrigin()), principal_[i].rotation(place.getBasis()),
                  ours(place.getBasis() * velocities_[place_of_speed]),
                  ours(place.getBasis() * spins_[place_of_speed])};
  }
  return bodies_;
}

Told MultibodyWorld::told() const {
  const btMultiBody& tree = *trees_.front();
  Told told = common(world_.getSolverInfo());
  const auto yes = [](bool is) { return std::string(is ? "on" : "off"); };
  told.insert(told.end(), {{"linear_damping", double(tree.getLinearDamping())},
                           {"angular_damping", double(tree.getAngularDamping())},
                           {"max_applied_impulse", double(tree.getMaxAppliedImpulse())},
                           {"max_coordinate_velocity", double(tree.getMaxCoordinateVelocity())},
                           {"gyro_term", yes(tree.getUseGyroTerm())},
                           {"rk4_integration", yes(tree.isUsingRK4Integration())},
                           {"global_velocities", yes(tree.isUsingGlobalVelocities())},
                           {"sleeping", yes(tree.getCanSleep())},
                           {"self_collision", yes(tree.hasSelfCollision())}});
  if (!colliders_.empty()) {
    told.push_back({"contact_processing_threshold", double(colliders_.front()->getContactProcessingThreshold())});
  }
  return told;
}

}  // namespace odeval::engine_bullet
