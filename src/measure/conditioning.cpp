#include "measure/conditioning.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "measure/planar_chain.hpp"

namespace odeval {
namespace {

using Eigen::Dynamic;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Norms |A|_1 and |A^-1|_1: largest sums of a column's absolute values.
struct Norms {
  double matrix;
  double inverse;
};

double norm_1(const auto& matrix) { return matrix.cwiseAbs().colwise().sum().maxCoeff(); }

double condition_of(const Norms& norms) { return norms.matrix * norms.inverse; }

/// Of a symmetric positive definite matrix.
template <int Rows>
Norms norms_of(const Eigen::Matrix<double, Rows, Rows>& matrix) {
  using Matrix = Eigen::Matrix<double, Rows, Rows>;
  const Matrix inverse = matrix.llt().solve(Matrix::Identity(matrix.rows(), matrix.cols()));
  return {norm_1(matrix), norm_1(inverse)};
}

/// Of [A B; B^T D], symmetric positive definite, by the Schur complement of A: with blocks of 2 or 3 rows all inverses
/// are closed forms.
template <int Block>
Norms norms_of(const Eigen::Matrix<double, Block, Block>& a, const Eigen::Matrix<double, Block, Block>& b,
               const Eigen::Matrix<double, Block, Block>& d) {
  using Matrix = Eigen::Matrix<double, Block, Block>;
  const Matrix a_inverse = a.inverse();
  const Matrix ab = a_inverse * b;
  const Matrix schur_inverse = (d - b.transpose() * ab).inverse();
  const Matrix corner = ab * schur_inverse;
  const Matrix first = a_inverse + corner * ab.transpose();
  const auto columns = [](const auto& matrix) { return matrix.cwiseAbs().colwise().sum(); };
  return {std::max((columns(a) + columns(b.transpose())).maxCoeff(), (columns(b) + columns(d)).maxCoeff()),
          std::max((columns(first) + columns(corner.transpose())).maxCoeff(),
                   (columns(corner) + columns(schur_inverse)).maxCoeff())};
}

/// Of a symmetric positive definite matrix with blocks on and beside its diagonal, `beside[i]` at (i, i + 1). With
/// A = L D L^T, D and L of blocks, each block column of A^-1 is a sweep down and one up: n^2 products of blocks in all.
template <int Block>
Norms norms_of_bands(const std::vector<Eigen::Matrix<double, Block, Block>>& diagonal,
                     const std::vector<Eigen::Matrix<double, Block, Block>>& beside) {
  using Matrix = Eigen::Matrix<double, Block, Block>;
  using Sums = Eigen::Matrix<double, 1, Block>;
  const auto sums = [](const Matrix& matrix) -> Sums { return matrix.cwiseAbs().colwise().sum(); };
  const std::size_t n = diagonal.size();
  std::vector<Matrix> inverse;  // of D's blocks
  std::vector<Matrix> lower;    // L_(i+1, i)
  Norms norms{0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    Sums column = sums(diagonal[i]);
    if (i > 0) column += sums(beside[i - 1]);
    if (i + 1 < n) column += sums(beside[i].transpose());
    norms.matrix = std::max(norms.matrix, column.maxCoeff());
    Matrix pivot = diagonal[i];
    if (i > 0) pivot -= lower[i - 1] * beside[i - 1];
    inverse.push_back(pivot.inverse());
    if (i + 1 < n) lower.push_back(beside[i].transpose() * inverse[i]);
  }
  std::vector<Matrix> below(n);
  for (std::size_t j = 0; j < n; ++j) {
    below[j].setIdentity();
    for (std::size_t k = j + 1; k < n; ++k) below[k] = -lower[k - 1] * below[k - 1];
    Sums column = Sums::Zero();
    Matrix entry = Matrix::Zero();
    for (std::size_t k = n; k-- > 0;) {
      Matrix next = k >= j ? Matrix(inverse[k] * below[k]) : Matrix(Matrix::Zero());
      if (k + 1 < n) next -= lower[k].transpose() * entry;
      entry = next;
      column += sums(entry);
    }
    norms.inverse = std::max(norms.inverse, column.maxCoeff());
  }
  return norms;
}

/// Of a block diagonal matrix.
Norms together(const Norms& a, const Norms& b) {
  return {std::max(a.matrix, b.matrix), std::max(a.inverse, b.inverse)};
}

// --- generalized coordinates ---

double condition_2x2(double a, double b, double d) {
  const double column = std::max(a, d) + std::fabs(b);  // the inverse is the adjugate, with the same column sums
  return column * column / (a * d - b * b);
}

double mass_condition(const PlanarChain& chain) {
  const std::size_t n = chain.size();
  if (n == 1) return 1;
  if (n == 2) return condition_2x2(chain.mass(0, 0), chain.mass(0, 1), chain.mass(1, 1));
  Eigen::MatrixXd matrix(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) matrix(Eigen::Index(i), Eigen::Index(j)) = chain.mass(i, j);
  }
  return condition_of(norms_of<Dynamic>(matrix));
}

double manipulability_of(const PlanarChain& chain) {
  const std::size_t n = chain.size();
  if (n == 1) return 1;
  if (n == 2) {
    const double a = chain.jacobian_product(0, 0);
    const double b = chain.jacobian_product(0, 1);
    const double d = chain.jacobian_product(1, 1);
    const double largest = (a + d) / 2 + std::hypot((a - d) / 2, b);
    return (a * d - b * b) / (largest * largest);  // the least is the determinant over the largest
  }
  Eigen::MatrixXd product(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) product(Eigen::Index(i), Eigen::Index(j)) = chain.jacobian_product(i, j);
  }
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(product, Eigen::EigenvaluesOnly).eigenvalues();
  return values.minCoeff() / values.maxCoeff();
}

