#pragma once
// Coulomb's law on numbers alone: what impulses hold contacts whose speeds answer to impulses p with v + A p (A
// symmetric, positive semidefinite). The first rows are the normals, then come two rows for each contact that rubs,
// across its normal.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace odeval::engine_rk4 {

struct Rubbing {
  std::vector<Eigen::Index> contact;  // of each two rows
  std::vector<double> coefficient;    // likewise, > 0

  Eigen::Index rows() const { return static_cast<Eigen::Index>(2 * contact.size()); }
};

/// Nothing closes, normal impulses only push, and friction is in its round cone: where it is inside it nothing slides,
/// else it acts against what does. `p` is where to begin. Where contacts say the same each gets the same share on top
/// of that, as soft ground would have it: friction feels the shares. Not always solved; see `adds_energy`.
Eigen::VectorXd hold(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Rubbing& rubbing, Eigen::VectorXd p);

/// Friction alone at contacts that push so much: the impulses in their discs that leave the least energy.
Eigen::VectorXd rub(const Eigen::MatrixXd& a, const Eigen::VectorXd& speeds, const Rubbing& rubbing,
                    const Eigen::VectorXd& normal, Eigen::VectorXd p);

/// Beyond rounding.
bool adds_energy(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Eigen::VectorXd& p);

}  // namespace odeval::engine_rk4
