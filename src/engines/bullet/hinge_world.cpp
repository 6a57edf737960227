#include "engines/bullet/hinge_world.hpp"

#include <cmath>
#include <numbers>

#include "engines/bullet/world_settings.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_bullet {

using engine_tree::Placed;

namespace {

/// A joint's frame in the world at t = 0, seen from a body or the world.
btTransform in_body(const btRigidBody& body, const btTransform& frame) {
  return body.getWorldTransform().inverse() * frame;
}

/// A frame at an anchor with one of its axes (0, 1, 2) along a direction.
btTransform frame_along(const Vec3& anchor, const Vec3& direction, int axis) {
  btVector3 u, v;
  const btVector3 n = bullet(direction);
  btPlaneSpace1(n, u, v);  // right-handed with n as the last
  btMatrix3x3 columns;
  const btVector3 in_turn[] = {n, u, v};
  for (int k = 0; k < 3; ++k) {
    const btVector3& column = in_turn[(k - axis + 3) % 3];
    for (int row = 0; row < 3; ++row) columns[row][k] = column[row];
  }
  return btTransform(columns, bullet(anchor));
}

/// One maker a kind of joint, between bodies in the places that they have at t = 0.
struct MakeConstraint {
  btRigidBody& first;
  btRigidBody& second;
  btScalar erp;
  const std::optional<Motor>& motor;  // of a hinge or a slider
  const std::optional<Stop>& stop;    // likewise
  btScalar step_s;

  using Made = std::unique_ptr<btTypedConstraint>;

  Made operator()(const BallJoint& ball) const {
    const btTransform frame(btMatrix3x3::getIdentity(), bullet(ball.anchor_m));
    return std::make_unique<btPoint2PointConstraint>(first, second, in_body(first, frame).getOrigin(),
                                                     in_body(second, frame).getOrigin());
  }
  Made operator()(const HingeJoint& hinge) const {
    const btTransform frame = frame_along(hinge.anchor_m, hinge.axis, 2);
    auto made =
        std::make_unique<btHingeConstraint>(first, second, in_body(first, frame), in_body(second, frame), false);
    if (motor) made->enableAngularMotor(true, btScalar(motor->speed), btScalar(motor->most) * step_s);  // an impulse
    if (stop) {
      made->setLimit(btScalar(stop->low), btScalar(stop->high), 1, 1, 0);
      // Else, on the world, Bullet holds the centre of mass still as long as the hinge is beyond its stop.
      made->setUseFrameOffset(false);
    }
    return made;
  }
  // Not one of six motions, as the next two are: beside a body that turns, the two halves of that one's force do not
  // act along one line, and the motion has an error that no step takes away (0.08 m in half a second of two bodies).
  Made operator()(const SliderJoint& slider) const {
    const btTransform frame = frame_along(slider.anchor_m, slider.axis, 0);
    auto made =
        std::make_unique<btSliderConstraint>(first, second, in_body(first, frame), in_body(second, frame), true);
    made->setLowerLinLimit(stop ? btScalar(-stop->high) : 1);  // it counts the second body against the first;
    made->setUpperLinLimit(stop ? btScalar(-stop->low) : -1);  // low above high: free
    made->setSoftnessLimLin(1);
    made->setDampingLimLin(1);
    made->setLowerAngLimit(0);
    made->setUpperAngLimit(0);
    made->setSoftnessLimAng(1);
    made->setDampingLimAng(1);
    made->setRestitutionLimAng(0);
    made->setSoftnessOrthoAng(1);
    made->setDampingOrthoAng(1);
    made->setRestitutionOrthoAng(0);
    made->setSoftnessOrthoLin(1);
    made->setDampingOrthoLin(1);
    made->setRestitutionOrthoLin(0);
    if (motor) {
      made->setPoweredLinMotor(true);
      made->setTargetLinMotorVelocity(btScalar(-motor->speed));
      made->setMaxLinMotorForce(btScalar(motor->most));
    }
    return made;
  }
  // Its turns are one about an axis of the second body, x of its frame, and one about an axis of the first, z.
  Made operator()(const UniversalJoint& joint) const {
    const btVector3 x = bullet(joint.axis2);
    const btVector3 z = bullet(joint.axis1);
    const btVector3 y = z.cross(x);
    const btMatrix3x3 columns(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]);
    auto six = locked(btTransform(columns, bullet(joint.anchor_m)));
    six->setLimit(3, 1, -1);
    six->setLimit(5, 1, -1);
    return six;
  }
  Made operator()(const FixedJoint& joint) const {
    return locked(btTransform(btMatrix3x3::getIdentity(), bullet(joint.anchor_m)));
  }
  // Features of theirs refuse what follows before.
  Made operator()(const PistonJoint&) const { refuse(); }
  Made operator()(const SlidingHingeJoint&) const { refuse(); }
  Made operator()(const SlidingUniversalJoint&) const { refuse(); }
  Made operator()(const Hinge2Joint&) const { refuse(); }
  Made operator()(const PlaneJoint&) const { refuse(); }

