// Values at several steps, whose limit is known.
#include "audit/extrapolation.hpp"

#include <cmath>

#include "audit/unseen.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval::audit;
using odeval::test::verdict;

/// One value at h/k for each k, once.
template <class Value>
Spread spread_of(const std::vector<int>& refinements, const Value& value) {
  Spread spread(refinements);
  std::vector<double> values;
  for (const int k : refinements) values.push_back(value(1.0 / k));
  spread.add(values.data(), 1, 1);
  return spread;
}

void smooth_values_settle() {
  // 5 + 0.1 h + 0.02 h^2 + 0.003 h^3: the best of degree 2 leaves 0.003 / 64 of the cube.
  const Spread first = spread_of({1, 2, 4, 8}, [](double h) { return 5 + h * (0.1 + h * (0.02 + h * 0.003)); });
  CHECK_NEAR(first.error(0).value, 0.123, first.error(0).uncertainty);
  CHECK_BETWEEN(first.error(0).uncertainty, 1e-6, 1e-3);
  CHECK(first.error(0).convergence == Convergence::settled);
  CHECK_BETWEEN(first.order().value(), 1, 1.2);  // the square has its part

  const Spread second = spread_of({1, 2, 4, 8}, [](double h) { return 5 + 0.1 * h * h; });
  CHECK_NEAR(second.order().value(), 2, 1e-9);
  CHECK_NEAR(second.error(0).value, 0.1, 1e-12);

  // Steps in no ratio.
  const Spread odd = spread_of({1, 2, 3, 5}, [](double h) { return 5 + h * (0.1 + h * 0.02); });
  CHECK_NEAR(odd.error(0).value, 0.12, 1e-12);
}

// Of two runs nothing is known but that they are apart: values that fall more slowly than h are covered all the same.
// Of four the best degree is believed only as far as its distances fall.
void slow_values_are_covered() {
  for (const double power : {0.7, 0.8, 1.0, 1.3}) {
    const auto value = [power](double h) { return 5 + std::pow(h, power); };
    const Estimate two = spread_of({1, 2}, value).error(1);
    CHECK_BETWEEN(std::fabs(two.value - std::pow(0.5, power)), 0, two.uncertainty);
    const Estimate four = spread_of({1, 2, 4, 8}, value).error(0);
    CHECK_BETWEEN(std::fabs(four.value - 1), 0, four.uncertainty);
  }
}

// Differences that fall faster than any scheme's are those of runs that blow up.
void what_blows_up_has_no_limit() {
  const Spread blown = spread_of({1, 2, 4, 8}, [](double h) { return std::exp(100 * h); });
  CHECK(blown.error(3).convergence != Convergence::rough);
}

void the_error_of_each_run() {
  const Spread spread = spread_of({1, 2, 4, 8}, [](double h) { return 0.1 * h; });
  CHECK_NEAR(spread.error(1).value, 0.05, 1e-12);
  CHECK_NEAR(spread.error(3).value, 0.0125, 1e-12);
}

// As an impact that falls anywhere in a step leaves it: h times something between 0 and 1, another at each step. In the
// first part of a step all runs have it between the same two grid points, and agree on a limit that is off by its place
// there, up to an eighth: the judge adds that. With it every place is covered, and without it half of them.
void jagged_values_are_covered() {
  int covered = 0;
  int without = 0;
  const int cases = 1000;
  for (int i = 0; i < cases; ++i) {
    const double place = std::fmod(0.618033988749895 * i, 1.0);
    const Spread spread = spread_of({1, 2, 4, 8}, [&](double h) { return h * (1 - std::fmod(place / h, 1.0)); });
    const Estimate error = spread.error(0);
    const double off = std::fabs(error.value - (1 - place));
    if (off <= error.uncertainty + 1.0 / 8) ++covered;
    if (off <= error.uncertainty) ++without;
  }
  CHECK_EQUAL(covered, cases);
  CHECK_BETWEEN(without / double{cases}, 0.45, 0.55);
}

// A velocity that jumps by 3 m/s in a step takes the body up to 3 m/s * h/8 elsewhere within the finest part of it: as
// much is unseen at least, and at most twice as much. What begins with the run hides nothing.
void jumps_hide_what_they_come_to() {
  constexpr double h = 1e-3;
  const auto unseen = [](int jump_at) {
    Bends bends;
    for (int step = 0; step < 20; ++step) {
      const double velocity[3] = {0, step < jump_at ? 1.0 : -2.0, 5};
      bends.add(velocity, h);
    }
    return bends.unseen(8);
  };
  CHECK_BETWEEN(unseen(10), 3 * h / 8, 2 * 3 * h / 8);
  CHECK_EQUAL(unseen(0), 0.0);
}

