#include "engines/dart/dart_world.hpp"

#include <dart/collision/CollisionDetector.hpp>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/CollisionResult.hpp>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/config.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/BoxedLcpSolver.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/constraint/ContactConstraint.hpp>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/DegreeOfFreedom.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/UniversalJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "odeval/error.hpp"

namespace odeval::engine_dart {
namespace {

namespace dd = dart::dynamics;
using engine_tree::Degree;
using engine_tree::Hanging;
using engine_tree::Place;
using engine_tree::Placed;

Eigen::Vector3d eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }
Vec3 ours(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

Eigen::Isometry3d transform(const Place& place) {
  const Rotation& r = place.rotation;
  Eigen::Isometry3d made = Eigen::Isometry3d::Identity();
  made.linear() << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  made.translation() = eigen(place.position_m);
  return made;
}

dd::BodyNode::Properties properties(const Body& body, std::size_t number) {
  const std::array<double, 9> i = engine_tree::inertia_of(body);
  dd::BodyNode::Properties made;
  made.mName = "b" + std::to_string(number);
  made.mInertia = dd::Inertia(body.mass_kg, 0, 0, 0, i[0], i[4], i[8], i[1], i[2], i[5]);
  made.mGravityMode = true;
  return made;
}

/// DART tells of two that have the same.
std::string name_of_joint(const dd::BodyNode::Properties& body) { return "joint of " + body.mName; }

/// A joint's frame stands at its anchor along the world's axes at t = 0, seen from either body.
template <class Joint, class Change>
dd::BodyNode* hang_on(dd::SkeletonPtr& skeleton, const Hanging& hanging, dd::BodyNode* parent,
                      const dd::BodyNode::Properties& body, const Change& change) {
  typename Joint::Properties joint;
  joint.mName = name_of_joint(body);
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.translation() = eigen(hanging.anchor_m);
  joint.mT_ParentBodyToJoint = transform(hanging.parent_place).inverse() * frame;
  joint.mT_ChildBodyToJoint = transform(hanging.place).inverse() * frame;
  joint.mIsPositionLimitEnforced = false;
  joint.mActuatorType = dd::Joint::FORCE;
  change(joint);
  return skeleton->createJointAndBodyNodePair<Joint>(parent, joint, body).second;
}

/// Half spaces are boxes: DART's own collisions, the exact ones for boxes and balls, know no plane.
constexpr double wide_m = 1000;

/// DART's own number, beyond which it drops contacts without a word.
constexpr std::size_t most_contacts = 1000;

/// Who meets whom, by the numbers of touching things.
class Pairs final : public dart::collision::CollisionFilter {
 public:
  Pairs(const engine_tree::Touching& touching, std::map<const dd::ShapeFrame*, std::size_t> numbers)
      : touching_(touching), numbers_(std::move(numbers)) {}
  bool ignoresCollision(const dart::collision::CollisionObject* first,
                        const dart::collision::CollisionObject* second) const override {
    return touching_.between(numbers_.at(first->getShapeFrame()), numbers_.at(second->getShapeFrame())) == nullptr;
  }

 private:
  const engine_tree::Touching& touching_;
  std::map<const dd::ShapeFrame*, std::size_t> numbers_;
};

struct ShapeOf {
  dd::ShapePtr operator()(const Box& box) const { return std::make_shared<dd::BoxShape>(eigen(box.sides_m)); }
  dd::ShapePtr operator()(const Sphere& ball) const { return std::make_shared<dd::SphereShape>(ball.diameter_m / 2); }
  template <class Bar>
  dd::ShapePtr operator()(const Bar&) const {
    throw UserError("DART is given boxes and balls to touch, not bars");
  }
};

/// A box, and where its centre stands.
struct Standing {
  Vec3 sides_m;
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
};
struct StandingOf {
  Standing operator()(const HalfSpace& plane) const {
    Standing box{{wide_m, wide_m, wide_m}};
    box.place.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), eigen(plane.normal)).matrix();
    box.place.translation() = (plane.offset_m - wide_m / 2) * eigen(plane.normal);
    return box;
  }
  Standing operator()(const FixedBox& fixed) const {
    Standing box{fixed.sides_m};
    box.place.translation() = eigen(fixed.centre_m);
    return box;
  }
};

