// The observed order of made-up errors whose order is known.
#include "measure/order.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <limits>
#include <random>
#include <vector>

#include "tests/check.hpp"

namespace {

using namespace odeval;

constexpr double anything = std::numeric_limits<double>::infinity();

std::vector<ErrorPoint> halvings(int count, const auto& error) {
  std::vector<ErrorPoint> points;
  for (int k = 0; k < count; ++k) {
    const double h = std::ldexp(1e-2, -k);
    points.push_back({h, error(h), 0});
  }
  return points;
}

void a_power_is_found() {
  for (const double order : {0.5, 1.0, 2.0, 4.0}) {
    const auto found = observed_order(halvings(6, [&](double h) { return 3 * std::pow(h, order); }), anything);
    CHECK_NEAR(found->order, order, 1e-12);  // rounding of logarithms
    CHECK_BETWEEN(found->half_width, 0, 1e-12);
    CHECK_EQUAL(found->points, 6);
    CHECK_EQUAL(found->from, std::ldexp(1e-2, -5));
    CHECK_EQUAL(found->to, 1e-2);
  }
}

// By hand: logarithms 0, ln 2, ln 4 of the settings; errors 1, 2, 2 times e^0.3. Slope (0.3 + ln 2) / ln 4; residuals
// r (1, -2, 1) with r = (0.3 - ln 2) / 6; standard error |r| sqrt 6 / (sqrt 2 ln 2); t of one degree of freedom 12.706.
void the_interval_is_the_text_books() {
  const std::vector<ErrorPoint> points{{1, 1, 0}, {2, 2, 0}, {4, 2 * std::exp(0.3), 0}};
  const auto found = observed_order(points, anything);
  const double ln2 = std::log(2.0);
  CHECK_NEAR(found->order, (0.3 + ln2) / (2 * ln2), 1e-14);
  CHECK_NEAR(found->half_width, 12.706 * std::fabs(0.3 - ln2) / 6 * std::sqrt(6.0) / (std::sqrt(2.0) * ln2), 1e-13);
}

// 95 of 100 intervals hold the true order: with 4000 trials the share strays by 0.0034 (one sigma), so five of them.
void the_interval_covers() {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.1);
  constexpr int trials = 4000;
  int covered = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto found = observed_order(halvings(7, [&](double h) { return h * std::exp(noise(random)); }), anything);
    covered += std::fabs(found->order - 1) <= found->half_width ? 1 : 0;
  }
  CHECK_BETWEEN(covered / static_cast<double>(trials), 0.95 - 0.017, 0.95 + 0.017);
}

// A next term of the error bends the line; the interval is wide enough for the order that small steps tend to.
void curvature_widens_the_interval() {
  const auto bent = observed_order(halvings(7, [](double h) { return h + 30 * h * h; }), anything);
  CHECK(bent->order > 1.02);
  CHECK(std::fabs(bent->order - 1) < 2 * bent->half_width);
}

void lost_and_uncertain_points_do_not_count() {
  const auto first_order = [](double h) { return 5 * h; };
  std::vector<ErrorPoint> points = halvings(8, first_order);
  const double plain = observed_order(points, anything)->order;

  points[0].error = 17;                           // lost
  points[6] = {points[6].setting, 3e-3, 3.1e-4};  // 9.7 times its uncertainty
  points[7].error = std::numeric_limits<double>::quiet_NaN();
  const auto found = observed_order(points, 0.1);
  CHECK_EQUAL(found->points, 5);
  CHECK_NEAR(found->order, plain, 1e-12);
  CHECK_EQUAL(found->from, points[5].setting);
  CHECK_EQUAL(found->to, points[1].setting);

  points[6].uncertainty = 2.9e-4;  // 10.3 times
  CHECK_EQUAL(observed_order(points, 0.1)->points, 6);
}

// With no scatter, the uncertainties alone make the interval: off by 5 % at one end and as much the other way at the
// other.
void uncertainty_widens_the_interval() {
  std::vector<ErrorPoint> points = halvings(3, [](double h) { return h; });
  for (ErrorPoint& point : points) point.uncertainty = point.error / 20;
  const double shift = -std::log(0.95) * 2 / (2 * std::log(2.0));  // weights -+1 / (2 ln 2), 0 in the middle
  CHECK_NEAR(observed_order(points, anything)->half_width, shift, 1e-12);
}

void too_few_points_have_no_order() {
  CHECK(!observed_order({}, anything));
  CHECK(!observed_order(halvings(2, [](double h) { return h; }), anything));
  CHECK(!observed_order(halvings(9, [](double) { return 0.0; }), anything));
  const std::vector<ErrorPoint> alike(4, ErrorPoint{1e-3, 2e-3, 0});
  CHECK(!observed_order(alike, anything));
}

// h + d h^2 has a local slope of 1 + d h / (2 ln 2) between h/2 and h, to first order: it nears 1 by halves.
void slopes_settle_where_the_next_term_is_small() {
  const std::vector<ErrorPoint> straight = halvings(6, [](double h) { return 2 * h; });
  CHECK_EQUAL(settled_points(straight, anything).size(), 6u);

  const std::vector<ErrorPoint> bent = halvings(9, [](double h) { return h + 100 * h * h; });
  const std::vector<ErrorPoint> settled = settled_points(bent, anything);
  CHECK(settled.size() >= 3 && settled.size() < 9);
  const auto slope = [&](std::size_t i) { return std::log2(bent[i].error / bent[i + 1].error); };
  const std::size_t first = 9 - settled.size();
  CHECK_EQUAL(settled.front().setting, bent[first].setting);
  CHECK(slope(first) - slope(7) <= settled_slopes);
  CHECK(slope(first - 1) - slope(7) > settled_slopes);
  // What is left is smaller than what the whole range has.
  CHECK(std::fabs(observed_order(settled, anything)->order - 1) < settled_slopes);
  CHECK(std::fabs(observed_order(bent, anything)->order - 1) > 2 * settled_slopes);
}

void slopes_that_do_not_settle_leave_nothing() {
  std::vector<ErrorPoint> points = halvings(6, [](double h) { return h; });
  for (std::size_t i = 0; i < points.size(); i += 2) points[i].error *= 1.1;
  CHECK(settled_points(points, anything).empty());
  CHECK(settled_points(halvings(2, [](double h) { return h; }), anything).empty());
  // A kink at the fine end counts as much as one at the coarse end.
  std::vector<ErrorPoint> kinked = halvings(6, [](double h) { return h; });
  kinked.back().error *= 1.1;
  CHECK(settled_points(kinked, anything).empty());
  std::vector<ErrorPoint> lost = halvings(6, [](double h) { return h; });
  lost.front().error = 2;
  CHECK_EQUAL(settled_points(lost, 0.1).size(), 5u);
}

// The table has three decimals.
void quantiles_are_students() {
  for (int df = 1; df <= 30; ++df) {
    const double wanted = boost::math::quantile(boost::math::students_t(df), 0.975);
    CHECK_NEAR(student_t_95(df), wanted, 5.1e-4);
  }
  CHECK_EQUAL(student_t_95(31), student_t_95(30));
  CHECK_BETWEEN(student_t_95(100000) / 1.95996, 1, 1.05);
}

}  // namespace

int main() {
  a_power_is_found();
  the_interval_is_the_text_books();
  the_interval_covers();
  curvature_widens_the_interval();
  lost_and_uncertain_points_do_not_count();
  uncertainty_widens_the_interval();
  too_few_points_have_no_order();
  slopes_settle_where_the_next_term_is_small();
  slopes_that_do_not_settle_leave_nothing();
  quantiles_are_students();
  return odeval::test::verdict();
}
