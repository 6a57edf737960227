#include "reference/tree/simbody_tree.hpp"

#include <Simbody.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <optional>
#include <stdexcept>
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

/// One of so many equal parts of a body, or the whole.
SimTK::Body::Rigid rigid(const Body& body, double parts) {
  const Vec3 moments = body.uniform_moments_kgm2();
  const std::array<double, 9> i =
      body.inertia_kgm2.value_or(std::array{moments[0], 0.0, 0.0, 0.0, moments[1], 0.0, 0.0, 0.0, moments[2]});
  const SimTK::Inertia whole(i[0], i[4], i[8], i[1], i[2], i[5]);
  if (parts == 1) return SimTK::Body::Rigid({body.mass_kg, SimTK::Vec3(0), whole});
  return SimTK::Body::Rigid({body.mass_kg / parts, SimTK::Vec3(0), whole / parts});
}

/// Bodies that hang one on the other, and how the one before each is turned at t = 0.
struct Chain {
  std::vector<SimTK::MobilizedBody> bodies;
  std::vector<SimTK::Rotation> turned;
};

/// A body on its joint, and the joint's frame in the world at t = 0: both bodies' halves of it coincide there. A joint
/// that Simbody does not have is made of two, with a massless body between them.
struct Hanging {
  SimTK::MobilizedBody& parent;
  SimTK::Transform parent_place;
  const SimTK::Body::Rigid& body;
  SimTK::Transform place;
  bool body_is_first;  // of the joint
  SimTK::GeneralForceSubsystem& loads;

  template <class Mobilizer>
  static SimTK::MobilizedBody hang(SimTK::MobilizedBody& carrier, const SimTK::Transform& carrier_place,
                                   const SimTK::Body& carried, const SimTK::Transform& carried_place,
                                   const SimTK::Rotation& axes, const Vec3& anchor) {
    const SimTK::Transform frame(axes, simbody(anchor));
    return Mobilizer(carrier, ~carrier_place * frame, carried, ~carried_place * frame);
  }
  template <class Mobilizer>
  Chain on(const SimTK::Rotation& axes, const Vec3& anchor) const {
    return {{hang<Mobilizer>(parent, parent_place, body, place, axes, anchor)}, {parent_place.R()}};
  }
  template <class First, class Second>
  Chain on(const SimTK::Rotation& axes, const SimTK::Rotation& next_axes, const Vec3& anchor) const {
    const SimTK::Transform between(simbody(anchor));
    SimTK::MobilizedBody middle = hang<First>(parent, parent_place, SimTK::Body::Massless(), between, axes, anchor);
    const SimTK::MobilizedBody end = hang<Second>(middle, between, body, place, next_axes, anchor);
    return {{middle, end}, {parent_place.R(), SimTK::Rotation()}};
  }

  static SimTK::Rotation about_z(const Vec3& axis) {
    const auto [x, y] = across(axis);
    return of_axes(x, y, axis);
  }
  static SimTK::Rotation along_x(const Vec3& axis) {
    const auto [y, z] = across(axis);
    return of_axes(axis, y, z);
  }
  /// Of a universal joint, which turns about the parent's x and its own y.
  SimTK::Rotation crossed(const Vec3& axis1, const Vec3& axis2) const {
    const Vec3& x = body_is_first ? axis2 : axis1;
    const Vec3& y = body_is_first ? axis1 : axis2;
    return of_axes(x, y, cross(x, y));
  }

