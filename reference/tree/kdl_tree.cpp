// A robot in KDL as its file says it: every link a segment, fixed ones as well.
#include <Eigen/Dense>
#include <kdl/tree.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <numeric>
#include <stdexcept>

#include "reference/tree/joint_space.hpp"

namespace odeval::reference {
namespace {

using Kind = Robot::Joint::Kind;
using Eigen::Matrix3d;
using Eigen::Vector3d;

KDL::Vector kdl(const Vec3& v) { return {v[0], v[1], v[2]}; }
KDL::Rotation kdl(const Rotation& r) { return {r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]}; }
KDL::Frame kdl(const Frame& frame) { return {kdl(frame.rotation), kdl(frame.position_m)}; }

/// In the link's frame. KDL wants the tensor about its origin along its axes, and takes it about the centre.
KDL::RigidBodyInertia inertia_of(const Robot::Link& link) {
  if (!link.mass) return KDL::RigidBodyInertia(0);
  const Robot::Inertia& i = link.mass->inertia_kgm2;
  const KDL::RigidBodyInertia own(link.mass->mass_kg, KDL::Vector::Zero(),
                                  KDL::RotationalInertia(i[0], i[1], i[2], i[3], i[4], i[5]));
  return kdl(link.mass->frame) * own;
}

class KdlTree {
 public:
  KdlTree(const Robot& robot, const std::vector<std::optional<std::size_t>>& body_of, const Mechanism& mechanism)
      : robot_(robot), body_of_(body_of), mechanism_(mechanism), coordinates_(mechanism.bodies.size()) {
    std::vector<bool> made(mechanism.bodies.size());
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      add(i, body_of[i] && !made[*body_of[i]]);
      if (body_of[i]) made[*body_of[i]] = true;
    }
  }

  JointSpace at(const TreeState& state, double gravity) {
    const unsigned count = tree_.getNrOfJoints();
    q_.resize(count);
    q_.data.setZero();
    rate_ = drift_ = Eigen::VectorXd::Zero(count);
    from_ours_ = Eigen::MatrixXd::Zero(count, count);
    Eigen::Index ours = 0;
    for (std::size_t b = 0; b < coordinates_.size(); ++b) put(b, state[b], ours);

    KDL::TreeIdSolver_RNE solver(tree_, KDL::Vector(0, 0, -gravity));
    const auto torques = [&](const Eigen::VectorXd& acceleration) {
      KDL::JntArray rate(count);
      KDL::JntArray wanted(count);
      KDL::JntArray torque(count);
      rate.data = rate_;
      wanted.data = acceleration;
      if (solver.CartToJnt(q_, rate, wanted, {}, torque) != KDL::SolverI::E_NOERROR)
        throw std::domain_error(solver.strError(solver.getError()));
      return Eigen::VectorXd(torque.data);
    };
    const Eigen::VectorXd bias = torques(Eigen::VectorXd::Zero(count));
    Eigen::MatrixXd mass(count, count);
    for (Eigen::Index j = 0; j < mass.cols(); ++j) mass.col(j) = torques(Eigen::VectorXd::Unit(mass.cols(), j)) - bias;
    return {from_ours_.transpose() * mass * from_ours_, from_ours_.transpose() * (mass * drift_ + bias)};
  }

 private:
  std::string name_of(const std::optional<std::size_t>& link) const {
    return link ? std::to_string(*link) : std::string("root");
  }

  void segment(const std::string& on, const std::string& name, const KDL::Joint& joint, const KDL::Frame& tip,
               const KDL::RigidBodyInertia& inertia = KDL::RigidBodyInertia(0)) {
    if (!tree_.addSegment(KDL::Segment(name, joint, tip, inertia), on))
      throw std::domain_error("KDL takes no segment " + name);
  }

  /// A link on its joint; with `carries` the joint is that of a body, and has coordinates.
  void add(std::size_t i, bool carries) {
    const Robot::Joint& joint = robot_.joints[i];
    const std::string name = std::to_string(i);
    const KDL::Frame half = kdl(joint.frame);
    const KDL::Frame link = kdl(joint.link);
    const KDL::RigidBodyInertia inertia = inertia_of(robot_.links[i]);
    starts_.push_back((joint.parent ? starts_[*joint.parent] : KDL::Frame::Identity()) * half * start_of(joint) * link);
    std::string on = name_of(joint.parent);
    const auto next = [&](const KDL::Joint& what, const KDL::Frame& tip) {
      const std::string part = name + "." + std::to_string(++parts_);
      segment(on, part, what, tip);
      on = part;
    };
    if (!carries || joint.kind == Kind::fixed) {
      segment(on, name, KDL::Joint(KDL::Joint::None), half * link, inertia);
      return;
    }
    const std::size_t body = *body_of_[i];
    coordinates_[body] = {tree_.getNrOfJoints(), joint.kind, joint.start};
    const KDL::Frame at_joint = half;
    const KDL::Vector axis = kdl(joint.axis);
    switch (joint.kind) {
      case Kind::hinge:
      case Kind::slider:
        next(KDL::Joint(KDL::Joint::None), at_joint);
        segment(on, name,
                KDL::Joint(name, KDL::Vector::Zero(), axis,
                           joint.kind == Kind::hinge ? KDL::Joint::RotAxis : KDL::Joint::TransAxis),
                link, inertia);
        return;
      case Kind::universal:
        next(KDL::Joint(KDL::Joint::None), at_joint);
        next(KDL::Joint(name, KDL::Vector::Zero(), axis, KDL::Joint::RotAxis), KDL::Frame::Identity());
        segment(on, name, KDL::Joint(name, KDL::Vector::Zero(), kdl(joint.axis2), KDL::Joint::RotAxis), link, inertia);
        return;
      case Kind::ball: {  // about axes that are the world's at t = 0
        const KDL::Frame world((starts_.back() * link.Inverse()).M.Inverse());
        next(KDL::Joint(KDL::Joint::None), at_joint * world);
        turn_about_three(next);
        segment(on, name, KDL::Joint(KDL::Joint::None), world.Inverse() * link, inertia);
        return;
      }
      case Kind::free: {  // about its centre, which the mechanism knows
        on = name_of({});
        const KDL::Frame centre(kdl(mechanism_.bodies[body].position_m));
        next(KDL::Joint(KDL::Joint::None), centre);
        for (const auto way : {KDL::Joint::TransX, KDL::Joint::TransY, KDL::Joint::TransZ}) {
          next(KDL::Joint(way), KDL::Frame::Identity());
        }
        turn_about_three(next);
        segment(on, name, KDL::Joint(KDL::Joint::None), centre.Inverse() * starts_.back(), inertia);
        return;
      }
      case Kind::fixed:
        return;
    }
  }

