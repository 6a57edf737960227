#include "reference/tree/simbody_tree.hpp"

#include <Simbody.h>

#include <cmath>
#include <optional>
#include <utility>
#include <variant>

namespace odeval::reference {
namespace {

SimTK::Vec3 simbody(const Vec3& v) { return {v[0], v[1], v[2]}; }
Vec3 ours(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

Rotation ours(const SimTK::Rotation& r) {
  const SimTK::Vec3 x = r.getAxisUnitVec(SimTK::XAxis);
  const SimTK::Vec3 y = r.getAxisUnitVec(SimTK::YAxis);
  const SimTK::Vec3 z = r.getAxisUnitVec(SimTK::ZAxis);
  return {x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]};
}

SimTK::Rotation simbody(const Rotation& r) {
  return {SimTK::Mat33(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]), true};  // true: as it is
}

/// Axes x, y, z by columns, in the world.
SimTK::Rotation of_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  return simbody(Rotation{x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]});
}

/// Two unit directions at right angles to a unit direction and to each other: a, b, then it, right-handed.
std::array<Vec3, 2> across(const Vec3& axis) {
  const Vec3 far = std::fabs(axis[0]) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 a = unit(cross(far, axis));
  return {a, cross(axis, a)};
}

/// Where a body stands at t = 0.
SimTK::Transform place_of(const Body& body) {
  return {simbody(rotation_of(rotation_vector(body.attitude))), simbody(body.position_m)};
}

SimTK::Body::Rigid rigid(const Body& body) {
  const Vec3 moments = body.uniform_moments_kgm2();
  const std::array<double, 9> i =
      body.inertia_kgm2.value_or(std::array{moments[0], 0.0, 0.0, 0.0, moments[1], 0.0, 0.0, 0.0, moments[2]});
  return SimTK::Body::Rigid({body.mass_kg, SimTK::Vec3(0), SimTK::Inertia(i[0], i[4], i[8], i[1], i[2], i[5])});
}

/// A body on its joint, and the joint's frame in the world at t = 0: both bodies' halves of it coincide there.
struct Hanging {
  SimTK::MobilizedBody& parent;
  SimTK::Transform parent_place;
  const SimTK::Body::Rigid& body;
  SimTK::Transform place;
  bool body_is_first;  // of the joint

  template <class Mobilizer>
  SimTK::MobilizedBody on(const SimTK::Rotation& axes, const Vec3& anchor) const {
    const SimTK::Transform frame(axes, simbody(anchor));
    return Mobilizer(parent, ~parent_place * frame, body, ~place * frame);
  }

  SimTK::MobilizedBody operator()(const BallJoint& ball) const {
    return on<SimTK::MobilizedBody::Ball>(SimTK::Rotation(), ball.anchor_m);
  }
  SimTK::MobilizedBody operator()(const HingeJoint& hinge) const {  // turns about z
    const auto [x, y] = across(hinge.axis);
    return on<SimTK::MobilizedBody::Pin>(of_axes(x, y, hinge.axis), hinge.anchor_m);
  }
  SimTK::MobilizedBody operator()(const SliderJoint& slider) const {  // goes along x
    const auto [y, z] = across(slider.axis);
    return on<SimTK::MobilizedBody::Slider>(of_axes(slider.axis, y, z), slider.anchor_m);
  }
  SimTK::MobilizedBody operator()(const UniversalJoint& joint) const {  // turns about the parent's x and its own y
    const Vec3& x = body_is_first ? joint.axis2 : joint.axis1;
    const Vec3& y = body_is_first ? joint.axis1 : joint.axis2;
    return on<SimTK::MobilizedBody::Universal>(of_axes(x, y, cross(x, y)), joint.anchor_m);
  }
  SimTK::MobilizedBody operator()(const FixedJoint& joint) const {
    return on<SimTK::MobilizedBody::Weld>(SimTK::Rotation(), joint.anchor_m);
  }
};

class Tree final : public SimbodyTree {
 public:
  Tree(const Mechanism& mechanism, const std::vector<Branch>& tree, double gravity);