 private:
  [[noreturn]] static void refuse() { throw MachineError("a joint of a kind that Bullet does not have"); }
  std::unique_ptr<btGeneric6DofSpring2Constraint> locked(const btTransform& frame) const {
    auto six = std::make_unique<btGeneric6DofSpring2Constraint>(first, second, in_body(first, frame),
                                                                in_body(second, frame), RO_XYZ);
    for (int k = 0; k < 6; ++k) {
      six->setLimit(k, 0, 0);
      six->setParam(BT_CONSTRAINT_STOP_ERP, erp, k);
      six->setParam(BT_CONSTRAINT_STOP_CFM, 0, k);
    }
    return six;
  }
};

/// The axis of a kind that has one along which loads act.
struct LoadedAxis {
  const Vec3* operator()(const HingeJoint& hinge) const { return &hinge.axis; }
  const Vec3* operator()(const SliderJoint& slider) const { return &slider.axis; }
  const Vec3* operator()(const BallJoint&) const { return nullptr; }
  const Vec3* operator()(const UniversalJoint&) const { return nullptr; }
  const Vec3* operator()(const FixedJoint&) const { return nullptr; }
  const Vec3* operator()(const PistonJoint&) const { return nullptr; }
  const Vec3* operator()(const SlidingHingeJoint&) const { return nullptr; }
  const Vec3* operator()(const SlidingUniversalJoint&) const { return nullptr; }
  const Vec3* operator()(const Hinge2Joint&) const { return nullptr; }
  const Vec3* operator()(const PlaneJoint&) const { return nullptr; }
};

}  // namespace

double HeldPair::way() {
  const btTransform& a = first->getWorldTransform();
  const btTransform& b = second->getWorldTransform();
  const btVector3 along = axis_in_world();
  if (!turns) return along.dot(a * anchor_first - b * anchor_second);
  constexpr double full_turn = 2 * std::numbers::pi;
  const btVector3 from = b.getBasis() * across_second;
  const btVector3 to = a.getBasis() * across_first;
  const double angle = std::atan2(double(along.dot(from.cross(to))), double(from.dot(to)));
  return near = angle + full_turn * std::round((near - angle) / full_turn);
}

double HeldPair::rate() const {
  const btVector3 along = axis_in_world();
  if (turns) return along.dot(first->getAngularVelocity() - second->getAngularVelocity());
  const btVector3 point = first->getWorldTransform() * anchor_first;
  const auto velocity = [&](const btRigidBody& body) {
    return body.getVelocityInLocalPoint(point - body.getCenterOfMassPosition());
  };
  return along.dot(velocity(*first) - velocity(*second));
}

void HeldPair::push(double force) const {
  const btVector3 load = btScalar(force) * axis_in_world();
  if (turns) {
    first->applyTorque(load);
    second->applyTorque(-load);
    return;
  }
  const btVector3 point = first->getWorldTransform() * anchor_first;
  first->applyForce(load, point - first->getCenterOfMassPosition());
  second->applyForce(-load, point - second->getCenterOfMassPosition());
}

HingeWorld::HingeWorld(const Scenario& scenario, double step_s)
    : meeting_(scenario.mechanism, step_s), step_s_(btScalar(step_s)), bodies_(scenario.mechanism.bodies.size()) {
  meeting_.open(world_, configuration_);
  world_.setGravity(btVector3(0, 0, btScalar(-scenario.gravity)));
  set(world_.getSolverInfo(), scenario.bullet);
  std::vector<engine_tree::Place> places(bodies_.size());
  std::vector<std::size_t> closing;
  for (const engine_tree::Hanging& hanging : engine_tree::hang(scenario.mechanism, &closing)) {
    places[hanging.body] = hanging.place;
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    principal_.emplace_back(scenario.mechanism.bodies[i], places[i]);
    add(scenario.mechanism.bodies[i]);
  }
  for (const Joint& joint : scenario.mechanism.joints) add(joint);
  watch(closing);
}

void HingeWorld::watch(const std::vector<std::size_t>& closing) {
  for (const std::size_t joint : closing) {
    closing_.push_back(std::make_unique<btJointFeedback>());
    constraints_[joint]->enableFeedback(true);
    constraints_[joint]->setJointFeedback(closing_.back().get());
  }
}