// --- Cartesian coordinates ---

Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// What a body resists a push and a turn with, inverted; turns about its along, its across and the hinges' axis.
struct InverseInertia {
  explicit InverseInertia(const Link& link)
      : mass(1 / link.mass_kg),
        along(1 / link.inertia_along_kgm2()),
        across(1 / link.inertia_across_kgm2()),
        hinge(1 / link.inertia_kgm2()) {}

  double mass, along, across, hinge;
};

/// J M^-1 J^T of n hinges in a row, plus the regularisation on the diagonal: what a body adds to the rows of its near
/// and its far hinge. `block(i, r1, r2)` is J_1 M_i^-1 J_2^T of body i with anchors at r1 and r2 along it.
template <int Block, class BodyBlock>
Norms chain_norms(std::size_t links, const std::vector<Link>& link, double regularisation, const BodyBlock& block) {
  using Matrix = Eigen::Matrix<double, Block, Block>;
  const auto near = [&link](std::size_t i) { return -link[i].centre_m(); };
  const auto far = [&link](std::size_t i) { return link[i].beyond_centre_m(); };
  const auto own = [&](std::size_t i) -> Matrix {
    Matrix sum = block(i, near(i), near(i));
    if (i > 0) sum += block(i - 1, far(i - 1), far(i - 1));
    sum.diagonal().array() += regularisation;
    return sum;
  };
  const auto coupling = [&](std::size_t i) -> Matrix { return -block(i, near(i), far(i)); };
  if (links == 1) return norms_of<Block>(own(0));
  if (links == 2) return norms_of<Block>(own(0), coupling(0), own(1));
  std::vector<Matrix> diagonal;
  std::vector<Matrix> beside;
  for (std::size_t i = 0; i < links; ++i) {
    diagonal.push_back(own(i));
    if (i + 1 < links) beside.push_back(coupling(i));
  }
  return norms_of_bands<Block>(diagonal, beside);
}

/// The hinges' system matrix at the recorded poses.
class HingeSystem {
 public:
  HingeSystem(const Trace& trace, const Scenario& scenario, double regularisation)
      : trace_(trace),
        links_(scenario.planar->links),
        frame_(scenario.planar->frame),
        along_body_(vector(frame_.along_body)),
        horizontal_(vector(frame_.horizontal)),
        up_(vector(frame_.up)),
        axis_(vector(frame_.axis())),
        // The report's axis is +axis() or -axis().
        hinge_body_(dot(frame_.hinge_axis, frame_.axis()) * vector(cross(frame_.along_body, frame_.across_body))),
        regularisation_(regularisation),
        poses_(links_.size()) {
    for (const Link& link : links_) inverse_.emplace_back(link);
  }

  /// Of the rows in the plane alone.
  double planar_condition(std::size_t k) {
    take_poses(k);
    return condition_of(rows_in_the_plane());
  }

  /// Of all five rows of each hinge.
  double condition(std::size_t k) {
    // A pose in the plane does not couple the rows in it with those across it.
    if (take_poses(k)) return condition_of(together(rows_in_the_plane(), rows_across_the_plane()));
    return condition_of(norms_of<Dynamic>(all_rows(k)));
  }

 private:
  struct Pose {
    double cosine;  // of the angle from `horizontal` towards `up`
    double sine;
  };

  Matrix3d rotation(std::size_t link, std::size_t k) const {
    const auto& columns = trace_.bodies[link].rotation;
    Matrix3d matrix;
    for (std::size_t d = 0; d < 9; ++d) matrix(Eigen::Index(d / 3), Eigen::Index(d % 3)) = columns[d][k];
    return matrix;
  }

