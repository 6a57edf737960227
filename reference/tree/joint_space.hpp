#pragma once
// The equations of motion of a tree of bodies at one state, in the coordinates of its joints: M du/dt + b = 0 without
// forces along the joints. From three sources that share no code: bodies and joints as something holds them, Simbody,
// and KDL, which is given a robot as its file says it.
#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/robot.hpp"
#include "reference/tree/spanning_tree.hpp"

namespace odeval::reference {

/// Where a body's joint stands, from t = 0, and its speeds: the body against what carries it, about or along the axis.
/// Of a universal joint about the parent's axis and then about its own; of a ball a rotation vector, and the spin along
/// the parent's axes, which were the world's at t = 0; of a free body the same, then the way and the velocity of its
/// centre in the world.
struct JointCoordinates {
  std::array<double, 6> q{};
  std::array<double, 6> u{};
};
/// One a body, by its number.
using TreeState = std::vector<JointCoordinates>;

/// By the numbers of bodies, and of each by its speeds.
struct JointSpace {
  Eigen::MatrixXd mass;  // M
  Eigen::VectorXd bias;  // b
};

/// How many speeds a body has against what carries it.
std::vector<std::size_t> speeds_of(const Mechanism& mechanism, const std::vector<Branch>& tree);

/// By the kinematics of its own joints, from its own bodies, gravity along -z.
JointSpace joint_space_of(const Mechanism& mechanism, const TreeState& state, double gravity);
/// By Simbody; nothing in a build without it. Throws MachineError when it can not be loaded.
std::optional<JointSpace> joint_space_by_simbody(const Mechanism& mechanism, const TreeState& state, double gravity);
/// By KDL, of the robot that a mechanism was made of; `body_of` are the numbers of its links' bodies. Of the mechanism
/// the order of coordinates, and the places of free bodies' centres. Throws std::domain_error where KDL gives up.
JointSpace joint_space_by_kdl(const Robot& robot, const std::vector<std::optional<std::size_t>>& body_of,
                              const Mechanism& mechanism, const TreeState& state, double gravity);

}  // namespace odeval::reference
