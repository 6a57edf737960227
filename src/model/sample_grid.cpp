#include <fmt/format.h>

#include <cmath>

#include "odeval/error.hpp"
#include "odeval/scenario.hpp"

namespace odeval {

SampleGrid sample_grid(const Scenario& scenario) {
  constexpr double most_rows = 20e6;

  SampleGrid grid;
  grid.step_s = scenario.step_s;
  if (scenario.sample_s) {
    const double steps = *scenario.sample_s / scenario.step_s;
    const double whole = std::round(steps);
    if (!(whole >= 1 && std::fabs(steps - whole) <= 1e-6)) {
      throw UserError(
          fmt::format("sample = {} s must be a whole number of steps of {} s", *scenario.sample_s, scenario.step_s));
    }
    grid.stride = static_cast<long>(whole);
  }
  // The quotient is forgiven its own rounding and that of the decimal numbers behind it.
  const double spacing = static_cast<double>(grid.stride) * grid.step_s;
  const double intervals = std::ceil(scenario.duration_s / spacing * (1 - 1e-12) - 1e-9);
  if (!(intervals < most_rows)) {
    throw UserError(fmt::format("a row every {} s for {} s makes {:.0f} rows, and {:.0f} are allowed; use --sample",
                                spacing, scenario.duration_s, intervals + 1, most_rows));
  }
  grid.rows = static_cast<long>(intervals) + 1;
  return grid;
}

}  // namespace odeval
