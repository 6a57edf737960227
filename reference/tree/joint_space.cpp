#include "reference/tree/joint_space.hpp"

#include <Eigen/Geometry>

#include <numeric>
#include <variant>

#include "odeval/error.hpp"
#include "reference/tree/simbody_tree.hpp"

namespace odeval::reference {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }
Matrix3d turn_about(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, eigen(axis).normalized()).toRotationMatrix();
}
Matrix3d turn_by(const Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

/// A displacement of all space from t = 0.
struct Shift {
  Matrix3d turn = Matrix3d::Identity();
  Vector3d way = Vector3d::Zero();

  static Shift about(const Vector3d& point, const Matrix3d& turn) { return {turn, point - turn * point}; }
  Vector3d operator()(const Vector3d& point) const { return turn * point + way; }
  Shift operator*(const Shift& then) const { return {turn * then.turn, turn * then.way + way}; }
};

/// A body on its way: where it is, how it moves, and how it would accelerate if no speed of a joint changed.
struct Moving {
  Shift shift{};
  Vector3d centre = Vector3d::Zero();
  Vector3d spin = Vector3d::Zero();
  Vector3d velocity = Vector3d::Zero();
  Vector3d spin_rate = Vector3d::Zero();
  Vector3d acceleration = Vector3d::Zero();
};

/// One speed of a joint: the axis now, and the point about which it turns; of a way no point.
struct Axis {
  Vector3d direction;
  bool turns;
  Vector3d point;
};

/// What a joint does to the body that it carries.
struct Carry {
  const Moving& parent;
  const JointCoordinates& at;
  const Vector3d& start;  // of the body's centre, at t = 0
  bool body_is_first;
  Moving& body;
  std::vector<Axis>& axes;

  void operator()(const FixedJoint& joint) const { turn(joint.anchor_m, Matrix3d::Identity(), {}); }
  void operator()(const HingeJoint& joint) const {
    turn(joint.anchor_m, turn_about(joint.axis, at.q[0]), {parent.shift.turn * eigen(joint.axis)});
  }
  void operator()(const UniversalJoint& joint) const {
    const Vec3& own = body_is_first ? joint.axis1 : joint.axis2;
    const Vec3& carried = body_is_first ? joint.axis2 : joint.axis1;
    const Matrix3d half = turn_about(carried, at.q[0]);
    turn(joint.anchor_m, half * turn_about(own, at.q[1]),
         {parent.shift.turn * eigen(carried), parent.shift.turn * half * eigen(own)}, true);
  }
  void operator()(const BallJoint& joint) const {
    const Matrix3d& turned = parent.shift.turn;
    turn(joint.anchor_m, turn_by({at.q[0], at.q[1], at.q[2]}), {turned.col(0), turned.col(1), turned.col(2)});
  }
  void operator()(const SliderJoint& joint) const {
    const Vector3d along = parent.shift.turn * eigen(joint.axis);
    body.shift = parent.shift * Shift{Matrix3d::Identity(), at.q[0] * eigen(joint.axis)};
    body.centre = body.shift(start);
    axes.push_back({along, false, Vector3d::Zero()});
    ride(body.centre, body.velocity, body.acceleration);
    body.spin = parent.spin;
    body.spin_rate = parent.spin_rate;
    body.velocity += at.u[0] * along;
    body.acceleration += 2 * at.u[0] * parent.spin.cross(along);
  }
  void operator()(const PistonJoint&) const { refuse("piston"); }
  void operator()(const SlidingHingeJoint&) const { refuse("pr"); }
  void operator()(const SlidingUniversalJoint&) const { refuse("pu"); }
  void operator()(const Hinge2Joint&) const { refuse("hinge2"); }
  void operator()(const PlaneJoint&) const { refuse("plane2d"); }

 private:
  [[noreturn]] static void refuse(const char* kind) {
    throw MachineError(std::string("a joint of kind ") + kind + " is of no robot: its import can not be proved");
  }
  /// How a point moves that is fixed in the parent.
  void ride(const Vector3d& point, Vector3d& velocity, Vector3d& acceleration) const {
    const Vector3d arm = point - parent.centre;
    velocity = parent.velocity + parent.spin.cross(arm);
    acceleration = parent.acceleration + parent.spin_rate.cross(arm) + parent.spin.cross(parent.spin.cross(arm));
  }

  /// About an anchor. The parent carries the axes, or with `in_turn` each axis all after it.
  void turn(const Vec3& anchor, const Matrix3d& by, const std::vector<Vector3d>& about, bool in_turn = false) const {
    body.shift = parent.shift * Shift::about(eigen(anchor), by);
    body.centre = body.shift(start);
    const Vector3d point = parent.shift(eigen(anchor));
    body.spin = parent.spin;
    body.spin_rate = parent.spin_rate;
    for (std::size_t k = 0; k < about.size(); ++k) {
      axes.push_back({about[k], true, point});
      body.spin_rate += at.u[k] * (in_turn ? body.spin : parent.spin).cross(about[k]);
      body.spin += at.u[k] * about[k];
    }
    const Vector3d arm = body.centre - point;
    ride(point, body.velocity, body.acceleration);
    body.velocity += body.spin.cross(arm);
    body.acceleration += body.spin_rate.cross(arm) + body.spin.cross(body.spin.cross(arm));
  }
};

void fly(const JointCoordinates& at, const Vector3d& start, Moving& body, std::vector<Axis>& axes) {
  const Shift turned = Shift::about(start, turn_by({at.q[0], at.q[1], at.q[2]}));
  body.shift = Shift{Matrix3d::Identity(), {at.q[3], at.q[4], at.q[5]}} * turned;
  body.centre = body.shift(start);
  body.spin = {at.u[0], at.u[1], at.u[2]};
  body.velocity = {at.u[3], at.u[4], at.u[5]};
  for (const bool turns : {true, false}) {
    for (int k = 0; k < 3; ++k) axes.push_back({Vector3d::Unit(k), turns, body.centre});
  }
}

Matrix3d inertia_of(const Body& body, const Matrix3d& shift) {
  const Vec3 moments = body.uniform_moments_kgm2();
  Matrix3d own = eigen(moments).asDiagonal();
  if (body.inertia_kgm2)
    own = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.inertia_kgm2->data());
  const Matrix3d turned = shift * turn_by(eigen(rotation_vector(body.attitude)));
  return turned * own * turned.transpose();
}

