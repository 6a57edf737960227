// The state-transition matrix that CVODES carries against four truths: products of short steps of the variational
// equations, differences of perturbed runs, Liouville's theorem, and the single pendulum's closed form.
#include "reference/planar/sensitivity.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "odeval/error.hpp"
#include "reference/closed_form/analytic.hpp"
#include "reference/dh/dh_chain.hpp"
#include "reference/planar/cvode.hpp"
#include "reference/planar/error_spread.hpp"
#include "tests/check.hpp"
#include "tests/recorded.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;

constexpr double spacing = 0.1;  // s, of the rows
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Square matrix_at(const Sensitivity& sensitivity, std::size_t row) {
  const auto size = static_cast<Eigen::Index>(2 * sensitivity.q.size());
  return Eigen::Map<const Square>(sensitivity.transition[row].data(), size, size);
}

Sensitivity sensitivity_of(const Scenario& scenario) {
  return solve_sensitivity(scenario, {spacing, 1, std::lround(scenario.duration_s / spacing) + 1});
}

Motion motion_of(MakeSimulation make, const Scenario& scenario, double step) {
  return test::recorded(make, scenario, {step, 1, std::lround(scenario.duration_s / step) + 1}).motion;
}

Scenario double_pendulum() {
  Scenario scenario = test::report_scenario("double_pendulum", 10.0, 1e-3);
  change_planar(scenario, [](PlanarView& view) { view.qd0 = {0.3, -0.5}; });
  return scenario;
}

// Short steps of h have an error of order h^2 over a fixed time (J at the state half way), so two step sizes tell
// where they lead.
void check_short_steps() {
  Scenario scenario = double_pendulum();
  scenario.duration_s = 6;  // later, P changes by more than that over the error of the motion itself
  const Sensitivity sensitivity = sensitivity_of(scenario);
  const FreeMotion<2> motion(scenario);
  const auto product_of_steps = [&](double h) {
    const Motion moved = motion_of(make_cvode, scenario, h / 2);
    std::vector<Matrix<4>> at_rows{{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}};
    Matrix<4> all = at_rows[0];
    const long steps_a_row = std::lround(spacing / h);
    for (long step = 0; step < std::lround(scenario.duration_s / h); ++step) {
      Vector<4> middle;
      const ConstSample half_way = moved[static_cast<std::size_t>(2 * step + 1)];
      std::ranges::copy(half_way.qd, std::ranges::copy(half_way.q, middle.begin()).out);
      all = product(motion.transition(middle, h), all);
      if ((step + 1) % steps_a_row == 0) at_rows.push_back(all);
    }
    return at_rows;
  };
  const auto coarse = product_of_steps(5e-4);
  const auto fine = product_of_steps(2.5e-4);
  double worst = 0;
  for (std::size_t k = 0; k < sensitivity.t.size(); ++k) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const double wanted = fine[k][i][j] + (fine[k][i][j] - coarse[k][i][j]) / 3;
        const double off = std::fabs(sensitivity.transition[k][4 * i + j] - wanted) / sensitivity.growth[k];
        worst = std::max(worst, off);
      }
    }
  }
  std::printf("short steps: %.2g of the growth, %.3g at %g s\n", worst, sensitivity.growth.back(),
              sensitivity.t.back());
  // What is left is of order h^4: measured 9.9e-8, and 7e-7 for steps twice as long. One step size leaves 1e-4.
  CHECK(worst < 3e-7);
}

// P d beside runs started d away, both ways: what is left is of order d^2 times the third derivative of the motion.
void check_perturbed_runs() {
  Scenario scenario = double_pendulum();
  scenario.duration_s = 5;
  const Sensitivity sensitivity = sensitivity_of(scenario);
  constexpr double d = 1e-6;
  for (std::size_t j = 0; j < 4; ++j) {
    const auto started = [&](double by) {
      Scenario other = scenario;
      change_planar(other, [&](PlanarView& view) { (j < 2 ? view.q0[j] : view.qd0[j - 2]) += by; });
      return motion_of(make_cvode, other, spacing);
    };
    const Motion ahead = started(d);
    const Motion behind = started(-d);
    double worst = 0;
    for (std::size_t k = 0; k < sensitivity.t.size(); ++k) {
      for (std::size_t i = 0; i < 4; ++i) {
        const double slope = i < 2 ? ahead[k].q[i] - behind[k].q[i] : ahead[k].qd[i - 2] - behind[k].qd[i - 2];
        worst =
            std::max(worst, std::fabs(sensitivity.transition[k][4 * i + j] - slope / (2 * d)) / sensitivity.growth[k]);
      }
    }
    std::printf("column %zu against perturbed runs: %.2g of the growth\n", j, worst);
    CHECK(worst < 3e-7);  // measured 6e-8
  }
}