  std::string version() const override;
  const std::vector<double>& start() const override { return start_; }
  std::size_t place_of_coordinate(std::size_t body) const override;
  std::size_t place_of_speed(std::size_t body) const override;
  std::size_t first_speed() const override;
  void push(std::size_t body, double force) override;
  Vec3 direction(const double* y, std::size_t body, const Vec3& axis_at_start) override;
  const std::vector<double>& kick(const double* y, std::size_t body) override;
  Impulse impulse(const double* y, std::size_t body, std::optional<std::size_t> other, const Vec3& point,
                  const Vec3& direction) override;
  void slope(const double* y, double* dydt) override;
  const std::vector<Placed>& bodies(const double* y) override;
  const std::vector<Placed>& pushed(double dt) override;
  const std::vector<Vec3>& forces(const double* y) override;
  JointForces joint_forces(const double* y) override;

 private:
  struct System;
  std::unique_ptr<System> system_;
  std::vector<double> start_;
  std::vector<Placed> bodies_;
  std::vector<Vec3> forces_;
  std::vector<double> kick_;
};

struct Tree::System {
  Mechanism mechanism;
  std::vector<Branch> tree;
  double gravity;
  SimTK::MultibodySystem all;
  SimTK::SimbodyMatterSubsystem matter{all};
  SimTK::GeneralForceSubsystem loads{all};
  std::optional<SimTK::Force::DiscreteForces> pushes;  // where anything pushes
  std::vector<SimTK::MobilizedBody> bodies;            // by their numbers in the mechanism
  SimTK::State state;
  SimTK::Vector pushed;  // the same forces, by speeds
  SimTK::Vector_<SimTK::SpatialVec> reactions;

  System(Mechanism of, std::vector<Branch> order, double pull)
      : mechanism(std::move(of)), tree(std::move(order)), gravity(pull), bodies(mechanism.bodies.size()) {
    if (gravity != 0) SimTK::Force::Gravity(loads, matter, SimTK::Vec3(0, 0, -gravity));
    for (const Branch& branch : tree) add(branch);
    for (const Joint& joint : mechanism.joints) {
      if (joint.driven() && !pushes) pushes.emplace(loads, matter);
    }
    all.realizeTopology();
    state = all.getDefaultState();
    for (const Branch& branch : tree) {
      if (!branch.joint) bodies[branch.body].setQToFitTransform(state, place_of(mechanism.bodies[branch.body]));
    }
    all.realize(state, SimTK::Stage::Position);
    for (const Branch& branch : tree) set_speed(branch);
    pushed = SimTK::Vector(matter.getNumMobilities(), 0.0);
  }

  void realize(const double* y, SimTK::Stage stage) {
    SimTK::Vector& numbers = state.updY();
    for (int i = 0; i < numbers.size(); ++i) numbers[i] = y[i];
    all.realize(state, stage);
  }

 private:
  SimTK::Transform place_of_parent(const Branch& branch) const {
    return branch.parent ? place_of(mechanism.bodies[*branch.parent]) : SimTK::Transform();
  }

  void add(const Branch& branch) {
    const Body& what = mechanism.bodies[branch.body];
    const SimTK::Body::Rigid body = rigid(what);
    if (!branch.joint) {
      bodies[branch.body] = SimTK::MobilizedBody::Free(matter.updGround(), body);
      return;
    }
    const Joint& joint = mechanism.joints[*branch.joint];
    SimTK::MobilizedBody ground = matter.updGround();
    SimTK::MobilizedBody& parent = branch.parent ? bodies[*branch.parent] : ground;
    bodies[branch.body] = std::visit(
        Hanging{parent, place_of_parent(branch), body, place_of(what), joint.first == branch.body}, joint.kind);
  }