  Chain operator()(const BallJoint& ball) const {
    return on<SimTK::MobilizedBody::Ball>(SimTK::Rotation(), ball.anchor_m);
  }
  Chain operator()(const HingeJoint& hinge) const {
    return on<SimTK::MobilizedBody::Pin>(about_z(hinge.axis), hinge.anchor_m);
  }
  Chain operator()(const SliderJoint& slider) const {
    return on<SimTK::MobilizedBody::Slider>(along_x(slider.axis), slider.anchor_m);
  }
  Chain operator()(const UniversalJoint& joint) const {
    return on<SimTK::MobilizedBody::Universal>(crossed(joint.axis1, joint.axis2), joint.anchor_m);
  }
  Chain operator()(const FixedJoint& joint) const {
    return on<SimTK::MobilizedBody::Weld>(SimTK::Rotation(), joint.anchor_m);
  }
  Chain operator()(const PistonJoint& piston) const {
    return on<SimTK::MobilizedBody::Cylinder>(about_z(piston.axis), piston.anchor_m);
  }
  Chain operator()(const SlidingHingeJoint& joint) const {
    using Way = SimTK::MobilizedBody::Slider;
    using Turn = SimTK::MobilizedBody::Pin;
    const SimTK::Rotation way = along_x(joint.axis1);
    const SimTK::Rotation turn = about_z(joint.axis2);
    return body_is_first ? on<Turn, Way>(turn, way, joint.anchor_m) : on<Way, Turn>(way, turn, joint.anchor_m);
  }
  Chain operator()(const SlidingUniversalJoint& joint) const {
    return sliding(joint.way, joint.axis1, joint.axis2, joint.anchor_m);
  }
  Chain operator()(const Hinge2Joint& wheel) const {
    Chain chain = sliding(wheel.axis1, wheel.axis1, wheel.axis2, wheel.anchor_m);
    const SimTK::MobilizedBody& slides = body_is_first ? chain.bodies[1] : chain.bodies[0];
    SimTK::Force::MobilityLinearSpring(loads, slides, SimTK::MobilizerUIndex(0), wheel.stiffness, 0);
    SimTK::Force::MobilityLinearDamper(loads, slides, SimTK::MobilizerUIndex(0), wheel.damping);
    return chain;
  }
  Chain operator()(const PlaneJoint& joint) const {
    return on<SimTK::MobilizedBody::Planar>(SimTK::Rotation(), joint.anchor_m);
  }

 private:
  Chain sliding(const Vec3& along, const Vec3& axis1, const Vec3& axis2, const Vec3& anchor) const {
    using Way = SimTK::MobilizedBody::Slider;
    using Turns = SimTK::MobilizedBody::Universal;
    const SimTK::Rotation way = along_x(along);
    const SimTK::Rotation turns = crossed(axis1, axis2);
    return body_is_first ? on<Turns, Way>(turns, way, anchor) : on<Way, Turns>(way, turns, anchor);
  }
};

/// Which of a chain's bodies has a motion of its joint that a motor may drive, and as which of its own.
struct Mobility {
  std::size_t body;
  int number;
};
struct FindMobility {
  std::size_t motion;  // of driveable_of
  bool body_is_first;

  Mobility operator()(const UniversalJoint&) const { return {0, turn(motion)}; }
  Mobility operator()(const PistonJoint&) const { return {0, motion == 0 ? 1 : 0}; }
  Mobility operator()(const SlidingHingeJoint&) const { return {sliding(motion), 0}; }
  Mobility operator()(const SlidingUniversalJoint&) const {
    return {sliding(motion), motion == 0 ? 0 : turn(motion - 1)};
  }
  Mobility operator()(const Hinge2Joint&) const { return {sliding(1), turn(motion)}; }
  template <class Other>
  Mobility operator()(const Other&) const {
    throw std::logic_error("a joint that has no motion of several to drive");
  }

 private:
  /// The parent's axis is Simbody's first.
  int turn(std::size_t axis) const { return (axis == 0) == body_is_first ? 1 : 0; }
  /// The way comes first, from the parent on, where the parent is the joint's first.
  std::size_t sliding(std::size_t of) const { return (of == 0) == body_is_first ? 1 : 0; }
};

class Tree final : public SimbodyTree {
 public:
  Tree(const Mechanism& mechanism, const std::vector<Branch>& tree, double gravity);

