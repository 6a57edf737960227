#include "reference/tree/simbody_tree.hpp"

#include <Simbody.h>

#include <utility>

#include "reference/tree/simbody_numbers.hpp"
#include "reference/tree/simbody_system.hpp"

namespace odeval::reference {
namespace {

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
  Vec3 direction(const double* y, std::size_t body, const Vec3& at_start) override;
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
  std::unique_ptr<SimbodySystem> system_;
  std::vector<double> start_;
  std::vector<Placed> bodies_;
  std::vector<Vec3> forces_;
  std::vector<double> kick_;
};

Tree::Tree(const Mechanism& mechanism, const std::vector<Branch>& tree, double gravity)
    : system_(std::make_unique<SimbodySystem>(mechanism, tree, gravity)),
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

Vec3 Tree::direction(const double* y, std::size_t body, const Vec3& at_start) {
  system_->realize(y, SimTK::Stage::Position);
  const SimTK::Rotation start = place_of(system_->mechanism.bodies[body]).R();
  return ours(system_->bodies[body].getBodyRotation(system_->state) * (~start * simbody(at_start)));
}

SimbodyTree::Motion Tree::place_of_motion(std::size_t branch, std::size_t motion) const {
  const SimbodySystem& system = *system_;
  const Joint& joint = system.mechanism.joints[*system.tree[branch].joint];
  const bool body_is_first = joint.first == system.tree[branch].body;
  const Mobility place = mobility_of(joint.kind, motion, body_is_first);
  const SimTK::MobilizedBody& body = system.hung[branch].bodies[place.body];
  return {static_cast<std::size_t>(int(body.getFirstQIndex(system.state)) + place.number),
          first_speed() + static_cast<std::size_t>(int(body.getFirstUIndex(system.state)) + place.number)};
}

void Tree::push(std::size_t speed, double force) {
  const auto& [body, number] = system_->moved_by[speed - first_speed()];
  system_->pushes->setOneMobilityForce(system_->state, body, number, force);
}

const std::vector<double>& Tree::kick(const double* y, std::size_t speed) {
  SimbodySystem& system = *system_;
  system.realize(y, SimTK::Stage::Velocity);
  SimTK::Vector impulse(system.matter.getNumMobilities(), 0.0);
  impulse[static_cast<int>(speed - first_speed())] = 1;
  kick_ = numbers(system.gained_by(impulse));
  return kick_;
}

SimbodyTree::Impulse Tree::impulse(const double* y, std::size_t body, std::optional<std::size_t> other,
                                   const Vec3& point, const Vec3& direction) {
  SimbodySystem& system = *system_;
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
  SimbodySystem& system = *system_;
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
  const SimbodySystem& system = *system_;
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
  SimbodySystem& system = *system_;
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
  SimbodySystem& system = *system_;
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
