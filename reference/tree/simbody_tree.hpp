#pragma once
// A tree of bodies in Simbody, and the loops that joints close in it, which is loaded when the first is wanted. Its
// headers are C++17 (in C++20 they are ambiguous), so is what stands here and beside it, and nothing that includes them
// is included elsewhere.
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "odeval/mechanism.hpp"
#include "reference/closed_form/rotation.hpp"
#include "reference/tree/spanning_tree.hpp"

namespace odeval::reference {

/// Where a body is and how it moves, in the world.
struct Placed {
  Vec3 position_m{};  // of the centre of mass
  Rotation rotation{};
  Vec3 velocity_m_s{};  // likewise
  Vec3 spin_rad_s{};
  double first_coordinate = 0;  // of what it hangs on: a hinge's angle from t = 0, rad; 0 where there is none
};

/// How a state keeps loops closed. Speeds are in their order in a state.
struct Closure {
  double error = 0;      // the largest part by which a loop is open, m or rad
  Eigen::VectorXd mend;  // speeds that would close all within 1 s, the least ones that do
  Eigen::MatrixXd free;  // speeds that loops allow: unit columns, at right angles to each other
  bool implied = false;  // some of what loops hold follows from the rest
  /// How much the least of what holds still holds, of the most: 0 where loops may branch off.
  double margin = 1;
  /// By how much coordinates move, at the most, for what is open: the inverse of that least.
  double gain = 0;
};

/// The state is what Simbody calls Q and U, one after the other. A joint that closes a loop hangs a second part of its
/// body on the tree, which shares the body's mass and is welded to it.
class SimbodyTree {
 public:
  virtual ~SimbodyTree() = default;

  /// "3.7"
  virtual std::string version() const = 0;

  /// At t = 0. Of the velocities of the bodies those that the joints allow.
  virtual const std::vector<double>& start() const = 0;

  /// Where the one coordinate of a branch's joint, and its speed, stand in a state; of hinges and sliders.
  virtual std::size_t place_of_coordinate(std::size_t branch) const = 0;
  virtual std::size_t place_of_speed(std::size_t branch) const = 0;
  virtual std::size_t first_speed() const = 0;
  /// A motion of a branch's joint in a state.
  struct Motion {
    std::size_t coordinate;
    std::size_t speed;
  };
  /// Of the ones of a joint with several that may be driven (driveable_of).
  virtual Motion place_of_motion(std::size_t branch, std::size_t motion) const = 0;
  /// A force along the coordinate whose speed stands there, N m or N, from now on.
  virtual void push(std::size_t speed, double force) = 0;
  /// A direction that is fixed in a body, in the world.
  virtual Vec3 direction(const double* y, std::size_t body, const Vec3& at_start) = 0;
  /// What a unit impulse along the coordinate whose speed stands there adds to all speeds, in their order in a state;
  /// stays until the next call.
  virtual const std::vector<double>& kick(const double* y, std::size_t speed) = 0;

  /// What a unit impulse in a direction does at a point of a body, and its opposite at that point of another one, if
  /// there is one.
  struct Impulse {
    std::vector<double> along;   // of all speeds: how fast they move the point that way
    std::vector<double> gained;  // by all speeds
  };
  virtual Impulse impulse(const double* y, std::size_t body, std::optional<std::size_t> other, const Vec3& point,
                          const Vec3& direction) = 0;

  /// dy/dt, of a state whose loops are closed.
  virtual void slope(const double* y, double* dydt) = 0;
  /// Where there are loops; stays until the next call.
  virtual const Closure& closure(const double* y) = 0;
  /// Gives all quaternions of a state the length 1, whatever length they have.
  virtual void normalize(double* y) = 0;
  /// The rates of all coordinates at the coordinates of a state and any speeds.
  virtual Eigen::VectorXd rates(const double* y, const Eigen::VectorXd& speeds) = 0;
  /// By the numbers of bodies; stays until the next call.
  virtual const std::vector<Placed>& bodies(const double* y) = 0;
  /// At t = 0, with the speeds that weights, gyroscopic torques and pushes alone would have given after dt, s.
  virtual const std::vector<Placed>& pushed(double dt) = 0;
  /// The force of each branch's joint on its body, N, world frame; stays until the next call. Where loops hold more
  /// than they need to, one of many ways to share it.
  virtual const std::vector<Vec3>& forces(const double* y) = 0;

  /// The matrix of all speeds in their order in a state, by rows, and the forces that keep their rates at 0.
  struct JointForces {
    std::vector<double> mass;
    std::vector<double> bias;
  };
  virtual JointForces joint_forces(const double* y) = 0;
};

/// The tree is the mechanism's, whose joints start closed; its branches have their places there as numbers. Loads
/// Simbody, which takes longer than most runs and brings BLAS with threads of its own. Throws MachineError when it can
/// not be loaded.
std::unique_ptr<SimbodyTree> open_simbody_tree(const Mechanism& mechanism, const std::vector<Branch>& tree,
                                               double gravity);

}  // namespace odeval::reference
