// The reference against trajectories known to 20 digits: its stated uncertainty must cover its error at every sample,
// and must not be silly; lagrange-cvode must be as good as promised.
#include "tests/oracle/certified.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "reference/certified/motions.hpp"
#include "reference/planar/cvode.hpp"
#include "reference/planar/reference_solution.hpp"
#include "tests/check.hpp"
#include "tests/recorded.hpp"

namespace {

using namespace odeval;
using namespace odeval::reference;
using test::CertifiedRow;
using test::Quad;

constexpr double last_digit = 1e-25;  // of the files

double error(const CertifiedRow& truth, double q1, double q2) {
  return std::max(std::fabs(static_cast<double>(truth.y[0] - q1)), std::fabs(static_cast<double>(truth.y[1] - q2)));
}

void check_reference(const CertifiedMotion& motion) {
  const std::vector<CertifiedRow> truth = test::read_certified(motion);
  const Reference reference = solve_reference(motion.scenario(), certified_grid);
  CHECK_EQUAL(truth.size(), reference.trace.rows());
  CHECK_EQUAL(reference.uncertainty_q[0], 0.0);  // the start is exact

  int uncovered = 0;
  std::vector<double> ratios;
  double largest = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    CHECK_EQUAL(truth[k].t, reference.trace.t[k]);
    const double off = error(truth[k], reference.trace.q[0][k], reference.trace.q[1][k]);
    if (!(off <= reference.uncertainty_q[k] + last_digit)) ++uncovered;
    largest = std::max(largest, off);
    if (k > 0) ratios.push_back(reference.uncertainty_q[k] / largest);
  }
  CHECK_EQUAL(uncovered, 0);
  // Against the largest error so far the bound is 10 to 130 times too wide in the middle of these runs. Below 2 it
  // would cover by luck, above 400 it would say little.
  std::sort(ratios.begin(), ratios.end());
  CHECK_BETWEEN(ratios[ratios.size() / 2], 2.0, 400.0);
  CHECK_BETWEEN(ratios.front(), 1.0, 100.0);
}

void check_cvode() {
  const CertifiedMotion& motion = certified_motions[0];
  const std::vector<CertifiedRow> truth = test::read_certified(motion);
  const auto [outcome, moved] = test::recorded(make_cvode, motion.scenario(), certified_grid);
  CHECK(!outcome.diverged);
  CHECK_EQUAL(moved.size(), truth.size());
  double until_5 = 0;
  double until_10 = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double off = error(truth[k], moved[k].q[0], moved[k].q[1]);
    if (truth[k].t <= 5) until_5 = std::max(until_5, off);
    until_10 = std::max(until_10, off);
  }
  // Promised. Measured 4e-11 and 5e-8: the motion amplifies by 1e6 in 10 s, so what is left is rounding, not chance.
  CHECK_BETWEEN(until_5, 1e-14, 1e-8);
  CHECK_BETWEEN(until_10, 1e-13, 1e-5);

  // Unrecorded it takes the same steps.
  const Outcome bare = make_cvode(motion.scenario(), certified_grid)->run({});
  CHECK_EQUAL(bare.steps, outcome.steps);
  CHECK_EQUAL(bare.evaluations, outcome.evaluations);
}

}  // namespace

int main() {
  for (const CertifiedMotion& motion : certified_motions) check_reference(motion);
  check_cvode();
  return odeval::test::verdict();
}