/// DART multiplies the restitutions of two things, and takes the lower coefficient of friction.
dd::ShapeNode* touches_as(dd::BodyNode& node, const dd::ShapePtr& shape, const Contact& contact) {
  dd::ShapeNode* const made = node.createShapeNodeWith<dd::CollisionAspect, dd::DynamicsAspect>(shape);
  made->getDynamicsAspect()->setRestitutionCoeff(std::sqrt(contact.restitution));
  made->getDynamicsAspect()->setFrictionCoeff(contact.friction ? contact.friction->limit : 0);
  return made;
}

/// The one way to touch that all pairs have.
const Contact& only_contact(const Scenario& scenario) {
  const std::vector<Contact>& contacts = scenario.mechanism.contacts;
  const auto coefficient = [](const Contact& contact) { return contact.friction ? contact.friction->limit : 0; };
  const Contact& first = contacts.front();
  for (const Contact& other : contacts) {
    if (other.restitution == first.restitution && coefficient(other) == coefficient(first)) continue;
    throw UserError((scenario.file.empty() ? "" : scenario.file + ": ") + "contacts." +
                    std::to_string(&other - &first) +
                    ": restitution and friction must be those of contacts.0 for dart-step, since DART has them of "
                    "things, not of pairs");
  }
  return first;
}

}  // namespace

DartWorld::DartWorld(const Scenario& scenario, double step_s)
    : touching_(scenario.mechanism),
      world_(dart::simulation::World::create()),
      skeleton_(dd::Skeleton::create()),
      nodes_(scenario.mechanism.bodies.size()),
      bodies_(nodes_.size()) {
  const Mechanism& mechanism = scenario.mechanism;
  for (const Hanging& hanging : engine_tree::hang(mechanism)) {
    dd::BodyNode* const parent = hanging.parent ? nodes_[*hanging.parent] : nullptr;
    dd::BodyNode* const node = make(hanging, parent, properties(mechanism.bodies[hanging.body], hanging.body));
    nodes_[hanging.body] = node;
    dd::Joint* const joint = node->getParentJoint();
    if (!hanging.joint) {
      auto* const free = static_cast<dd::FreeJoint*>(joint);
      free->setTransform(transform(hanging.place));
      free->setLinearVelocity(eigen(mechanism.bodies[hanging.body].velocity_m_s));
      free->setAngularVelocity(eigen(hanging.spin_rad_s));
    }
    for (std::size_t k = 0; k < hanging.degrees.size(); ++k) joint->setVelocity(k, hanging.degrees[k].rate);
    for (std::size_t k = 0; hanging.ball && k < 3; ++k) joint->setVelocity(k, hanging.spin_rad_s[k]);
    if (hanging.degrees.size() == 1) loads_.add(mechanism.joints[*hanging.joint], joint);
    if (hanging.joint) drive(mechanism.joints[*hanging.joint], *joint);
  }
  skeleton_->setMobile(true);
  skeleton_->disableSelfCollisionCheck();
  world_->setGravity({0, 0, -scenario.gravity});
  world_->setTimeStep(step_s);
  world_->addSkeleton(skeleton_);
  if (!touching_.empty()) meet(scenario);
}