struct CountSpeeds {
  std::size_t operator()(const BallJoint&) const { return 3; }
  std::size_t operator()(const HingeJoint&) const { return 1; }
  std::size_t operator()(const SliderJoint&) const { return 1; }
  std::size_t operator()(const UniversalJoint&) const { return 2; }
  std::size_t operator()(const FixedJoint&) const { return 0; }
  std::size_t operator()(const PistonJoint&) const { return 2; }
  std::size_t operator()(const SlidingHingeJoint&) const { return 2; }
  std::size_t operator()(const SlidingUniversalJoint&) const { return 3; }
  std::size_t operator()(const Hinge2Joint&) const { return 3; }
  std::size_t operator()(const PlaneJoint&) const { return 3; }
};

}  // namespace

std::vector<std::size_t> speeds_of(const Mechanism& mechanism, const std::vector<Branch>& tree) {
  std::vector<std::size_t> speeds(mechanism.bodies.size(), 6);
  for (const Branch& branch : tree) {
    if (branch.joint) speeds[branch.body] = std::visit(CountSpeeds{}, mechanism.joints[*branch.joint].kind);
  }
  return speeds;
}

JointSpace joint_space_of(const Mechanism& mechanism, const TreeState& state, double gravity) {
  const std::vector<Branch> tree = spanning_tree(mechanism);
  const std::vector<std::size_t> speeds = speeds_of(mechanism, tree);
  std::vector<std::size_t> first(speeds.size());
  std::exclusive_scan(speeds.begin(), speeds.end(), first.begin(), std::size_t{0});
  const auto size = static_cast<Eigen::Index>(std::reduce(speeds.begin(), speeds.end()));
  JointSpace space{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};

  std::vector<Moving> bodies(mechanism.bodies.size());
  std::vector<std::vector<Axis>> axes(mechanism.bodies.size());
  std::vector<std::optional<std::size_t>> carried_by(mechanism.bodies.size());
  const Moving world{};
  for (const Branch& branch : tree) {
    const Body& what = mechanism.bodies[branch.body];
    const Vector3d start = eigen(what.position_m);
    Moving& body = bodies[branch.body];
    carried_by[branch.body] = branch.parent;
    if (branch.joint) {
      const Joint& joint = mechanism.joints[*branch.joint];
      std::visit(Carry{branch.parent ? bodies[*branch.parent] : world, state[branch.body], start,
                       joint.first == branch.body, body, axes[branch.body]},
                 joint.kind);
    } else {
      fly(state[branch.body], start, body, axes[branch.body]);
    }
    // How each speed of the joints on the way to the world moves the body.
    Eigen::Matrix3Xd spins = Eigen::Matrix3Xd::Zero(3, size);
    Eigen::Matrix3Xd ways = Eigen::Matrix3Xd::Zero(3, size);
    for (std::optional<std::size_t> on = branch.body; on; on = carried_by[*on]) {
      for (std::size_t k = 0; k < axes[*on].size(); ++k) {
        const Axis& axis = axes[*on][k];
        const auto column = static_cast<Eigen::Index>(first[*on] + k);
        if (axis.turns) spins.col(column) = axis.direction;
        ways.col(column) = axis.turns ? axis.direction.cross(body.centre - axis.point) : axis.direction;
      }
    }
    const Matrix3d inertia = inertia_of(what, body.shift.turn);
    const Vector3d force = what.mass_kg * (body.acceleration + gravity * Vector3d::UnitZ());
    const Vector3d torque = inertia * body.spin_rate + body.spin.cross(inertia * body.spin);
    space.mass += what.mass_kg * ways.transpose() * ways + spins.transpose() * inertia * spins;
    space.bias += ways.transpose() * force + spins.transpose() * torque;
  }
  return space;
}

