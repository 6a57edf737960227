// Complementarity: what it promises, on systems made at random, most of them with contacts that say the same.
#include "engines/ode_rk4/complementarity.hpp"

#include <Eigen/Dense>
#include <random>

#include "tests/check.hpp"

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using odeval::engine_rk4::complementary;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [this] { return std::normal_distribution<double>()(engine_); });
  }

 private:
  std::mt19937 engine_;
};

/// N contacts on as many degrees of freedom, or fewer: then some repeat others. b as impacts make it, N u.
void check_conditions(unsigned seed, Eigen::Index contacts, Eigen::Index freedoms) {
  Random random(seed);
  MatrixXd normals = random.matrix(contacts, freedoms);
  if (contacts > 3) normals.row(contacts - 1) = normals.row(0);  // twice the same
  const VectorXd b = normals * random.matrix(freedoms, 1);
  const MatrixXd a = normals * normals.transpose();
  const VectorXd p = complementary(a, b);
  const VectorXd w = a * p + b;
  const double size = b.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < contacts; ++i) {
    CHECK(p[i] >= 0);
    CHECK(w[i] >= -1e-10 * size);
    CHECK(std::fabs(p[i] * w[i]) <= 1e-9 * size * (1 + p.maxCoeff()));
  }
  // What bodies feel is unique: the same contacts in another order.
  const VectorXd other = complementary(a.reverse(), b.reverse());
  CHECK_NEAR((a * (other.reverse() - p)).cwiseAbs().maxCoeff(), 0, 1e-9 * size);
}

/// Four corners of a plate of which one more than a plane allows is deeper: the fourth has to take over.
void check_exchange() {
  MatrixXd normals(4, 3);
  normals << 1, 1, 1, 1, -1, 1, 1, -1, -1, 1, 1, -1;  // lift and two tilts
  const MatrixXd a = normals * normals.transpose();
  for (int deep = 0; deep < 4; ++deep) {
    VectorXd b = VectorXd::Constant(4, -1);
    b[deep] = -2;
    const VectorXd p = complementary(a, b);
    const VectorXd w = a * p + b;
    for (int i = 0; i < 4; ++i) CHECK(p[i] >= 0 && w[i] >= -1e-12 && std::fabs(p[i] * w[i]) < 1e-12);
  }
}

/// What nothing can satisfy ends, with numbers: both jaws of a vice, and a direction that joints hold.
void check_hopeless() {
  MatrixXd vice(2, 2);
  vice << 1, -1, -1, 1;
  const VectorXd p = complementary(vice, VectorXd::Constant(2, -1));
  CHECK(p.allFinite() && (p.array() >= 0).all());
  CHECK_EQUAL(complementary(MatrixXd::Zero(1, 1), VectorXd::Constant(1, -1))[0], 0.0);
  CHECK_EQUAL(complementary(MatrixXd::Identity(1, 1), VectorXd::Constant(1, 1))[0], 0.0);
  CHECK_EQUAL(complementary(MatrixXd::Identity(1, 1), VectorXd::Constant(1, -3))[0], 3.0);
  CHECK_EQUAL(complementary(MatrixXd(0, 0), VectorXd(0)).size(), Eigen::Index{0});
}

}  // namespace

int main() {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    check_conditions(seed, 4, 6);
    check_conditions(seed, 8, 3);
    check_conditions(seed, 40, 24);
  }
  check_exchange();
  check_hopeless();
  return odeval::test::verdict();
}