double mass_determinant(const Scenario& scenario, const Sensitivity& sensitivity, std::size_t row) {
  DhChain chain(DhConvention::standard, pendulum_links(*scenario.planar, DhConvention::standard),
                pendulum_gravity(scenario));
  const auto n = scenario.planar->links.size();
  std::vector<double> q(n), mass(n * n);
  for (std::size_t i = 0; i < n; ++i) q[i] = sensitivity.q[i][row];
  chain.mass_matrix(q.data(), mass.data());
  const auto size = static_cast<Eigen::Index>(n);
  return Eigen::Map<Square>(mass.data(), size, size).determinant();
}

// Liouville: the motion keeps volumes of (q, p), p = M(q) qd, so det P = det M(q(0)) / det M(q(t)).
void check_volume() {
  for (const char* name : {"double_pendulum", "single_pendulum"}) {
    Scenario scenario = test::report_scenario(name, 6.0, 1e-3);
    const bool two = scenario.planar->links.size() == 2;
    if (two) change_planar(scenario, [](PlanarView& view) { view.links[1] = {0.6, 1.3, 0.1, 0.1}; });
    const Sensitivity sensitivity = sensitivity_of(scenario);
    const double at_start = mass_determinant(scenario, sensitivity, 0);
    double worst = 0;
    double most = 0;  // determinants far from 1, or the check says nothing of M
    for (std::size_t k = 0; k < sensitivity.t.size(); ++k) {
      const double wanted = at_start / mass_determinant(scenario, sensitivity, k);
      const double growth = std::max(sensitivity.growth[k], 1.0);
      worst = std::max(worst, std::fabs(matrix_at(sensitivity, k).determinant() / wanted - 1) / (growth * growth));
      most = std::max(most, wanted);
    }
    std::printf("%s: volume off by %.2g of the growth's square, ratio of volumes up to %.3g\n", name, worst, most);
    // The determinant is a difference of products as large as the growth's square. Measured 1.6e-13.
    CHECK(worst < 1e-12);
    if (two) CHECK(most > 1.2);
  }
}

// The closed form of the single pendulum, differenced.
void check_closed_form() {
  const Scenario scenario = test::report_scenario("single_pendulum", 10.0, 1e-3);
  const Sensitivity sensitivity = sensitivity_of(scenario);
  constexpr double d = 1e-5;
  const auto started = [&](double by) {
    Scenario other = scenario;
    change_planar(other, [by](PlanarView& view) { view.q0[0] += by; });
    return motion_of(make_analytic, other, spacing);
  };
  const Motion ahead = started(d);
  const Motion behind = started(-d);
  double worst = 0;
  for (std::size_t k = 0; k < sensitivity.t.size(); ++k) {
    const double angle = (ahead[k].q[0] - behind[k].q[0]) / (2 * d);
    const double rate = (ahead[k].qd[0] - behind[k].qd[0]) / (2 * d);
    worst = std::max(
        {worst, std::fabs(sensitivity.transition[k][0] - angle), std::fabs(sensitivity.transition[k][2] - rate)});
  }
  std::printf("closed form: %.2g, growth %.3g at %g s\n", worst, sensitivity.growth.back(), sensitivity.t.back());
  CHECK(worst < 3e-7);  // d^2 times the motion's third derivative, some 1e3 after 10 s: measured 6.3e-8
}

void check_start_and_exponent() {
  const Sensitivity sensitivity = sensitivity_of(double_pendulum());
  CHECK(matrix_at(sensitivity, 0).isIdentity(0));
  CHECK_EQUAL(sensitivity.growth[0], 1.0);
  CHECK_EQUAL(sensitivity.exponent[0], 0.0);
  for (const std::size_t k : {std::size_t{10}, std::size_t{60}}) {
    CHECK_NEAR(sensitivity.growth[k] / matrix_at(sensitivity, k).operatorNorm(), 1.0, 1e-12);
    CHECK_NEAR(std::exp(sensitivity.exponent[k] * sensitivity.t[k]) / sensitivity.growth[k], 1.0, 1e-12);
  }
}

}  // namespace

int main() {
  check_short_steps();
  check_perturbed_runs();
  check_volume();
  check_closed_form();
  check_start_and_exponent();
  CHECK_THROWS(sensitivity_of(test::report_scenario("wall_pendulum", 1.0, 1e-3)), UserError, "without a wall");
  return test::verdict();
}
