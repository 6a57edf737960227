#pragma once
// Linear complementarity problem with a box, for symmetric positive definite matrices.
#include <Eigen/Core>
#include <vector>

namespace odeval::reference::maximal {

/// Finds x and w with A x = b + w, lo <= x <= hi, and for each row one of
///
///   w = 0 with x anywhere in its box,   x = lo with w >= 0,   x = hi with w <= 0.
///
/// Murty's least-index pivoting, which ends for every positive definite A (K.G. Murty, Note on a Bard-type scheme for
/// solving the complementarity problem, Opsearch 11, 1974; for boxes, Judice and Pires 1992). A row without bounds is
/// always free, so that with unbounded rows alone this is one factorization A = L D L^T without pivoting.
class BoxLcp {
 public:
  /// Room for problems of up to so many rows. Solving one allocates nothing.
  void reserve(Eigen::Index rows);

  /// Uses the first `rows` rows of each. False when rounding kept the pivoting from ending; x is then the last try.
  bool solve(Eigen::Index rows, const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& lo,
             const Eigen::VectorXd& hi, Eigen::VectorXd& x);

 private:
  enum class Place { free, at_lo, at_hi };

  void solve_free(Eigen::Index rows, const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& x);
  bool move_one(Eigen::Index rows, const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& lo,
                const Eigen::VectorXd& hi, Eigen::VectorXd& x);

  std::vector<Place> place_;
  std::vector<Eigen::Index> free_;  // numbers of the free rows
  Eigen::MatrixXd factor_;          // of the free rows: L below the diagonal, D on it
  Eigen::VectorXd right_;
};

}  // namespace odeval::reference::maximal