#ifndef ODEVAL_HAVE_SIMBODY
std::optional<JointSpace> joint_space_by_simbody(const Mechanism&, const TreeState&, double) { return std::nullopt; }
#else
std::optional<JointSpace> joint_space_by_simbody(const Mechanism& mechanism, const TreeState& state, double gravity) {
  const std::vector<Branch> tree = spanning_tree(mechanism);
  const std::vector<std::size_t> speeds = speeds_of(mechanism, tree);
  std::vector<std::size_t> branch_of(tree.size());
  for (std::size_t i = 0; i < tree.size(); ++i) branch_of[tree[i].body] = i;
  const std::unique_ptr<SimbodyTree> simbody = open_simbody_tree(mechanism, tree, gravity);
  std::vector<double> y = simbody->start();
  std::vector<std::size_t> places;  // of our speeds among Simbody's
  for (std::size_t b = 0; b < state.size(); ++b) {
    if (speeds[b] == 0) continue;
    const auto& [q, u] = state[b];
    double* const at = &y[simbody->place_of_coordinate(branch_of[b])];
    if (speeds[b] < 3) {
      std::copy_n(q.begin(), speeds[b], at);
    } else {  // a quaternion, which starts where the body stands
      const Vector3d vector{q[0], q[1], q[2]};
      const Eigen::Quaterniond start(at[0], at[1], at[2], at[3]);
      const Eigen::Quaterniond turned = Eigen::Quaterniond(turn_by(vector)) * start;
      at[0] = turned.w();
      for (int k = 0; k < 3; ++k) at[1 + k] = turned.vec()[k];
      for (std::size_t k = 3; k < speeds[b]; ++k) at[1 + k] += q[k];
    }
    for (std::size_t k = 0; k < speeds[b]; ++k) {
      y[simbody->place_of_speed(branch_of[b]) + k] = u[k];
      places.push_back(simbody->place_of_speed(branch_of[b]) + k - simbody->first_speed());
    }
  }
  const SimbodyTree::JointForces forces = simbody->joint_forces(y.data());
  const auto size = static_cast<Eigen::Index>(places.size());
  JointSpace space{Eigen::MatrixXd(size, size), Eigen::VectorXd(size)};
  for (Eigen::Index i = 0; i < size; ++i) {
    const std::size_t row = places[static_cast<std::size_t>(i)];
    space.bias[i] = forces.bias[row];
    for (Eigen::Index j = 0; j < size; ++j) {
      space.mass(i, j) = forces.mass[row * places.size() + places[static_cast<std::size_t>(j)]];
    }
  }
  return space;
}
#endif

}  // namespace odeval::reference
