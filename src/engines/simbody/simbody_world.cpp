#include "engines/simbody/simbody_world.hpp"

#include <Simbody.h>

#include <cmath>
#include <string>
#include <variant>

#include "engines/tree/hanging.hpp"
#include "engines/tree/joint_loads.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_simbody {
namespace {

using engine_tree::Degree;
using engine_tree::Hanging;
using engine_tree::Place;
using engine_tree::Placed;

SimTK::Vec3 simbody(const Vec3& v) { return {v[0], v[1], v[2]}; }
Vec3 ours(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

Rotation ours(const SimTK::Rotation& r) {
  Rotation made{};
  for (int k = 0; k < 9; ++k) made[static_cast<std::size_t>(k)] = r.asMat33()(k / 3, k % 3);
  return made;
}

SimTK::Transform simbody(const Place& place) {
  const Rotation& r = place.rotation;
  return {SimTK::Rotation(SimTK::Mat33(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]), true),
          simbody(place.position_m)};
}

SimTK::Body::Rigid rigid(const Body& body) {
  const std::array<double, 9> i = engine_tree::inertia_of(body);
  return SimTK::Body::Rigid({body.mass_kg, SimTK::Vec3(0), SimTK::Inertia(i[0], i[4], i[8], i[1], i[2], i[5])});
}

/// Axes in the world with one of them (0, 1, 2) along a direction.
SimTK::Rotation along(const Vec3& direction, SimTK::CoordinateAxis axis) {
  return SimTK::Rotation(SimTK::UnitVec3(simbody(direction)), axis);
}

/// A body on its joint. The joint's halves coincide at t = 0.
struct Hang {
  SimTK::MobilizedBody& parent;
  const Hanging& hanging;
  const SimTK::Body::Rigid& body;

  template <class Mobilizer>
  SimTK::MobilizedBody on(const SimTK::Rotation& axes) const {
    const SimTK::Transform frame(axes, simbody(hanging.anchor_m));
    return Mobilizer(parent, ~simbody(hanging.parent_place) * frame, body, ~simbody(hanging.place) * frame);
  }

  SimTK::MobilizedBody operator()() const {
    if (!hanging.joint) return SimTK::MobilizedBody::Free(parent, body);
    if (hanging.ball) return on<SimTK::MobilizedBody::Ball>({});
    if (hanging.degrees.empty()) return on<SimTK::MobilizedBody::Weld>({});
    const Degree& degree = hanging.degrees.front();
    if (hanging.degrees.size() == 2) {  // turns about the parent's x, then about its own y
      return on<SimTK::MobilizedBody::Universal>(SimTK::Rotation(SimTK::UnitVec3(simbody(degree.axis)), SimTK::XAxis,
                                                                 simbody(hanging.degrees[1].axis), SimTK::YAxis));
    }
    if (degree.turns) return on<SimTK::MobilizedBody::Pin>(along(degree.axis, SimTK::ZAxis));
    return on<SimTK::MobilizedBody::Slider>(along(degree.axis, SimTK::XAxis));
  }
};

/// A joint that closes a loop, as equations between two bodies.
struct Close {
  SimTK::MobilizedBody& first;
  SimTK::Transform first_place;
  SimTK::MobilizedBody& second;  // the ground where it is the world
  SimTK::Transform second_place;

  using Made = std::vector<SimTK::Constraint>;

  Made operator()(const BallJoint& ball) const { return {hold(ball.anchor_m)}; }
  Made operator()(const HingeJoint& hinge) const {
    const SimTK::Rotation axes = along(hinge.axis, SimTK::ZAxis);
    Made made{hold(hinge.anchor_m)};
    for (const auto& across : {axes.x(), axes.y()}) {
      made.push_back(SimTK::Constraint::ConstantAngle(first, ~first_place.R() * across, second,
                                                      ~second_place.R() * axes.z(), SimTK::Pi / 2));
    }
    return made;
  }
  Made operator()(const FixedJoint& joint) const {
    const SimTK::Transform frame(simbody(joint.anchor_m));
    return {SimTK::Constraint::Weld(first, ~first_place * frame, second, ~second_place * frame)};
  }
  template <class Other>
  Made operator()(const Other&) const {
    throw UserError("Simbody is given loops of hinges, ball joints and fixed ones, not of other kinds");
  }

