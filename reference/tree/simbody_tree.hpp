#pragma once
// A tree of bodies in Simbody. Its headers are C++17 (in C++20 they are ambiguous), so is what stands here and beside
// it, and nothing that includes them is included elsewhere.
#include <memory>
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
  /// The tree is the mechanism's, whose joints start closed.
  SimbodyTree(const Mechanism& mechanism, std::vector<Branch> tree, double gravity);
  ~SimbodyTree();

  /// "3.7"
  static std::string version();

  /// At t = 0. Of the velocities of the bodies those that the joints allow.
  const std::vector<double>& start() const { return start_; }

  /// Where the one coordinate of what a body hangs on, and its speed, stand in a state; of hinges and sliders.
  std::size_t place_of_coordinate(std::size_t body) const;
  std::size_t first_speed() const;
  std::size_t place_of_speed(std::size_t body) const;
  /// A force along that coordinate, N m or N, from now on.
  void push(std::size_t body, double force);
  /// What a unit impulse along it adds to all speeds, in their order in a state; stays until the next call.
  const std::vector<double>& kick(const double* y, std::size_t body);

  /// dy/dt
  void slope(const double* y, double* dydt);
  /// By the numbers of bodies; stays until the next call.
  const std::vector<Placed>& bodies(const double* y);
  /// At t = 0, with the speeds that weights, gyroscopic torques and pushes alone would have given after dt, s.
  const std::vector<Placed>& pushed(double dt);
  /// The force of what each body hangs on, on it, N, world frame; stays until the next call.
  const std::vector<Vec3>& forces(const double* y);

 private:
  struct System;
  std::unique_ptr<System> system_;
  std::vector<double> start_;
  std::vector<Placed> bodies_;
  std::vector<Vec3> forces_;
  std::vector<double> kick_;
};

}  // namespace odeval::reference
