// Coulomb's law on numbers: its conditions on problems made at random, some with contacts that say the same, and what
// wedges.
#include "engines/ode_rk4/friction.hpp"

#include <Eigen/Dense>
#include <cstdio>
#include <random>

#include "tests/check.hpp"

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using odeval::engine_rk4::adds_energy;
using odeval::engine_rk4::friction_work;
using odeval::engine_rk4::hold;
using odeval::engine_rk4::Rubbing;

struct Problem {
  MatrixXd a;
  VectorXd v;
  Rubbing rubbing;

  Index normals() const { return v.size() - rubbing.rows(); }
};

/// Contacts of bodies of unit mass and inertia: their rows N give A = N N', v = N u.
Problem random_problem(unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto contacts = static_cast<Index>(1 + seed % 8);
  const auto freedoms = static_cast<Index>(6 + seed % 12);
  MatrixXd rows = MatrixXd::NullaryExpr(3 * contacts, freedoms, [&] { return normal(engine); });
  if (contacts > 2 && seed % 3 == 0) {  // two that say the same
    rows.row(2) = rows.row(0);
    rows.middleRows(contacts + 4, 2) = rows.middleRows(contacts, 2);
  }
  Problem problem;
  problem.a = rows * rows.transpose();
  problem.v = rows * VectorXd::NullaryExpr(freedoms, [&] { return normal(engine); });
  for (Index i = 0; i < contacts; ++i) {
    problem.rubbing.contact.push_back(i);
    problem.rubbing.coefficient.push_back(0.01 + 1.5 * uniform(engine));
  }
  return problem;
}

/// How far from Coulomb's law, as a share of the fastest speed.
double error(const Problem& problem, const VectorXd& p) {
  const VectorXd u = problem.v + problem.a * p;
  const double fastest = problem.v.cwiseAbs().maxCoeff();
  double worst = 0;
  const auto wrong = [&](double by) { worst = std::max(worst, by / fastest); };
  for (Index i = 0; i < problem.normals(); ++i) {
    CHECK(p[i] >= -1e-12);
    wrong(-u[i]);
    if (p[i] > 0) wrong(u[i]);
  }
  for (std::size_t k = 0; k < problem.rubbing.contact.size(); ++k) {
    const Index row = problem.normals() + static_cast<Index>(2 * k);
    const Eigen::Vector2d friction = p.segment<2>(row), slip = u.segment<2>(row);
    const double most = problem.rubbing.coefficient[k] * p[problem.rubbing.contact[k]];
    CHECK_BETWEEN(friction.norm(), 0, most + 1e-9 * fastest);
    if (friction.norm() < most * (1 - 1e-6)) wrong(slip.norm());
    // It acts against the slip: slip's part along it is all of the slip.
    if (most > 1e-9) wrong((slip + slip.norm() * friction / most).norm() - 1e-6 * slip.norm());
  }
  return worst;
}

/// Nearly all are solved, and none adds energy. Far apart from each other, large coefficients leave some problems
/// without a solution that sliding leads to.
void check_random_problems() {
  constexpr unsigned count = 5000;
  int unsolved = 0;
  for (unsigned seed = 0; seed < count; ++seed) {
    const Problem problem = random_problem(seed);
    double work = friction_work;
    const VectorXd p = hold(problem.a, problem.v, problem.rubbing, VectorXd::Zero(problem.v.size()), work);
    CHECK(!adds_energy(problem.a, problem.v, p));
    if (error(problem, p) > 1e-9) ++unsolved;
  }
  std::printf("%u random problems: %d not solved to 1e-9\n", count, unsolved);
  CHECK_BETWEEN(unsolved, 0, count / 100);
}

/// Work is counted; without any there is still an answer, that costs little and adds nothing.
void check_work() {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Problem problem = random_problem(seed);
    double work = friction_work, none = 0;
    const VectorXd found = hold(problem.a, problem.v, problem.rubbing, VectorXd::Zero(problem.v.size()), work);
    CHECK(work < friction_work || found.isZero(0));  // nothing to solve where nothing closes
    const VectorXd p = hold(problem.a, problem.v, problem.rubbing, VectorXd::Zero(problem.v.size()), none);
    CHECK_EQUAL(none, 0.0);
    CHECK(p.allFinite());
  }
}

/// A rod that leans so far that sliding would press it ever harder (Painlevé): it wedges, and pushes without closing.
void check_wedge() {
  Problem problem;
  problem.a.resize(3, 3);
  problem.a << 1.45, 0, 1.39, 0, 6.4, 0, 1.39, 0, 1.64;
  problem.v = Eigen::Vector3d(-2e-6, 0, 2.4e-3);
  problem.rubbing = {{0}, {1.06}};
  double work = friction_work;
  const VectorXd p = hold(problem.a, problem.v, problem.rubbing, VectorXd::Zero(3), work);
  CHECK_NEAR((problem.v + problem.a * p).norm(), 0, 1e-12);  // it stops altogether
  CHECK(p[0] > 1e-3);
}

}  // namespace

int main() {
  check_random_problems();
  check_work();
  check_wedge();
  return odeval::test::verdict();
}