// Of x -> 3.9 x (1 - x), which makes of rounding what it makes of a moved start: with more digits it goes elsewhere, by
// less than is told, and by more than rounding comes to where nothing grows.
void rounding_grows_with_the_motion() {
  Chaos chaos{.moved_by_m = 1e-10, .extent_m = 1};
  double off = 0;
  double x = 0.3;
  double moved = x + chaos.moved_by_m;
  long double with_more_digits = x;
  for (chaos.steps = 1; chaos.steps <= 30; ++chaos.steps) {
    x = 3.9 * x * (1 - x);
    moved = 3.9 * moved * (1 - moved);
    with_more_digits = static_cast<long double>(3.9) * with_more_digits * (1 - with_more_digits);
    chaos.apart_m = std::max(chaos.apart_m, std::fabs(moved - x));
    off = std::max(off, std::fabs(static_cast<double>(with_more_digits - x)));
    CHECK_BETWEEN(off, 0, chaos.rounding_m());
  }
  CHECK_BETWEEN(off, 10 * chaos.rounding_m() / chaos.growth(), 1e-3);
}

void what_moves_apart_has_no_limit() {
  const Spread apart = spread_of({1, 2, 4, 8}, [](double h) { return 0.1 / h; });
  CHECK(apart.error(0).convergence == Convergence::none);
  CHECK_BETWEEN(apart.order().value(), -1.1, -0.9);
  const Spread chaos = spread_of({1, 2, 4, 8}, [](double h) { return std::sin(1e3 / h); });
  CHECK(chaos.error(0).convergence != Convergence::settled);
  const Spread broken = spread_of({1, 2, 4, 8}, [](double h) { return h < 0.2 ? NAN : 1.0; });
  CHECK(broken.error(0).convergence == Convergence::none);
  const Spread infinite = spread_of({1, 2, 4, 8}, [](double h) { return h > 0.2 ? HUGE_VAL : 1.0; });
  CHECK(infinite.error(0).convergence == Convergence::none);
  CHECK(!infinite.order());
}

void what_is_the_same_is_settled() {
  const Spread same = spread_of({1, 2, 4, 8}, [](double) { return 3.0; });
  CHECK_EQUAL(same.error(0).value, 0.0);
  CHECK(!same.order());
  CHECK(same.error(0).convergence == Convergence::settled);
}

// Of errors 8 h^1.5: the step that keeps one is its root, wherever it lies among those that were tried.
void the_step_that_keeps_an_error() {
  std::vector<StepError> runs;
  for (const double h : {0.04, 0.02, 0.01, 0.005}) runs.push_back({h, 8 * std::pow(h, 1.5)});
  for (const double h : {0.03, 0.015, 0.007, 0.002, 0.0001}) {
    CHECK_NEAR(step_that_keeps(8 * std::pow(h, 1.5), runs, 1.5, true).value(), h, 1e-12);
  }
  CHECK_EQUAL(step_that_keeps(1, runs, 1.5, true).value(), 0.04);  // the program's own, though a larger one would do
  // Not settled: one that was tried and keeps it, and past them nothing.
  CHECK_EQUAL(step_that_keeps(8 * std::pow(0.015, 1.5), runs, std::nullopt, false).value(), 0.01);
  CHECK(!step_that_keeps(8 * std::pow(0.002, 1.5), runs, std::nullopt, false));
  CHECK(!step_that_keeps(8 * std::pow(0.002, 1.5), runs, -0.5, true));
  runs.back().most = NAN;
  CHECK(!step_that_keeps(8 * std::pow(0.007, 1.5), runs, std::nullopt, false));
}

}  // namespace

int main() {
  smooth_values_settle();
  slow_values_are_covered();
  what_blows_up_has_no_limit();
  the_error_of_each_run();
  jagged_values_are_covered();
  jumps_hide_what_they_come_to();
  rounding_grows_with_the_motion();
  what_moves_apart_has_no_limit();
  what_is_the_same_is_settled();
  the_step_that_keeps_an_error();
  return verdict();
}
