#pragma once
// Coulomb's law on numbers alone: what impulses hold contacts whose speeds answer to impulses p with v + A p (A
// symmetric, positive semidefinite). The first rows are the normals, then come two rows for each contact that rubs,
// across its normal, and last one for each motor, whose speed is what it is beside its own: a motor within its limits
// is friction of a constant bound, in one dimension.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace odeval::engine_rk4 {

struct Rubbing {
  std::vector<Eigen::Index> contact;  // of each two rows
  std::vector<double> coefficient;    // likewise, > 0
  struct Limits {
    double least, most;  // of an impulse; 0 is one of those between
  };
  std::vector<Limits> limits = {};  // of each motor

  Eigen::Index rows() const { return motors_at() + static_cast<Eigen::Index>(limits.size()); }
  /// Where they begin among these rows.
  Eigen::Index motors_at() const { return static_cast<Eigen::Index>(2 * contact.size()); }
};

/// Cubes of the rows of the matrices that Newton's method may solve: a millisecond or two. Counted, so that what bounds
/// the work hangs on no clock.
constexpr double friction_work = 5e6;

/// Nothing closes, normal impulses only push, and friction is in its round cone: where it is inside it nothing slides,
/// else it acts against what does; a motor has its speed, or gives what it can towards it. `p` is where to begin. Where
/// contacts say the same each gets the same share on top of that, as soft ground would have it: friction feels the
/// shares. Not always solved; see `adds_energy`. `work`: what is left of it; without any, it is solved in part.
Eigen::VectorXd hold(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Rubbing& rubbing, Eigen::VectorXd p,
                     double& work);

/// Friction alone at contacts that push so much: the impulses in their discs that leave the least energy.
Eigen::VectorXd rub(const Eigen::MatrixXd& a, const Eigen::VectorXd& speeds, const Rubbing& rubbing,
                    const Eigen::VectorXd& normal, Eigen::VectorXd p);

/// Beyond rounding, or perhaps: of impulses that cancel each other so nearly that nobody knows.
bool adds_energy(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Eigen::VectorXd& p);

}  // namespace odeval::engine_rk4