  // True when every body's turn leaves the hinges' axis exactly where it is.
  bool take_poses(std::size_t k) {
    bool planar = true;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const Matrix3d turn = rotation(i, k);
      const Vector3d along = turn * along_body_;
      poses_[i] = {along.dot(horizontal_), along.dot(up_)};
      planar = planar && along.dot(axis_) == 0 && (turn * hinge_body_).cross(axis_).isZero(0);
    }
    return planar;
  }

  // Two rows a hinge: the anchors' distance along `horizontal` and `up`.
  Norms rows_in_the_plane() const {
    return chain_norms<2>(links_.size(), links_, regularisation_, [this](std::size_t i, double r1, double r2) {
      const Vector2d across(-poses_[i].sine, poses_[i].cosine);
      return Matrix2d(inverse_[i].mass * Matrix2d::Identity() +
                      r1 * r2 * inverse_[i].hinge * across * across.transpose());
    });
  }

  // Three rows a hinge: the anchors' distance along the axis, and the turns about `horizontal` and `up` that the axes
  // must share. An anchor at r along the body moves out of the plane with v - r w_across.
  Norms rows_across_the_plane() const {
    return chain_norms<3>(links_.size(), links_, regularisation_, [this](std::size_t i, double r1, double r2) {
      const auto& [mass, along, across, hinge] = inverse_[i];
      const auto [c, s] = poses_[i];
      const double mixed = c * s * (along - across);
      Matrix3d block;
      block << mass + r1 * r2 * across, r1 * across * s, -r1 * across * c,  //
          r2 * across * s, c * c * along + s * s * across, mixed,           //
          -r2 * across * c, mixed, s * s * along + c * c * across;
      return block;
    });
  }

  /// ODE's dxPlaneSpace: two unit vectors that with the unit vector n make a frame.
  static std::array<Vector3d, 2> plane_space(const Vector3d& n) {
    Vector3d p = std::fabs(n[2]) > std::sqrt(0.5) ? Vector3d(0, -n[2], n[1]) : Vector3d(-n[1], n[0], 0);
    p.normalize();
    return {p, n.cross(p)};
  }

  // Five rows a hinge in space. Columns of J: velocity and spin of each body.
  Eigen::MatrixXd all_rows(std::size_t k) const {
    const auto n = static_cast<Eigen::Index>(links_.size());
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(5 * n, 6 * n);
    Eigen::MatrixXd inverse_mass = Eigen::MatrixXd::Zero(6 * n, 6 * n);
    std::vector<Matrix3d> turns;
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto link = static_cast<std::size_t>(i);
      turns.push_back(rotation(link, k));
      Matrix3d axes;
      axes << along_body_, vector(frame_.across_body), along_body_.cross(vector(frame_.across_body));
      axes = turns.back() * axes;
      const InverseInertia& inverse = inverse_[link];
      inverse_mass.block<3, 3>(6 * i, 6 * i) = inverse.mass * Matrix3d::Identity();
      inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) =
          axes * Vector3d(inverse.along, inverse.across, inverse.hinge).asDiagonal() * axes.transpose();

      const Vector3d n0 = turns[link == 0 ? 0 : link - 1] * hinge_body_;  // of ODE's first body: the parent, if any
      const std::array<Vector3d, 2> pq = plane_space(n0);
      const auto attach = [&](Eigen::Index body, double sign, double at) {
        const Vector3d anchor = at * (turns[static_cast<std::size_t>(body)] * along_body_);
        auto rows = jacobian.block<5, 6>(5 * i, 6 * body);
        for (Eigen::Index d = 0; d < 3; ++d) {
          rows(d, d) = sign;
          rows.block<1, 3>(d, 3) = sign * anchor.cross(Vector3d::Unit(d)).transpose();
        }
        for (Eigen::Index d = 0; d < 2; ++d) {
          rows.block<1, 3>(3 + d, 3) = sign * pq[static_cast<std::size_t>(d)].transpose();
        }
      };
      attach(i, 1, -links_[link].centre_m());
      if (i > 0) attach(i - 1, -1, links_[link - 1].beyond_centre_m());
    }
    Eigen::MatrixXd system = jacobian * inverse_mass * jacobian.transpose();
    system.diagonal().array() += regularisation_;
    return system;
  }

  const Trace& trace_;
  const std::vector<Link>& links_;
  const PlanarFrame& frame_;
  Vector3d along_body_;
  Vector3d horizontal_;
  Vector3d up_;
  Vector3d axis_;
  Vector3d hinge_body_;
  double regularisation_;
  std::vector<InverseInertia> inverse_;
  std::vector<Pose> poses_;
};

}  // namespace

void add_conditioning(Trace& trace, const Scenario& scenario, SystemMatrix matrix) {
  const std::size_t rows = trace.rows();
  PlanarChain chain(scenario.planar->links);
  const bool generalized = matrix == SystemMatrix::mass_matrix;
  trace.manipulability.resize(rows);
  if (generalized) trace.condition.resize(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    chain.pose(trace.q, k);
    trace.manipulability[k] = manipulability_of(chain);
    if (generalized) trace.condition[k] = mass_condition(chain);
  }
  if (generalized || matrix == SystemMatrix::none) return;

  const bool planar = matrix == SystemMatrix::planar_joints;
  const double cfm = scenario.ode.softness(scenario.step_s).cfm;
  HingeSystem system(trace, scenario, matrix == SystemMatrix::hinge_rows_cfm ? cfm / scenario.step_s : 0);
  trace.condition.resize(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    trace.condition[k] = planar ? system.planar_condition(k) : system.condition(k);
  }
}

}  // namespace odeval