  std::string version() const override;
  const std::vector<double>& start() const override { return start_; }
  std::size_t place_of_coordinate(std::size_t branch) const override;
  std::size_t place_of_speed(std::size_t branch) const override;
  std::size_t first_speed() const override;
  Motion place_of_motion(std::size_t branch, std::size_t motion) const override;
  void push(std::size_t speed, double force) override;
  Vec3 direction(const double* y, std::size_t branch, const Vec3& axis_at_start) override;
  const std::vector<double>& kick(const double* y, std::size_t speed) override;
  Impulse impulse(const double* y, std::size_t body, std::optional<std::size_t> other, const Vec3& point,
                  const Vec3& direction) override;
  void slope(const double* y, double* dydt) override;
  const Closure& closure(const double* y) override;
  void normalize(double* y) override;
  Eigen::VectorXd rates(const double* y, const Eigen::VectorXd& speeds) override;
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

/// The speeds that loops allow, at the coordinates of the last state that was asked for.
struct Loops {
  int equations = 0;  // 0: there are none
  /// How many of them no others imply: as at t = 0. Where loops are not quite closed those that are implied look as if
  /// they were not.
  Eigen::Index rank = -1;
  std::vector<double> coordinates;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors;  // of the constraints' Jacobian, turned over
  Closure closure;

  /// The least speeds that change what the constraints hold by this.
  Eigen::VectorXd least(const Eigen::VectorXd& change) const {
    const Eigen::VectorXd ordered = factors.colsPermutation().transpose() * change;
    Eigen::VectorXd speeds = Eigen::VectorXd::Zero(factors.rows());
    speeds.head(rank) = factors.matrixR()
                            .topLeftCorner(rank, rank)
                            .template triangularView<Eigen::Upper>()
                            .transpose()
                            .solve(ordered.head(rank));
    speeds.applyOnTheLeft(factors.householderQ());
    return speeds;
  }
};

/// A constraint that others imply up to this, of the largest, is one of them.
constexpr double implied = 1e-9;

std::vector<double> numbers(const SimTK::Vector& vector) {
  std::vector<double> all;
  for (int i = 0; i < vector.size(); ++i) all.push_back(vector[i]);
  return all;
}

Eigen::VectorXd eigen(const SimTK::Vector& vector) {
  Eigen::VectorXd all(vector.size());
  for (int i = 0; i < vector.size(); ++i) all[i] = vector[i];
  return all;
}

SimTK::Vector simbody(const Eigen::VectorXd& vector) {
  SimTK::Vector all(static_cast<int>(vector.size()));
  for (int i = 0; i < all.size(); ++i) all[i] = vector[i];
  return all;
}

struct Tree::System {
  Mechanism mechanism;
  std::vector<Branch> tree;
  double gravity;
  SimTK::MultibodySystem all;
  SimTK::SimbodyMatterSubsystem matter{all};
  SimTK::GeneralForceSubsystem loads{all};
  std::optional<SimTK::Force::DiscreteForces> pushes;  // where anything pushes
  std::vector<Chain> hung;                             // by branches
  std::vector<SimTK::MobilizedBody> bodies;            // by their numbers in the mechanism
  std::vector<std::pair<SimTK::MobilizedBody, SimTK::MobilizerUIndex>>
      moved_by;  // the body and the number of each speed
  SimTK::State state;
  SimTK::Vector_<SimTK::SpatialVec> reactions;
  Loops loops;