void DartWorld::meet(const Scenario& scenario) {
  namespace dc = dart::constraint;
  const Mechanism& mechanism = scenario.mechanism;
  const Contact& contact = only_contact(scenario);
  std::map<const dd::ShapeFrame*, std::size_t> numbers;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    numbers[touches_as(*nodes_[i], std::visit(ShapeOf{}, mechanism.bodies[i].shape), contact)] = i;
  }
  const dd::SkeletonPtr standing = dd::Skeleton::create("standing");
  for (std::size_t k = 0; k < mechanism.obstacles.size(); ++k) {
    const Standing box = std::visit(StandingOf{}, mechanism.obstacles[k].shape);
    dd::WeldJoint::Properties joint;
    joint.mName = "joint of obstacle " + std::to_string(k);
    joint.mT_ParentBodyToJoint = box.place;
    dd::BodyNode::Properties body;
    body.mName = "obstacle " + std::to_string(k);
    dd::BodyNode* const node = standing->createJointAndBodyNodePair<dd::WeldJoint>(nullptr, joint, body).second;
    numbers[touches_as(*node, ShapeOf{}(Box{box.sides_m}), contact)] = nodes_.size() + k;
  }
  standing->setMobile(false);
  skeleton_->enableSelfCollisionCheck();
  // DART's own numbers, of all worlds of the process.
  dc::ContactConstraint::setErrorAllowance(0);
  dc::ContactConstraint::setErrorReductionParameter(0.01);
  dc::ContactConstraint::setMaxErrorReductionVelocity(1e-3);
  dc::ContactConstraint::setConstraintForceMixing(1e-5);
  dc::ConstraintSolver& solver = *world_->getConstraintSolver();
  solver.setCollisionDetector(dart::collision::DARTCollisionDetector::create());
  solver.getCollisionOption().maxNumContacts = most_contacts;
  solver.getCollisionOption().collisionFilter = std::make_shared<Pairs>(touching_, std::move(numbers));
  world_->addSkeleton(standing);
}

engine_tree::Touched DartWorld::touched() {
  engine_tree::Touched touched;
  if (touching_.empty()) return touched;
  for (const auto& contact : world_->getLastCollisionResult().getContacts()) {
    ++touched.contacts;
    touched.depth = std::max(touched.depth, contact.penetrationDepth);
  }
  return touched;
}

std::vector<Vec3> DartWorld::contact_forces() {
  if (touching_.empty()) return {};
  std::vector<Vec3> forces(nodes_.size());
  for (const auto& contact : world_->getLastCollisionResult().getContacts()) {
    for (const auto& [object, sign] :
         {std::pair{contact.collisionObject1, 1.0}, std::pair{contact.collisionObject2, -1.0}}) {
      const auto* const shape = static_cast<const dd::ShapeNode*>(object->getShapeFrame());
      const auto body = std::ranges::find(nodes_, shape->getBodyNodePtr().get());
      if (body == nodes_.end()) continue;  // what stands
      Vec3& of_body = forces[static_cast<std::size_t>(body - nodes_.begin())];
      of_body = of_body + sign * ours(contact.force);
    }
  }
  return forces;
}

/// A force along a hinge or a slider, from outside: of a joint with a servo DART takes none.
void DartWorld::press(dd::Joint* joint, double force) {
  dd::BodyNode& child = *joint->getChildBodyNode();
  dd::BodyNode* const parent = joint->getParentBodyNode();
  const Eigen::Vector6d motion = force * joint->getRelativeJacobian().col(0);  // turning, then moving, in the child
  const Eigen::Vector3d torque = child.getWorldTransform().linear() * motion.head<3>();
  const Eigen::Vector3d along = child.getWorldTransform().linear() * motion.tail<3>();
  if (dynamic_cast<dd::RevoluteJoint*>(joint) != nullptr) {
    child.addExtTorque(torque, false);
    if (parent != nullptr) parent->addExtTorque(-torque, false);
  } else {
    const Eigen::Vector3d point = child.getWorldTransform().translation();
    child.addExtForce(along, point, false, false);
    if (parent != nullptr) parent->addExtForce(-along, point, false, false);
  }
}

/// A servo reaches its speed within a step, with no more than its force. A stop is where the joint stands still.
void DartWorld::drive(const Joint& joint, dd::Joint& made) {
  if (joint.motor) {
    made.setActuatorType(dd::Joint::SERVO);
    made.setForceLowerLimit(0, -joint.motor->most);
    made.setForceUpperLimit(0, joint.motor->most);
    motors_.emplace_back(&made, joint.motor->speed);
  }
  if (joint.stop) {
    made.setLimitEnforcement(true);
    made.setPositionLowerLimit(0, joint.stop->low);
    made.setPositionUpperLimit(0, joint.stop->high);
  }
}

