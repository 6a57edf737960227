#pragma once
// Linear complementarity: which contacts push, and how much.
#include <Eigen/Core>
#include <vector>

namespace odeval::engine_rk4 {

/// p >= 0, A p + b >= 0, p (A p + b) = 0 for a positive semidefinite A, by an active set (Lawson & Hanson, Solving
/// Least Squares Problems, 1974, chapter 23, on the normal equations): exact to rounding after as many rounds as
/// contacts push. Where several contacts say the same, A p is unique and p is not; as few as possible get a share. Rows
/// that nothing can satisfy (b asks both jaws of a vice to give way) are left as they are.
Eigen::VectorXd complementary(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& guess = {});

/// Whether impulses on what moves at speeds v take far more energy away than the rounding of it: then they are no
/// rounding, however large they are, as those of what bears many times its own mass.
bool takes_energy(const Eigen::MatrixXd& a, const Eigen::VectorXd& v, const Eigen::VectorXd& p);

/// Rows that have a part in each other, directly or through others.
std::vector<std::vector<Eigen::Index>> coupled(const Eigen::MatrixXd& a);

}  // namespace odeval::engine_rk4