  template <class Next>
  static void turn_about_three(const Next& next) {
    for (const auto turn : {KDL::Joint::RotX, KDL::Joint::RotY, KDL::Joint::RotZ}) {
      next(KDL::Joint(turn), KDL::Frame::Identity());
    }
  }

  static KDL::Frame start_of(const Robot::Joint& joint) {
    if (joint.kind == Kind::hinge) return KDL::Frame(KDL::Rotation::Rot(kdl(joint.axis), joint.start));
    if (joint.kind == Kind::slider) return KDL::Frame(kdl(joint.start * joint.axis));
    return KDL::Frame::Identity();
  }

  /// A body's coordinates and speeds into KDL's, and how those follow from ours.
  void put(std::size_t body, const JointCoordinates& at, Eigen::Index& ours) {
    const Coordinate& coordinate = coordinates_[body];
    const auto place = static_cast<Eigen::Index>(coordinate.first);
    const auto take = [&](Eigen::Index kdl, std::size_t k) {
      q_.data[kdl] = at.q[k] + (k == 0 ? coordinate.start : 0);
      rate_[kdl] = at.u[k];
      from_ours_(kdl, ours++) = 1;
    };
    switch (coordinate.kind) {
      case Kind::hinge:
      case Kind::slider:
        take(place, 0);
        return;
      case Kind::universal:
        take(place, 0);
        take(place + 1, 1);
        return;
      case Kind::ball:
        put_turn(place, at, ours);
        ours += 3;
        return;
      case Kind::free:
        put_turn(place + 3, at, ours);
        ours += 3;
        for (std::size_t k = 3; k < 6; ++k) take(place + static_cast<Eigen::Index>(k) - 3, k);
        return;
      case Kind::fixed:
        return;
    }
  }

  /// A rotation vector as turns about x, y and z, and a spin as their rates.
  void put_turn(Eigen::Index place, const JointCoordinates& at, Eigen::Index ours) {
    const Vector3d vector{at.q[0], at.q[1], at.q[2]};
    const Vector3d spin{at.u[0], at.u[1], at.u[2]};
    const Matrix3d turned = Eigen::AngleAxisd(vector.norm(), vector.normalized()).toRotationMatrix();
    const Vector3d angles{std::atan2(-turned(1, 2), turned(2, 2)), std::asin(turned(0, 2)),
                          std::atan2(-turned(0, 1), turned(0, 0))};
    const Matrix3d x = Eigen::AngleAxisd(angles[0], Vector3d::UnitX()).toRotationMatrix();
    const Matrix3d y = Eigen::AngleAxisd(angles[1], Vector3d::UnitY()).toRotationMatrix();
    Matrix3d axes;
    axes << Vector3d::UnitX(), x.col(1), (x * y).col(2);
    const Matrix3d back = axes.inverse();
    const Vector3d rates = back * spin;
    const Vector3d after_first = rates[0] * axes.col(0);
    const Vector3d after_second = after_first + rates[1] * axes.col(1);
    const Vector3d moving = rates[1] * after_first.cross(axes.col(1)) + rates[2] * after_second.cross(axes.col(2));
    q_.data.segment<3>(place) = angles;
    rate_.segment<3>(place) = rates;
    drift_.segment<3>(place) = -back * moving;
    from_ours_.block<3, 3>(place, ours) = back;
  }

  struct Coordinate {
    unsigned first = 0;  // of KDL's
    Kind kind = Kind::fixed;
    double start = 0;
  };

  const Robot& robot_;
  const std::vector<std::optional<std::size_t>>& body_of_;
  const Mechanism& mechanism_;
  KDL::Tree tree_{"root"};
  int parts_ = 0;
  std::vector<KDL::Frame> starts_;       // of links in the world at t = 0
  std::vector<Coordinate> coordinates_;  // by bodies
  KDL::JntArray q_;
  Eigen::VectorXd rate_;
  Eigen::VectorXd drift_;      // of KDL's speeds where none of ours changes
  Eigen::MatrixXd from_ours_;  // KDL's speeds over ours
};

}  // namespace

JointSpace joint_space_by_kdl(const Robot& robot, const std::vector<std::optional<std::size_t>>& body_of,
                              const Mechanism& mechanism, const TreeState& state, double gravity) {
  return KdlTree(robot, body_of, mechanism).at(state, gravity);
}

}  // namespace odeval::reference