 private:
  SimTK::Constraint hold(const Vec3& anchor_m) const {
    const SimTK::Vec3 point = simbody(anchor_m);
    return SimTK::Constraint::Ball(first, ~first_place * point, second, ~second_place * point);
  }
};

using Loads = engine_tree::JointLoads<SimTK::MobilizedBodyIndex>;

/// Simbody asks for them whenever it wants accelerations.
class LoadForces final : public SimTK::Force::Custom::Implementation {
 public:
  LoadForces(const Loads& loads, const SimTK::SimbodyMatterSubsystem& matter) : loads_(loads), matter_(matter) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>&, SimTK::Vector_<SimTK::Vec3>&,
                 SimTK::Vector& mobility) const override {
    loads_.apply(
        state.getTime(), [&](auto body) { return matter_.getMobilizedBody(body).getOneQ(state, 0); },
        [&](auto body) { return matter_.getMobilizedBody(body).getOneU(state, 0); },
        [&](auto body, double force) {
          matter_.getMobilizedBody(body).applyOneMobilityForce(state, SimTK::MobilizerUIndex(0), force, mobility);
        });
  }
  double calcPotentialEnergy(const SimTK::State&) const override { return 0; }

 private:
  const Loads& loads_;
  const SimTK::SimbodyMatterSubsystem& matter_;
};

class SimbodyWorld final : public engine_tree::World {
 public:
  SimbodyWorld(const Mechanism& mechanism, const Stepping& stepping)
      : stepping_(stepping), nodes_(mechanism.bodies.size()), bodies_(mechanism.bodies.size()) {
    SimTK::Force::Gravity(forces_, matter_, SimTK::Vec3(0, 0, -stepping.gravity));
    std::vector<std::size_t> closing;
    const std::vector<Hanging> tree = engine_tree::hang(mechanism, &closing);
    SimTK::MobilizedBody ground = matter_.updGround();
    for (const Hanging& hanging : tree) {
      SimTK::MobilizedBody& parent = hanging.parent ? nodes_[*hanging.parent] : ground;
      SimTK::MobilizedBody& node = nodes_[hanging.body];
      node = Hang{parent, hanging, rigid(mechanism.bodies[hanging.body])}();
      if (hanging.degrees.size() == 1) loads_.add(mechanism.joints[*hanging.joint], node.getMobilizedBodyIndex());
    }
    if (!loads_.empty()) SimTK::Force::Custom(forces_, new LoadForces(loads_, matter_));
    for (const std::size_t joint : closing) close(mechanism.joints[joint], tree);
    system_.realizeTopology();
    start(mechanism, tree);
  }

  long step(double from, double to) override {
    if (loads_.sampled()) sample(from);
    const int before = integrator_->getNumStepsTaken();
    try {
      while (integrator_->getTime() < to) integrator_->stepTo(to);
    } catch (const std::exception& error) {
      throw engine_tree::Lost(std::string("Simbody: ") + error.what());
    }
    const SimTK::Vector& speeds = integrator_->getState().getU();
    double sum = 0;
    for (int k = 0; k < speeds.size(); ++k) sum += speeds[k] * speeds[k];
    engine_tree::require_finite(sum);
    return integrator_->getNumStepsTaken() - before;
  }

  // What a controller holds changes at every step of the scenario, at which a step has to end.
  bool chooses_steps() const override { return stepping_.merson && !loads_.sampled(); }