  System(Mechanism of, std::vector<Branch> order, double pull)
      : mechanism(std::move(of)), tree(std::move(order)), gravity(pull), bodies(mechanism.bodies.size()) {
    if (gravity != 0) SimTK::Force::Gravity(loads, matter, SimTK::Vec3(0, 0, -gravity));
    for (const Branch& branch : tree) add(branch);
    for (const Joint& joint : mechanism.joints) {
      if (joint.driven() && !pushes) pushes.emplace(loads, matter);
    }
    for (const Strut& strut : mechanism.struts) add(strut);
    all.realizeTopology();
    state = all.getDefaultState();
    for (const Branch& branch : tree) {
      if (!branch.joint) bodies[branch.body].setQToFitTransform(state, place_of(mechanism.bodies[branch.body]));
    }
    all.realize(state, SimTK::Stage::Position);
    for (std::size_t i = 0; i < tree.size(); ++i) set_speed(tree[i], hung[i]);
    for (SimTK::MobilizedBodyIndex i(1); i < matter.getNumBodies(); ++i) {
      const SimTK::MobilizedBody& body = matter.getMobilizedBody(i);
      for (SimTK::MobilizerUIndex u(0); u < body.getNumU(state); ++u) moved_by.emplace_back(body, u);
    }
  }

  void realize(const double* y, SimTK::Stage stage) {
    SimTK::Vector& numbers = state.updY();
    for (int i = 0; i < numbers.size(); ++i) numbers[i] = y[i];
    all.realize(state, stage);
  }

  const SimTK::MobilizedBody& body_of(std::size_t branch) const { return hung[branch].bodies.back(); }
  int place_of_speed(std::size_t branch) const { return int(body_of(branch).getFirstUIndex(state)); }

  /// Of the state that was realized last, to velocities.
  void find_loops() {
    const std::vector<double> now = numbers(state.getQ());
    if (loops.equations == 0 || now == loops.coordinates) return;
    loops.coordinates = now;
    SimTK::Matrix jacobian;
    matter.calcG(state, jacobian);
    Eigen::MatrixXd turned(jacobian.ncol(), jacobian.nrow());
    for (int i = 0; i < jacobian.nrow(); ++i) {
      for (int j = 0; j < jacobian.ncol(); ++j) turned(j, i) = jacobian(i, j);
    }
    loops.factors.setThreshold(implied);
    loops.factors.compute(turned);
    if (loops.rank < 0) loops.rank = loops.factors.rank();
    const Eigen::Index rank = loops.rank;
    loops.closure.free = Eigen::MatrixXd::Zero(turned.rows(), turned.rows() - rank);
    loops.closure.free.bottomRows(turned.rows() - rank).setIdentity();
    loops.closure.free.applyOnTheLeft(loops.factors.householderQ());
    const Eigen::VectorXd open = eigen(state.getQErr()).head(loops.equations);
    loops.closure.error = open.cwiseAbs().maxCoeff();
    loops.closure.mend = loops.least(-open);
    loops.closure.implied = rank < loops.equations;
    const auto holds = loops.factors.matrixR().diagonal().head(rank).cwiseAbs();
    loops.closure.margin = holds.minCoeff() / holds.maxCoeff();
    loops.closure.gain = 1 / holds.minCoeff();
  }

  /// Accelerations that keep loops closed: `least`, which are the least ones that do where nothing else acts, and what
  /// the forces add that those leave over.
  SimTK::Vector accelerate(const Eigen::VectorXd& least, const SimTK::Vector& along,
                           const SimTK::Vector_<SimTK::SpatialVec>& on_bodies) const {
    SimTK::Vector left_over;
    matter.calcResidualForceIgnoringConstraints(state, along, on_bodies, simbody(least), left_over);
    return simbody(least - freely(eigen(left_over)));
  }

  /// What forces along all speeds do to them, as far as loops allow.
  Eigen::VectorXd freely(const Eigen::VectorXd& forces) const {
    const Eigen::MatrixXd& free = loops.closure.free;
    Eigen::MatrixXd mass(free.rows(), free.cols());
    for (Eigen::Index j = 0; j < free.cols(); ++j) {
      SimTK::Vector column;
      matter.multiplyByM(state, simbody(free.col(j)), column);
      mass.col(j) = eigen(column);
    }
    return free * (free.transpose() * mass).llt().solve(free.transpose() * forces);
  }