  /// What the joint leaves of the body's velocity against that of its parent.
  void set_speed(const Branch& branch) {
    const Body& what = mechanism.bodies[branch.body];
    const Body world{};
    const Body& parent = branch.parent ? mechanism.bodies[*branch.parent] : world;
    const Vec3 anchor = branch.joint ? anchor_m(mechanism.joints[*branch.joint].kind) : what.position_m;
    const auto velocity = [&](const Body& of) {
      return of.velocity_m_s + cross(of.spin_rad_s, anchor - of.position_m);
    };
    const SimTK::SpatialVec relative(simbody(what.spin_rad_s - parent.spin_rad_s),
                                     simbody(velocity(what) - velocity(parent)));
    const SimTK::MobilizedBody& body = bodies[branch.body];
    const SimTK::Rotation frame = place_of_parent(branch).R() * body.getInboardFrame(state).R();
    body.setUToFitVelocity(state, ~frame * relative);
  }
};

std::vector<double> numbers(const SimTK::Vector& vector) {
  std::vector<double> all;
  for (int i = 0; i < vector.size(); ++i) all.push_back(vector[i]);
  return all;
}

Tree::Tree(const Mechanism& mechanism, const std::vector<Branch>& tree, double gravity)
    : system_(std::make_unique<System>(mechanism, tree, gravity)),
      start_(numbers(system_->state.getY())),
      bodies_(mechanism.bodies.size()),
      forces_(mechanism.bodies.size()) {}

std::string Tree::version() const {
  int major = 0;
  int minor = 0;
  int build = 0;
  SimTK_version_simbody(&major, &minor, &build);
  return std::to_string(major) + "." + std::to_string(minor);
}

std::size_t Tree::place_of_coordinate(std::size_t body) const {
  return static_cast<std::size_t>(int(system_->bodies[body].getFirstQIndex(system_->state)));
}

std::size_t Tree::first_speed() const { return static_cast<std::size_t>(system_->state.getNQ()); }

std::size_t Tree::place_of_speed(std::size_t body) const {
  return first_speed() + static_cast<std::size_t>(int(system_->bodies[body].getFirstUIndex(system_->state)));
}

// Fixed in the body, which does not turn against what it slides on.
Vec3 Tree::direction(const double* y, std::size_t body, const Vec3& axis_at_start) {
  system_->realize(y, SimTK::Stage::Position);
  const SimTK::Rotation start = place_of(system_->mechanism.bodies[body]).R();
  return ours(system_->bodies[body].getBodyRotation(system_->state) * (~start * simbody(axis_at_start)));
}

void Tree::push(std::size_t body, double force) {
  system_->pushes->setOneMobilityForce(system_->state, system_->bodies[body], SimTK::MobilizerUIndex(0), force);
  system_->pushed[int(system_->bodies[body].getFirstUIndex(system_->state))] = force;
}

const std::vector<double>& Tree::kick(const double* y, std::size_t body) {
  system_->realize(y, SimTK::Stage::Position);
  SimTK::Vector impulse(system_->matter.getNumMobilities(), 0.0);
  impulse[int(system_->bodies[body].getFirstUIndex(system_->state))] = 1;
  SimTK::Vector gained;
  system_->matter.multiplyByMInv(system_->state, impulse, gained);
  kick_ = numbers(gained);
  return kick_;
}

SimbodyTree::Impulse Tree::impulse(const double* y, std::size_t body, std::optional<std::size_t> other,
                                   const Vec3& point, const Vec3& direction) {
  System& system = *system_;
  system.realize(y, SimTK::Stage::Position);
  SimTK::Vector_<SimTK::SpatialVec> loads(system.matter.getNumBodies(), SimTK::SpatialVec(SimTK::Vec3(0)));
  const auto load = [&](std::size_t number, const SimTK::Vec3& push) {
    const SimTK::MobilizedBody& on = system.bodies[number];
    const SimTK::Vec3 arm = simbody(point) - on.getBodyOriginLocation(system.state);
    loads[on.getMobilizedBodyIndex()] = SimTK::SpatialVec(arm % push, push);
  };
  load(body, simbody(direction));
  if (other) load(*other, -simbody(direction));
  SimTK::Vector along, gained;
  system.matter.multiplyBySystemJacobianTranspose(system.state, loads, along);
  system.matter.multiplyByMInv(system.state, along, gained);
  return {numbers(along), numbers(gained)};
}

