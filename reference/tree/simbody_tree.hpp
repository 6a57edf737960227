#pragma once
// A tree of bodies in Simbody, which is loaded when the first is wanted. Its headers are C++17 (in C++20 they are
// ambiguous), so is what stands here and beside it, and nothing that includes them is included elsewhere.
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

/// The state is what Simbody calls Q and U, one after the other.
class SimbodyTree {
 public:
  virtual ~SimbodyTree() = default;

  /// "3.7"
  virtual std::string version() const = 0;

  /// At t = 0. Of the velocities of the bodies those that the joints allow.
  virtual const std::vector<double>& start() const = 0;

  /// Where the one coordinate of what a body hangs on, and its speed, stand in a state; of hinges and sliders.
  virtual std::size_t place_of_coordinate(std::size_t body) const = 0;
  virtual std::size_t place_of_speed(std::size_t body) const = 0;
  virtual std::size_t first_speed() const = 0;
  /// A force along that coordinate, N m or N, from now on.
  virtual void push(std::size_t body, double force) = 0;
  /// Where that of a slider leads, in the world.
  virtual Vec3 direction(const double* y, std::size_t body, const Vec3& axis_at_start) = 0;
  /// What a unit impulse along it adds to all speeds, in their order in a state; stays until the next call.
  virtual const std::vector<double>& kick(const double* y, std::size_t body) = 0;

  /// What a unit impulse in a direction does at a point of a body, and its opposite at that point of another one, if
  /// there is one.
  struct Impulse {
    std::vector<double> along;   // of all speeds: how fast they move the point that way
    std::vector<double> gained;  // by all speeds
  };
  virtual Impulse impulse(const double* y, std::size_t body, std::optional<std::size_t> other, const Vec3& point,
                          const Vec3& direction) = 0;

  /// dy/dt
  virtual void slope(const double* y, double* dydt) = 0;
  /// By the numbers of bodies; stays until the next call.
  virtual const std::vector<Placed>& bodies(const double* y) = 0;
  /// At t = 0, with the speeds that weights, gyroscopic torques and pushes alone would have given after dt, s.
  virtual const std::vector<Placed>& pushed(double dt) = 0;
  /// The force of what each body hangs on, on it, N, world frame; stays until the next call.
  virtual const std::vector<Vec3>& forces(const double* y) = 0;

  /// The matrix of all speeds in their order in a state, by rows, and the forces that keep their rates at 0.
  struct JointForces {
    std::vector<double> mass;
    std::vector<double> bias;
  };
  virtual JointForces joint_forces(const double* y) = 0;
};

/// The tree is the mechanism's, whose joints start closed. Loads Simbody, which takes longer than most runs and brings
/// BLAS with threads of its own. Throws MachineError when it can not be loaded.
std::unique_ptr<SimbodyTree> open_simbody_tree(const Mechanism& mechanism, const std::vector<Branch>& tree,
                                               double gravity);

}  // namespace odeval::reference