std::vector<Vec3> HingeWorld::closing_forces() {
  std::vector<Vec3> forces;
  for (const auto& feedback : closing_) forces.push_back(ours(feedback->m_appliedForceBodyA));
  return forces;
}

HingeWorld::~HingeWorld() {
  for (const auto& constraint : constraints_) world_.removeConstraint(constraint.get());
  for (const auto& body : rigid_) world_.removeRigidBody(body.get());
  meeting_.close(world_);
}

void HingeWorld::add(const Body& body) {
  const Principal& principal = principal_.back();
  btRigidBody::btRigidBodyConstructionInfo what(btScalar(body.mass_kg), nullptr, meeting_.shape_of(body, principal),
                                                principal.moments);
  what.m_startWorldTransform = btTransform(principal.start, principal.centre);
  what.m_linearDamping = 0;
  what.m_angularDamping = 0;
  what.m_additionalDamping = false;
  btRigidBody& made = *rigid_.emplace_back(std::make_unique<btRigidBody>(what));
  made.setLinearVelocity(bullet(body.velocity_m_s));
  made.setAngularVelocity(bullet(body.spin_rad_s));
  made.setActivationState(DISABLE_DEACTIVATION);
  made.setFlags(BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  meeting_.introduce(made, rigid_.size() - 1);
  world_.addRigidBody(&made, 0, 0);
}

void HingeWorld::add(const Joint& joint) {
  btRigidBody& first = *rigid_[joint.first];
  btRigidBody& second = joint.second ? *rigid_[*joint.second] : btTypedConstraint::getFixedBody();
  constraints_.push_back(std::visit(
      MakeConstraint{first, second, world_.getSolverInfo().m_erp, joint.motor, joint.stop, step_s_}, joint.kind));
  constraints_.back()->setOverrideNumSolverIterations(-1);
  constraints_.back()->setBreakingImpulseThreshold(SIMD_INFINITY);
  world_.addConstraint(constraints_.back().get(), true);
  const Vec3* const axis = std::visit(LoadedAxis{}, joint.kind);
  if (axis == nullptr || !joint.loaded()) return;
  const btTransform frame = frame_along(anchor_m(joint.kind), *axis, 2);
  const btTransform a = in_body(first, frame);
  const btTransform b = in_body(second, frame);
  pairs_.push_back(std::make_unique<HeldPair>(HeldPair{&first, &second, std::holds_alternative<HingeJoint>(joint.kind),
                                                       a.getBasis().getColumn(2), a.getBasis().getColumn(0),
                                                       b.getBasis().getColumn(0), a.getOrigin(), b.getOrigin()}));
  loads_.add(joint, pairs_.back().get());
}

long HingeWorld::step(double from, double) {
  if (!loads_.empty()) {
    const auto way = [](HeldPair* pair) { return pair->way(); };
    const auto rate = [](const HeldPair* pair) { return pair->rate(); };
    loads_.sample(from, way, rate);
    loads_.apply(from, way, rate, [](const HeldPair* pair, double force) { pair->push(force); });
  }
  world_.stepSimulation(step_s_, 0);  // which forgets the forces
  double sum = 0;
  for (const auto& body : rigid_)
    sum += double(body->getLinearVelocity().length2() + body->getAngularVelocity().length2());
  engine_tree::require_finite(sum);
  return 1;
}

const std::vector<Placed>& HingeWorld::bodies() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const btRigidBody& body = *rigid_[i];
    const btTransform& place = body.getWorldTransform();
    bodies_[i] = {ours(place.getOrigin()), principal_[i].rotation(place.getBasis()), ours(body.getLinearVelocity()),
                  ours(body.getAngularVelocity())};
  }
  return bodies_;
}

Told HingeWorld::told() const {
  const btRigidBody& body = *rigid_.front();
  Told told = common(const_cast<btDiscreteDynamicsWorld&>(world_).getSolverInfo());
  told.insert(told.end(), {{"linear_damping", double(body.getLinearDamping())},
                           {"angular_damping", double(body.getAngularDamping())},
                           {"gyroscopic", std::string(body.getFlags() == BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY
                                                          ? "implicit, in the body's frame"
                                                          : "otherwise")},
                           {"sleeping", std::string(body.getActivationState() == DISABLE_DEACTIVATION ? "off" : "on")},
                           {"contact_processing_threshold", double(body.getContactProcessingThreshold())}});
  return told;
}

}  // namespace odeval::engine_bullet
