#pragma once
// A mechanism's tree as a system of Simbody's: its bodies, what acts on them, and the loops that are closed in it.
// C++17, as simbody_tree.hpp.
#include <Simbody.h>

#include <Eigen/Core>
#include <Eigen/QR>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "odeval/mechanism.hpp"
#include "reference/tree/simbody_joints.hpp"
#include "reference/tree/simbody_tree.hpp"
#include "reference/tree/spanning_tree.hpp"

namespace odeval::reference {

/// A speed, and of each loop that it may change the first equation.
struct LoopsOfSpeed {
  int speed;
  std::vector<int> first_equations;
};

/// The speeds that loops allow, at the coordinates of the last state that was asked for.
struct Loops {
  int equations = 0;                                        // 0: there are none
  std::vector<std::array<SimTK::MobilizedBody, 2>> welded;  // by loops: the two that have to be one
  /// The speeds that change a loop, in groups of which no two change the same one: one product of the constraints'
  /// Jacobian tells what each of a group does.
  std::vector<std::vector<LoopsOfSpeed>> apart;
  /// How many of them no others imply: as at t = 0. Where loops are not quite closed those that are implied look as if
  /// they were not.
  Eigen::Index rank = -1;
  std::vector<double> coordinates;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors;  // of the constraints' Jacobian, turned over
  Closure closure;

  /// The least speeds that change what the constraints hold by this.
  Eigen::VectorXd least(const Eigen::VectorXd& change) const;
};

struct SimbodySystem {
  Mechanism mechanism;
  std::vector<Branch> tree;
  double gravity;
  SimTK::MultibodySystem all;
  SimTK::SimbodyMatterSubsystem matter{all};
  SimTK::GeneralForceSubsystem loads{all};
  std::optional<SimTK::Force::DiscreteForces> pushes;  // where anything pushes
  std::vector<Chain> hung;                             // by branches
  std::vector<SimTK::MobilizedBody> bodies;            // by their numbers in the mechanism
  std::vector<std::pair<SimTK::MobilizedBody, SimTK::MobilizerUIndex>>
      moved_by;  // the body and the number of each speed
  SimTK::State state;
  SimTK::Vector_<SimTK::SpatialVec> reactions;
  Loops loops;

  SimbodySystem(Mechanism of, std::vector<Branch> order, double pull);

  /// To a stage of a state, which is what Simbody calls Y.
  void realize(const double* y, SimTK::Stage stage);

  const SimTK::MobilizedBody& body_of(std::size_t branch) const { return hung[branch].bodies.back(); }
  int place_of_speed(std::size_t branch) const { return int(body_of(branch).getFirstUIndex(state)); }

  /// Of the state that was realized last, to velocities.
  void find_loops();
  /// What each speed does to the loops' equations, by rows.
  Eigen::MatrixXd jacobian_of_loops() const;

  /// Accelerations that keep loops closed: `least`, which are the least ones that do where nothing else acts, and what
  /// the forces add that those leave over.
  SimTK::Vector accelerate(const Eigen::VectorXd& least, const SimTK::Vector& along,
                           const SimTK::Vector_<SimTK::SpatialVec>& on_bodies) const;

  /// What forces along all speeds do to them, as far as loops allow.
  Eigen::VectorXd freely(const Eigen::VectorXd& forces) const;

  /// What an impulse along all speeds adds to them, in the state that was realized last, to velocities.
  SimTK::Vector gained_by(const SimTK::Vector& impulse);

 private:
  SimTK::Transform place_of_parent(const Branch& branch) const;
  double parts_of(std::size_t body) const;
  void add(const Branch& branch);
  void add(const Strut& strut);
  void sort_speeds_by_loops();
  void set_speed(const Branch& branch, const Chain& chain);
};

}  // namespace odeval::reference
