#include "catalogue/table_5_2.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace odeval::catalogue {

bool is_of_table_5_2(const Scenario& scenario) {
  const auto same = [](double a, double b) { return std::fabs(a - b) < 1e-9; };
  if (!scenario.planar) return false;
  const PlanarView& view = *scenario.planar;
  const bool swings_free = view.links.size() == 2 && !view.wall;
  if (!swings_free || !same(scenario.duration_s, 10) || !same(scenario.gravity, 9.81)) return false;
  for (const Link& link : view.links) {
    if (!same(link.mass_kg, 1) || !same(link.length_m, 1) || !same(link.width_m, 0.1)) return false;
    if (link.shape != LinkShape::box) return false;
  }
  constexpr double quarter = std::numbers::pi / 4;
  return same(view.q0[0], quarter) && same(view.q0[1], -quarter) && same(view.qd0[0], 0) && same(view.qd0[1], 0);
}

std::vector<Table52Row> table_5_2_rows(std::span<const TimingRow> rows) {
  std::vector<Table52Row> table;
  const auto add = [&](Table52Row row, std::string_view method) {
    row.method = method;
    const auto timed = std::ranges::find(rows, method, &TimingRow::method);
    if (timed != rows.end()) {
      row.steps = timed->steps;
      row.median_s = timed->median_s;
      row.mad_s = timed->mad_s;
    }
    table.push_back(std::move(row));
  };
  for (const Case2010& then : table_5_2) {
    add({then.number, std::string(then.equations), std::string(then.solver), then.steps, then.seconds, "", {}, {}, {}},
        then.method);
  }
  for (const std::string_view method : beside_table_5_2) {
    add({{}, "-", "-", {}, {}, "", {}, {}, {}}, method);
  }
  return table;
}

}  // namespace odeval::catalogue
