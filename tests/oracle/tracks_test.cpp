// A motion that is integrated once for rows at any times, beside one that is integrated for its own rows.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "catalogue/methods.hpp"
#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "odeval/quantity.hpp"
#include "reference/providers.hpp"
#include "tests/check.hpp"
#include "tests/oracle/beside_reference.hpp"

namespace {

using namespace odeval;
using namespace odeval::test;

Scenario read(const std::string& name, const std::vector<Override>& settings) {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return read_scenario(find_scenario(name, catalogue::scenario_folder()), settings, names);
}

/// The largest difference over what the reference states in its row: both are the same polynomials of the same steps,
/// so that only rounding is between them.
double excess(const Reference& track, const Reference& solved) {
  double most = 0;
  for (std::size_t k = 0; k < solved.trace.rows(); ++k) {
    for (std::size_t i = 0; i < solved.trace.bodies.size(); ++i) {
      const BodyColumns& a = track.trace.bodies[i];
      const BodyColumns& b = solved.trace.bodies[i];
      most = std::max({most, distance(row(a.position, k), row(b.position, k)) / solved.uncertainty_position[k],
                       apart(row(a.rotation, k), row(b.rotation, k)) / solved.uncertainty_turn[k],
                       distance(row(a.spin, k), row(b.spin, k)) / solved.uncertainty_spin[k]});
    }
  }
  return most;
}

void check(const std::string& name, const std::vector<Override>& settings, bool loops = false) {
  const Scenario scenario = read(name, settings);
  const auto track = reference::follow(scenario);
  CHECK(track != nullptr);
  // The first asks for half of it, the next for more, the last for what is there already, at rows of their own.
  const long rows = std::lround(scenario.duration_s / 0.01);
  for (const SampleGrid& grid :
       {SampleGrid{0.01, 1, rows / 2}, SampleGrid{0.0037, 1, rows}, SampleGrid{0.01, 1, rows / 3}}) {
    const Reference rows_of_track = track(grid);
    const Reference solved = reference::provider_for(scenario).solve(scenario, grid);
    const double most = excess(rows_of_track, solved);
    std::printf("%s, %ld rows: %.3g of the uncertainty\n", name.c_str(), grid.rows, most);
    CHECK_EQUAL(rows_of_track.trace.rows(), solved.trace.rows());
    // Measured: 4e-4 of trees; of the loop 0.2, since Newton's method closes it from another guess.
    CHECK_BETWEEN(most, 0, loops ? 0.5 : 4e-3);
    CHECK_EQUAL(rows_of_track.strikes.size(), solved.strikes.size());
    // Where rows end, a stride of the bound does.
    CHECK_BETWEEN(rows_of_track.uncertainty_turn.back() / solved.uncertainty_turn.back(), 0.5, 2);
    CHECK_EQUAL(rows_of_track.origin, solved.origin);
  }
}

}  // namespace

int main() {
  check("acrobot", {{"controllers.0.sampling", "continuous", "--set"}});
  check("cart_pole", {});       // stops
  check("newtons_cradle", {});  // impacts
  check("iftomm_bricard", {{"duration", "1", "--set"}}, true);
  // Another step is another motion for a controller that looks once a step, and a closed form needs no steps.
  CHECK(reference::follow(read("acrobot", {})) == nullptr);
  CHECK(reference::follow(read("free_box", {})) == nullptr);
  return test::verdict();
}
