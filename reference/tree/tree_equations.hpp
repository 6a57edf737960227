#pragma once
// Equations of motion of a tree of bodies in generalized coordinates: Simbody's, which take time in proportion to the
// number of bodies.
#include <memory>
#include <span>
#include <vector>

#include "odeval/motion.hpp"
#include "odeval/scenario.hpp"
#include "reference/tree/spanning_tree.hpp"

namespace odeval::reference {

class SimbodyTree;

/// The state is what Simbody calls Q and U, one after the other: angles of hinges and universal joints (rad, 0 at t =
/// 0, without jumps), ways of sliders (m), quaternions of balls and of free bodies (whose length says nothing), places
/// of free bodies (m); then the speeds that belong to them.
class TreeEquations {
 public:
  /// The mechanism is a tree (spanning_tree.hpp) of closed joints. Of its start the velocities that the joints allow.
  explicit TreeEquations(const Scenario& scenario);
  ~TreeEquations();

  /// Numbers in a state.
  std::size_t size() const { return start().size(); }
  /// The state at t = 0.
  const std::vector<double>& start() const;

  /// dy/dt
  void operator()(const double* y, double* dydt) const;

  /// The bodies in the world. Of links in a plane with their angles.
  void show(const double* y, std::span<BodyState> bodies) const;
  /// The force of each joint on the body that it carries.
  void forces(const double* y, std::span<JointState> joints) const;

 private:
  std::vector<Joint> joints_;
  std::shared_ptr<const PlanarView> planar_;
  std::vector<Branch> tree_;
  std::unique_ptr<SimbodyTree> simbody_;
};

}  // namespace odeval::reference