void Tree::slope(const double* y, double* dydt) {
  system_->realize(y, SimTK::Stage::Acceleration);
  const SimTK::Vector& slopes = system_->state.getYDot();
  for (int i = 0; i < slopes.size(); ++i) dydt[i] = slopes[i];
}

const std::vector<Placed>& Tree::bodies(const double* y) {
  system_->realize(y, SimTK::Stage::Velocity);
  const SimTK::State& state = system_->state;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const SimTK::MobilizedBody& body = system_->bodies[i];
    bodies_[i] = {ours(body.getBodyOriginLocation(state)), ours(body.getBodyRotation(state)),
                  ours(body.getBodyOriginVelocity(state)), ours(body.getBodyAngularVelocity(state)),
                  body.getNumQ(state) > 0 ? body.getOneQ(state, 0) : 0};
  }
  return bodies_;
}

const std::vector<Placed>& Tree::pushed(double dt) {
  System& system = *system_;
  system.realize(start_.data(), SimTK::Stage::Velocity);
  SimTK::Vector_<SimTK::SpatialVec> loads(system.matter.getNumBodies(), SimTK::SpatialVec(SimTK::Vec3(0)));
  for (const SimTK::MobilizedBody& body : system.bodies) {
    const SimTK::Vec3& spin = body.getBodyAngularVelocity(system.state);
    const SimTK::Inertia inertia =
        body.getBodyMassProperties(system.state).getInertia().reexpress(~body.getBodyRotation(system.state));
    const double weight = body.getBodyMass(system.state) * system.gravity;
    loads[body.getMobilizedBodyIndex()] = SimTK::SpatialVec(-spin % (inertia * spin), SimTK::Vec3(0, 0, -weight));
  }
  system.state.updU() = 0;
  system.all.realize(system.state, SimTK::Stage::Dynamics);
  SimTK::Vector gained;
  SimTK::Vector_<SimTK::SpatialVec> unused;
  system.matter.calcAccelerationIgnoringConstraints(system.state, system.pushed, loads, gained, unused);
  std::vector<double> y = start_;
  const std::size_t coordinates = y.size() - static_cast<std::size_t>(gained.size());
  for (int i = 0; i < gained.size(); ++i) y[coordinates + static_cast<std::size_t>(i)] += dt * gained[i];
  return bodies(y.data());
}

const std::vector<Vec3>& Tree::forces(const double* y) {
  system_->realize(y, SimTK::Stage::Acceleration);
  system_->matter.calcMobilizerReactionForces(system_->state, system_->reactions);
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    forces_[i] = ours(system_->reactions[system_->bodies[i].getMobilizedBodyIndex()][1]);
  }
  return forces_;
}

SimbodyTree::JointForces Tree::joint_forces(const double* y) {
  System& system = *system_;
  system.realize(y, SimTK::Stage::Velocity);
  SimTK::Vector_<SimTK::SpatialVec> weights(system.matter.getNumBodies(), SimTK::SpatialVec(SimTK::Vec3(0)));
  for (const SimTK::MobilizedBody& body : system.bodies) {
    weights[body.getMobilizedBodyIndex()][1] = SimTK::Vec3(0, 0, -body.getBodyMass(system.state) * system.gravity);
  }
  SimTK::Vector bias;
  system.matter.calcResidualForceIgnoringConstraints(system.state, SimTK::Vector(), weights, SimTK::Vector(), bias);
  SimTK::Matrix mass;
  system.matter.calcM(system.state, mass);
  JointForces forces{{}, numbers(bias)};
  for (int i = 0; i < mass.nrow(); ++i) {
    for (int j = 0; j < mass.ncol(); ++j) forces.mass.push_back(mass(i, j));
  }
  return forces;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) SimbodyTree* odeval_make_simbody_tree(const Mechanism* mechanism,
                                                                                        const std::vector<Branch>* tree,
                                                                                        double gravity) {
  return new Tree(*mechanism, *tree, gravity);
}

}  // namespace odeval::reference