dd::BodyNode* DartWorld::make(const Hanging& hanging, dd::BodyNode* parent, const dd::BodyNode::Properties& body) {
  const auto axis = [&](std::size_t k) { return eigen(hanging.degrees[k].axis); };
  const auto none = [](auto&) {};
  if (!hanging.joint) {
    dd::FreeJoint::Properties free;
    free.mName = name_of_joint(body);
    return skeleton_->createJointAndBodyNodePair<dd::FreeJoint>(nullptr, free, body).second;
  }
  if (hanging.ball) return hang_on<dd::BallJoint>(skeleton_, hanging, parent, body, none);
  if (hanging.degrees.empty()) return hang_on<dd::WeldJoint>(skeleton_, hanging, parent, body, none);
  if (hanging.degrees.size() == 2) {
    return hang_on<dd::UniversalJoint>(skeleton_, hanging, parent, body, [&](auto& joint) {
      joint.mAxis[0] = axis(0);
      joint.mAxis[1] = axis(1);
    });
  }
  const auto along = [&](auto& joint) { joint.mAxis = axis(0); };
  if (hanging.degrees[0].turns) return hang_on<dd::RevoluteJoint>(skeleton_, hanging, parent, body, along);
  return hang_on<dd::PrismaticJoint>(skeleton_, hanging, parent, body, along);
}

long DartWorld::step(double from, double) {
  if (!loads_.empty()) {
    const auto way = [](const dd::Joint* joint) { return joint->getPosition(0); };
    const auto rate = [](const dd::Joint* joint) { return joint->getVelocity(0); };
    loads_.sample(from, way, rate);
    loads_.apply(from, way, rate, &press);
  }
  for (const auto& [joint, speed] : motors_) joint->setCommand(0, speed);
  world_->step(true);  // and forgets forces and commands
  double sum = 0;
  for (const dd::DegreeOfFreedom* const degree : skeleton_->getDofs()) {
    sum += degree->getVelocity() * degree->getVelocity();
  }
  engine_tree::require_finite(sum);
  if (world_->getLastCollisionResult().getNumContacts() >= most_contacts) {
    throw engine_tree::Lost("DART has no room for all contacts");
  }
  return 1;
}

const std::vector<Placed>& DartWorld::bodies() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const dd::BodyNode& node = *nodes_[i];
    const Eigen::Isometry3d& place = node.getWorldTransform();
    bodies_[i].position_m = ours(place.translation());
    bodies_[i].velocity_m_s = ours(node.getCOMLinearVelocity());
    bodies_[i].spin_rad_s = ours(node.getAngularVelocity());
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        bodies_[i].rotation[3 * row + column] = place.linear()(static_cast<int>(row), static_cast<int>(column));
      }
    }
  }
  return bodies_;
}

Told DartWorld::told() const {
  const auto yes = [](bool is) { return std::string(is ? "on" : "off"); };
  auto& lcp = dynamic_cast<dart::constraint::BoxedLcpConstraintSolver&>(*world_->getConstraintSolver());
  return {
      {"version", std::string(DART_VERSION)},
      {"self_collision", yes(skeleton_->isEnabledSelfCollisionCheck())},
      {"mobile", yes(skeleton_->isMobile())},
      {"actuators", std::string(motors_.empty() ? "FORCE" : "FORCE and SERVO")},
      {"lcp_solver", lcp.getBoxedLcpSolver()->getType()},
      {"lcp_solver_where_that_fails", lcp.getSecondaryBoxedLcpSolver()->getType()},
      {"contact_erp", dart::constraint::ContactConstraint::getErrorReductionParameter()},
      {"contact_cfm", dart::constraint::ContactConstraint::getConstraintForceMixing()},
      {"contact_error_allowance", dart::constraint::ContactConstraint::getErrorAllowance()},
      {"contact_max_correcting_velocity", dart::constraint::ContactConstraint::getMaxErrorReductionVelocity()},
      {"max_contacts", static_cast<std::int64_t>(world_->getConstraintSolver()->getCollisionOption().maxNumContacts)},
      {"collision_detector", world_->getConstraintSolver()->getCollisionDetector()->getType()}};
}

}  // namespace odeval::engine_dart