  const std::vector<Placed>& bodies() override {
    const SimTK::State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Velocity);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const SimTK::MobilizedBody& node = nodes_[i];
      bodies_[i] = {ours(node.getBodyOriginLocation(state)), ours(node.getBodyRotation(state)),
                    ours(node.getBodyOriginVelocity(state)), ours(node.getBodyAngularVelocity(state))};
    }
    return bodies_;
  }

  // Those of the moment at which the step ended.
  std::vector<Vec3> closing_forces() override {
    std::vector<Vec3> forces;
    const SimTK::State& state = integrator_->getState();
    if (!loops_.empty()) system_.realize(state, SimTK::Stage::Acceleration);
    for (const Loop& loop : loops_) {
      SimTK::Vec3 force(0);
      for (const SimTK::Constraint& constraint : loop.equations) {
        const SimTK::Vector_<SimTK::SpatialVec> on_bodies = constraint.getConstrainedBodyForcesAsVector(state);
        for (SimTK::ConstrainedBodyIndex k(0); k < constraint.getNumConstrainedBodies(); ++k) {
          if (constraint.getMobilizedBodyFromConstrainedBody(k).getMobilizedBodyIndex() != loop.first) continue;
          force -= on_bodies[k][1];  // Simbody has them on the other side of the equations
        }
      }
      forces.push_back(ours(force));
    }
    return forces;
  }

  Told told() const override {
    int major = 0;
    int minor = 0;
    int build = 0;
    SimTK_version_simbody(&major, &minor, &build);
    Told told{{"version", std::to_string(major) + "." + std::to_string(minor)},
              {"integrator", std::string(integrator_->getMethodName())},
              {"constraint_tolerance", integrator_->getConstraintToleranceInUse()}};
    if (stepping_.merson) {
      told.push_back({"accuracy", integrator_->getAccuracyInUse()});
      told.push_back({"norm", std::string(integrator_->isInfinityNormInUse() ? "infinity" : "rms")});
    }
    return told;
  }

 private:
  struct Loop {
    SimTK::MobilizedBodyIndex first;
    std::vector<SimTK::Constraint> equations;
  };

  void close(const Joint& joint, const std::vector<Hanging>& tree) {
    if (joint.loaded())
      throw UserError("Simbody is given no springs, torques and controllers of a joint that closes a loop");
    const auto place = [&](std::size_t body) {
      for (const Hanging& hanging : tree) {
        if (hanging.body == body) return simbody(hanging.place);
      }
      throw MachineError("a body that does not hang");
    };
    SimTK::MobilizedBody& first = nodes_[joint.first];
    SimTK::MobilizedBody& ground = matter_.updGround();
    loops_.push_back({first.getMobilizedBodyIndex(),
                      std::visit(Close{first, place(joint.first), joint.second ? nodes_[*joint.second] : ground,
                                       joint.second ? place(*joint.second) : SimTK::Transform()},
                                 joint.kind)});
  }

  void start(const Mechanism& mechanism, const std::vector<Hanging>& tree) {
    SimTK::State state = system_.getDefaultState();
    for (const Hanging& hanging : tree) {
      if (!hanging.joint) nodes_[hanging.body].setQToFitTransform(state, simbody(hanging.place));
    }
    system_.realize(state, SimTK::Stage::Position);
    for (const Hanging& hanging : tree) {
      const SimTK::MobilizedBody& node = nodes_[hanging.body];
      if (!hanging.joint) {
        node.setUToFitVelocity(state,
                               {simbody(hanging.spin_rad_s), simbody(mechanism.bodies[hanging.body].velocity_m_s)});
      }
      // A ball's spin is in its parent's half of the joint, which stands as the world does at t = 0.
      if (hanging.ball) node.setUToFitAngularVelocity(state, simbody(hanging.spin_rad_s));
      for (std::size_t k = 0; k < hanging.degrees.size(); ++k) {
        node.setOneU(state, static_cast<int>(k), hanging.degrees[k].rate);
      }
    }
    if (stepping_.merson) {
      integrator_ = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
      integrator_->setAccuracy(stepping_.rtol);
      integrator_->setConstraintTolerance(stepping_.rtol / 10);
      integrator_->setUseInfinityNorm(false);
    } else {
      integrator_ = std::make_unique<SimTK::SemiExplicitEulerIntegrator>(system_, stepping_.step_s);
    }
    integrator_->setAllowInterpolation(chooses_steps());
    integrator_->setProjectEveryStep(!loops_.empty());
    integrator_->setProjectInterpolatedStates(true);
    integrator_->initialize(state);
  }

  void sample(double t) {
    const SimTK::State& state = integrator_->getState();
    loads_.sample(
        t, [&](auto body) { return matter_.getMobilizedBody(body).getOneQ(state, 0); },
        [&](auto body) { return matter_.getMobilizedBody(body).getOneU(state, 0); });
    // The accelerations that Simbody keeps are those of the loads before.
    integrator_->updAdvancedState().invalidateAllCacheAtOrAbove(SimTK::Stage::Dynamics);
    integrator_->reinitialize(SimTK::Stage::Dynamics, false);
  }

  Stepping stepping_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  Loads loads_;
  std::vector<SimTK::MobilizedBody> nodes_;  // by the numbers of bodies
  std::vector<Loop> loops_;                  // in the order of hang
  std::unique_ptr<SimTK::Integrator> integrator_;
  std::vector<Placed> bodies_;
};

}  // namespace

std::unique_ptr<engine_tree::World> make_world(const Mechanism& mechanism, const Stepping& stepping) {
  return std::make_unique<SimbodyWorld>(mechanism, stepping);
}

}  // namespace odeval::engine_simbody
