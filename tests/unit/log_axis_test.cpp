// Where a logarithmic axis begins, and what it tells of the values that have no place on it.
#include "report/log_axis.hpp"

#include <cmath>
#include <limits>

#include "tests/check.hpp"

namespace {

using namespace odeval;
using report::LogAxis;

LogAxis axis_of(const std::vector<Column>& columns, report::Mark mark = report::Mark::line) {
  report::Panel panel;
  for (const Column& column : columns) panel.series.push_back({"", Column(column.size(), 0), column, mark});
  return report::log_axis_of(panel);
}

/// An error that grows from 1e-6 to 1e-3 and begins with these.
Column grown(Column begin, std::size_t values) {
  for (std::size_t i = 0; i < values; ++i) {
    begin.push_back(std::pow(10, -6 + 3 * static_cast<double>(i) / static_cast<double>(values - 1)));
  }
  return begin;
}

void check(const LogAxis& axis, double least, double greatest, const std::string& text) {
  CHECK_NEAR(axis.least / least, 1, 1e-12);
  CHECK_NEAR(axis.greatest / greatest, 1, 1e-12);
  CHECK_EQUAL(report::left_out_text(axis), text);
}

void it_begins_where_the_values_are() {
  check(axis_of({grown({}, 1000)}), 1e-6, 1e-3, "");
  check(axis_of({grown({0}, 1000)}), 1e-6, 1e-3, "not drawn: 1 value of 0, of 1001");
  check(axis_of({grown({0, 0, 1.1e-16}, 1000)}), 1e-6, 1e-3, "not drawn: 2 values of 0, 1 below 1e-06, of 1003");
  check(axis_of({grown({1.1e-16}, 10)}), 1e-6, 1e-3, "not drawn: 1 below 1e-06, of 11");
  // More than one in a hundred is what was measured, and so is what lies within two decades of the rest.
  check(axis_of({grown(Column(20, 1.1e-16), 1000)}), 1e-16, 1e-3, "");
  check(axis_of({grown({2e-8}, 1000)}), 1e-8, 1e-3, "");
  // Each series keeps its own: another of a million times the size does not put it below the axis.
  check(axis_of({grown({}, 1000), Column(100'000, 1)}), 1e-6, 1, "");
  const double gap = std::numeric_limits<double>::quiet_NaN();
  check(axis_of({grown({gap}, 1000), {}}), 1e-6, 1e-3, "");
  check(axis_of({{2e-9}}), 1e-9, 1e-8, "");
  check(axis_of({Column{1e-9}}), 1e-9, 1e-8, "");
}

/// Points that were measured one by one, and the ends of a line, are no rounding however far apart they are.
void what_is_few_is_on_it_whole() {
  check(axis_of({grown({1.1e-16}, 20)}, report::Mark::line_and_points), 1e-16, 1e-3, "");
  check(axis_of({grown({1.1e-16}, 20)}, report::Mark::points), 1e-16, 1e-3, "");
  check(axis_of({{1e-2, 1e-10}}), 1e-10, 1e-2, "");
  check(axis_of({{1e-2, 1e-6, 1e-10}}), 1e-10, 1e-2, "");
}

void nothing_has_a_place() {
  const LogAxis axis = axis_of({{0, 0}, {0}});
  CHECK_EQUAL(axis.least, 0.0);
  CHECK_EQUAL(axis.zeros, 3U);
}

}  // namespace

int main() {
  it_begins_where_the_values_are();
  what_is_few_is_on_it_whole();
  nothing_has_a_place();
  return test::verdict();
}