  /// What an impulse along all speeds adds to them, in the state that was realized last, to velocities.
  SimTK::Vector gained_by(const SimTK::Vector& impulse) {
    find_loops();
    if (loops.equations > 0) return simbody(freely(eigen(impulse)));
    SimTK::Vector gained;
    matter.multiplyByMInv(state, impulse, gained);
    return gained;
  }

 private:
  SimTK::Transform place_of_parent(const Branch& branch) const {
    return branch.parent ? place_of(mechanism.bodies[*branch.parent]) : SimTK::Transform();
  }

  double parts_of(std::size_t body) const {
    double parts = 0;
    for (const Branch& branch : tree) parts += branch.body == body ? 1 : 0;
    return parts;
  }

  void add(const Branch& branch) {
    const Body& what = mechanism.bodies[branch.body];
    const SimTK::Body::Rigid body = rigid(what, parts_of(branch.body));
    SimTK::MobilizedBody ground = matter.updGround();
    if (!branch.joint) {
      bodies[branch.body] = SimTK::MobilizedBody::Free(ground, body);
      hung.push_back({{bodies[branch.body]}, {SimTK::Rotation()}});
      return;
    }
    const Joint& joint = mechanism.joints[*branch.joint];
    SimTK::MobilizedBody& parent = branch.parent ? bodies[*branch.parent] : ground;
    hung.push_back(std::visit(
        Hanging{parent, place_of_parent(branch), body, place_of(what), joint.first == branch.body, loads}, joint.kind));
    SimTK::MobilizedBody& made = hung.back().bodies.back();
    if (branch.again) {
      SimTK::Constraint::Weld(bodies[branch.body], made);
      loops.equations += 6;
    } else {
      bodies[branch.body] = made;
    }
  }

  void add(const Strut& strut) {
    const SimTK::MobilizedBody& first = bodies[strut.first];
    const SimTK::MobilizedBody& ground = matter.updGround();
    const SimTK::MobilizedBody& second = strut.second ? bodies[*strut.second] : ground;
    const SimTK::Vec3 first_end = ~place_of(mechanism.bodies[strut.first]) * simbody(strut.first_end_m);
    const SimTK::Transform second_place = strut.second ? place_of(mechanism.bodies[*strut.second]) : SimTK::Transform();
    const SimTK::Vec3 second_end = ~second_place * simbody(strut.second_end_m);
    SimTK::Force::TwoPointLinearSpring(loads, first, first_end, second, second_end, strut.stiffness_N_m, strut.rest_m);
    SimTK::Force::TwoPointLinearDamper(loads, first, first_end, second, second_end, strut.damping_Ns_m);
  }

