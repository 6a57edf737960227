// The method that certifies the others: its two step sizes must agree, its order must show, and it must reproduce the
// certified trajectories.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "model/generate.hpp"
#include "odeval/error.hpp"
#include "reference/certified/motions.hpp"
#include "reference/planar/quad.hpp"
#include "tests/check.hpp"
#include "tests/oracle/certified.hpp"
#include "tests/planar.hpp"
#include "tests/recorded.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using test::CertifiedRow;

double largest_error(const std::vector<CertifiedRow>& truth, const std::vector<std::vector<Quad>>& rows) {
  double largest = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      largest = std::max(largest, std::fabs(static_cast<double>(truth[k].y[i] - rows[k][i])));
    }
  }
  return largest;
}

void check_certified(const CertifiedMotion& motion) {
  const std::vector<CertifiedRow> truth = test::read_certified(motion);
  const QuadRun run = solve_quad(motion.scenario(), certified_grid);
  CHECK_EQUAL(run.rows.size(), truth.size());
  CHECK_BETWEEN(run.largest_difference, 1e-34, quad_target_rad);
  // The file's own digits end at 1e-25, and rounding in quad precision may differ from compiler to compiler: 2e-34
  // amplified 1e7 times by the wildest of the three.
  CHECK_BETWEEN(largest_error(truth, run.rows), 0.0, 1e-22);
}

// Halving the step divides the error by 2^order. Measured within the first second: 4.01, 8.00 and 14.32; the error's
// next term is two orders up. The steps are long enough to leave errors above the files' last digit.
void check_order() {
  const CertifiedMotion& motion = certified_motions[0];
  const std::vector<CertifiedRow> truth = test::read_certified(motion);
  constexpr SampleGrid first_second{0.01, 1, 101};
  for (const int order : {4, 8, quad_order}) {
    const double coarse = largest_error(truth, extrapolate_quad(motion.scenario(), first_second, order, 1));
    const double fine = largest_error(truth, extrapolate_quad(motion.scenario(), first_second, order, 2));
    CHECK_BETWEEN(std::log2(coarse / fine), order - 0.5, order + 0.5);
  }
}

void check_method() {
  Scenario scenario = certified_motions[1].scenario();
  constexpr SampleGrid second{0.01, 1, 101};
  const QuadRun run = solve_quad(scenario, second);
  const auto [outcome, motion] = test::recorded(make_quad, scenario, second);
  CHECK_EQUAL(motion.size(), std::size_t{101});
  CHECK_EQUAL(motion[100].q[1], static_cast<double>(run.rows[100][1]));
  CHECK_EQUAL(outcome.self_difference.value_or(-1), run.largest_difference);
  CHECK_EQUAL(outcome.steps, run.steps);

  const PlanarView& view = *scenario.planar;
  scenario.planar = test::make_planar(view.frame, view.links, view.q0, view.qd0, Wall{0.9, 1});
  CHECK_THROWS(make_quad(scenario, second), UserError, "lagrange-quad knows no walls");
  CHECK_THROWS(make_quad(scenario, second), UserError, "'analytic'");
}

// Nothing moves: both runs are exact, and the refinement must end.
void check_rest() {
  Scenario scenario = certified_motions[0].scenario();
  scenario.gravity = 0;
  const QuadRun run = solve_quad(scenario, {0.01, 1, 11});
  CHECK_EQUAL(run.largest_difference, 0.0);
  CHECK_EQUAL(static_cast<double>(run.rows[10][0]), scenario.planar->q0[0]);
}

}  // namespace

int main() {
  for (const CertifiedMotion& motion : certified_motions) check_certified(motion);
  check_order();
  check_method();
  check_rest();
  return odeval::test::verdict();
}
