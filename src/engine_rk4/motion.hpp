#pragma once
// Newton-Euler with Lagrange multipliers, classical Runge-Kutta, and the projection onto the joints.
//
//   M u' = f + J' lambda,  J u' + bias = 0   =>   (J M^-1 J') lambda = -(J M^-1 f + bias)
//
// One step: four stages; then positions move by -M^-1 J' A^-1 C and velocities by -M^-1 J' A^-1 J u, A = J M^-1 J' at
// the end of the step: the nearest state, weighted by mass, that keeps the joints (to the second order in what is
// corrected, which is itself of fifth order in the step).
#include <array>
#include <vector>

#include "engine_rk4/block_ldl.hpp"
#include "engine_rk4/mechanism.hpp"

namespace odeval::engine_rk4 {

struct Wrench {
  Vector3d force;
  Vector3d torque;
};

/// dy/dt of one body.
struct Rate {
  Vector3d position;
  Eigen::Vector4d turn;
  Twist twist;
};

class Motion {
 public:
  explicit Motion(Mechanism mechanism);

  const Mechanism& mechanism() const { return mechanism_; }

  /// A state moved by h under constant forces (gravity included), joints kept. Returns the largest joint error that it
  /// started from (m, rad).
  double step(const State& from, const std::vector<Wrench>& forces, double h, State& to);

  /// Moves poses onto the joints until the corrections are of rounding size, at most `most` times, then velocities.
  /// Returns the largest joint error found at first (m, rad).
  double project(State& state, int most);

  /// The change of all velocities that impulses (N s, N m s) on bodies make, joints kept, at the pose of the last
  /// `project` or `step`.
  void respond(const std::vector<Wrench>& impulses, std::vector<Twist>& change);

  /// Moves poses by small displacements (m, rad), then keeps the joints.
  void displace(const std::vector<Twist>& by, State& state);

  /// Of a joint on its first and on its second body: J' lambda in N and N m about the body's centre, as the last
  /// stage of the last step had it.
  Wrench force_on_a(std::size_t joint) const { return force(rows_of_stage_[joint].of_a, joint); }
  Wrench force_on_b(std::size_t joint) const { return force(rows_of_stage_[joint].of_b, joint); }

 private:
  Wrench force(const Matrix6& row, std::size_t joint) const;
  void look(const State& state);  // rotation matrices, inertias, rows
  double largest_error() const;   // of the rows, m or rad
  void factor();                  // the matrix of the rows
  void accelerate(const State& state, const std::vector<Wrench>& forces);
  void solve_onto(std::vector<Twist>& twists);  // twists -= M^-1 J' A^-1 (J twists + right-hand side in lambda_)

  Mechanism mechanism_;
  BlockLdl matrix_;
  std::vector<Matrix3d> turns_;
  std::vector<Matrix3d> inverse_inertias_;  // world frame
  std::vector<JointRows> rows_;
  std::vector<JointRows> rows_of_stage_;
  std::vector<std::array<Matrix6, 2>> weighted_;  // J M^-1 of a joint's two bodies
  std::vector<Vector6> lambda_;
  std::vector<Vector6> stage_lambda_;
  std::vector<Twist> acceleration_;
  std::vector<Twist> correction_;
  State stage_;
  std::vector<Rate> sum_;
};

}  // namespace odeval::engine_rk4