  /// What the joint leaves of the body's velocity against that of its parent.
  void set_speed(const Branch& branch, const Chain& chain) {
    const Body& what = mechanism.bodies[branch.body];
    const Body world{};
    const Body& parent = branch.parent ? mechanism.bodies[*branch.parent] : world;
    const Vec3 anchor = branch.joint ? anchor_m(mechanism.joints[*branch.joint].kind) : what.position_m;
    const auto velocity = [&](const Body& of) {
      return of.velocity_m_s + cross(of.spin_rad_s, anchor - of.position_m);
    };
    const SimTK::SpatialVec relative(simbody(what.spin_rad_s - parent.spin_rad_s),
                                     simbody(velocity(what) - velocity(parent)));
    for (std::size_t i = 0; i < chain.bodies.size(); ++i) {
      const SimTK::Rotation frame = chain.turned[i] * chain.bodies[i].getInboardFrame(state).R();
      chain.bodies[i].setUToFitVelocity(state, ~frame * relative);
    }
  }
};

Tree::Tree(const Mechanism& mechanism, const std::vector<Branch>& tree, double gravity)
    : system_(std::make_unique<System>(mechanism, tree, gravity)),
      start_(numbers(system_->state.getY())),
      bodies_(mechanism.bodies.size()),
      forces_(tree.size()) {}

std::string Tree::version() const {
  int major = 0;
  int minor = 0;
  int build = 0;
  SimTK_version_simbody(&major, &minor, &build);
  return std::to_string(major) + "." + std::to_string(minor);
}

std::size_t Tree::place_of_coordinate(std::size_t branch) const {
  return static_cast<std::size_t>(int(system_->body_of(branch).getFirstQIndex(system_->state)));
}

std::size_t Tree::first_speed() const { return static_cast<std::size_t>(system_->state.getNQ()); }

std::size_t Tree::place_of_speed(std::size_t branch) const {
  return first_speed() + static_cast<std::size_t>(system_->place_of_speed(branch));
}

// Fixed in the body, which does not turn against what it slides on.
Vec3 Tree::direction(const double* y, std::size_t branch, const Vec3& axis_at_start) {
  system_->realize(y, SimTK::Stage::Position);
  const SimTK::Rotation start = place_of(system_->mechanism.bodies[system_->tree[branch].body]).R();
  return ours(system_->body_of(branch).getBodyRotation(system_->state) * (~start * simbody(axis_at_start)));
}

SimbodyTree::Motion Tree::place_of_motion(std::size_t branch, std::size_t motion) const {
  const System& system = *system_;
  const Joint& joint = system.mechanism.joints[*system.tree[branch].joint];
  const bool body_is_first = joint.first == system.tree[branch].body;
  const Mobility place = std::visit(FindMobility{motion, body_is_first}, joint.kind);
  const SimTK::MobilizedBody& body = system.hung[branch].bodies[place.body];
  return {static_cast<std::size_t>(int(body.getFirstQIndex(system.state)) + place.number),
          first_speed() + static_cast<std::size_t>(int(body.getFirstUIndex(system.state)) + place.number)};
}

void Tree::push(std::size_t speed, double force) {
  const auto& [body, number] = system_->moved_by[speed - first_speed()];
  system_->pushes->setOneMobilityForce(system_->state, body, number, force);
}

const std::vector<double>& Tree::kick(const double* y, std::size_t speed) {
  System& system = *system_;
  system.realize(y, SimTK::Stage::Velocity);
  SimTK::Vector impulse(system.matter.getNumMobilities(), 0.0);
  impulse[static_cast<int>(speed - first_speed())] = 1;
  kick_ = numbers(system.gained_by(impulse));
  return kick_;
}

SimbodyTree::Impulse Tree::impulse(const double* y, std::size_t body, std::optional<std::size_t> other,
                                   const Vec3& point, const Vec3& direction) {
  System& system = *system_;
  system.realize(y, SimTK::Stage::Velocity);
  SimTK::Vector_<SimTK::SpatialVec> loads(system.matter.getNumBodies(), SimTK::SpatialVec(SimTK::Vec3(0)));
  const auto load = [&](std::size_t number, const SimTK::Vec3& push) {
    const SimTK::MobilizedBody& on = system.bodies[number];
    const SimTK::Vec3 arm = simbody(point) - on.getBodyOriginLocation(system.state);
    loads[on.getMobilizedBodyIndex()] = SimTK::SpatialVec(arm % push, push);
  };
  load(body, simbody(direction));
  if (other) load(*other, -simbody(direction));
  SimTK::Vector along;
  system.matter.multiplyBySystemJacobianTranspose(system.state, loads, along);
  return {numbers(along), numbers(system.gained_by(along))};
}

void Tree::slope(const double* y, double* dydt) {
  System& system = *system_;
  if (system.loops.equations == 0) {
    system.realize(y, SimTK::Stage::Acceleration);
    const SimTK::Vector& slopes = system.state.getYDot();
    for (int i = 0; i < slopes.size(); ++i) dydt[i] = slopes[i];
    return;
  }
  system.realize(y, SimTK::Stage::Dynamics);
  system.find_loops();
  const SimTK::Vector rest(system.matter.getNumMobilities(), 0.0);
  SimTK::Vector opening;
  system.matter.calcConstraintAccelerationErrors(system.state, rest, opening);
  const SimTK::Vector gained = system.accelerate(system.loops.least(-eigen(opening)),
                                                 system.all.getMobilityForces(system.state, SimTK::Stage::Dynamics),
                                                 system.all.getRigidBodyForces(system.state, SimTK::Stage::Dynamics));
  const SimTK::Vector& rates = system.state.getQDot();
  for (int i = 0; i < rates.size(); ++i) dydt[i] = rates[i];
  for (int i = 0; i < gained.size(); ++i) dydt[rates.size() + i] = gained[i];
}

const Closure& Tree::closure(const double* y) {
  system_->realize(y, SimTK::Stage::Velocity);
  system_->find_loops();
  return system_->loops.closure;
}

// Of a body that has one coordinate more than speeds they are the first four.
void Tree::normalize(double* y) {
  const System& system = *system_;
  for (SimTK::MobilizedBodyIndex i(1); i < system.matter.getNumBodies(); ++i) {
    const SimTK::MobilizedBody& body = system.matter.getMobilizedBody(i);
    if (body.getNumQ(system.state) == body.getNumU(system.state)) continue;
    Eigen::Map<Eigen::Vector4d>(y + int(body.getFirstQIndex(system.state))).normalize();
  }
}

Eigen::VectorXd Tree::rates(const double* y, const Eigen::VectorXd& speeds) {
  system_->realize(y, SimTK::Stage::Position);
  SimTK::Vector rates;
  system_->matter.multiplyByN(system_->state, false, simbody(speeds), rates);
  return eigen(rates);
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
  system.realize(start_.data(), SimTK::Stage::Dynamics);
  system.find_loops();
  const SimTK::Vector along = system.all.getMobilityForces(system.state, SimTK::Stage::Dynamics);
  SimTK::Vector_<SimTK::SpatialVec> loads = system.all.getRigidBodyForces(system.state, SimTK::Stage::Dynamics);
  for (SimTK::MobilizedBodyIndex i(1); i < system.matter.getNumBodies(); ++i) {
    const SimTK::MobilizedBody& body = system.matter.getMobilizedBody(i);
    const SimTK::Vec3& spin = body.getBodyAngularVelocity(system.state);
    const SimTK::Inertia inertia =
        body.getBodyMassProperties(system.state).getInertia().reexpress(~body.getBodyRotation(system.state));
    loads[i][0] -= spin % (inertia * spin);
  }
  system.state.updU() = 0;
  system.all.realize(system.state, SimTK::Stage::Velocity);
  SimTK::Vector gained;
  if (system.loops.equations > 0) {
    gained = system.accelerate(Eigen::VectorXd::Zero(along.size()), along, loads);
  } else {
    system.all.realize(system.state, SimTK::Stage::Dynamics);
    SimTK::Vector_<SimTK::SpatialVec> unused;
    system.matter.calcAccelerationIgnoringConstraints(system.state, along, loads, gained, unused);
  }
  std::vector<double> y = start_;
  const std::size_t coordinates = y.size() - static_cast<std::size_t>(gained.size());
  for (int i = 0; i < gained.size(); ++i) y[coordinates + static_cast<std::size_t>(i)] += dt * gained[i];
  return bodies(y.data());
}

const std::vector<Vec3>& Tree::forces(const double* y) {
  system_->realize(y, SimTK::Stage::Acceleration);
  system_->matter.calcMobilizerReactionForces(system_->state, system_->reactions);
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    forces_[i] = ours(system_->reactions[system_->body_of(i).getMobilizedBodyIndex()][1]);
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
