#include "output/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "odeval/metrics.hpp"
#include "output/table.hpp"

namespace odeval {

std::string run_report(const std::vector<RunSummary>& runs, std::span<const double> ns_per_step,
                       const Reference& reference) {
  const Scenario& scenario = runs.front().scenario;
  const SampleGrid& grid = runs.front().grid;
  std::string text = fmt::format("{}: {:g} s, h = {:g} s, {} rows\n\n", scenario.name, grid.time(grid.rows - 1),
                                 grid.step_s, grid.rows);
  text += summary_table(runs, ns_per_step);
  const auto touched = [](const RunSummary& run) { return !run.outcome.impacts.empty(); };
  if (std::ranges::any_of(runs, touched)) text += "\n" + impacts_table(runs, reference.impacts);
  for (const RunSummary& run : runs) {
    if (run.outcome.self_difference) {
      text += fmt::format("\n{}: {} rad between its runs at two step sizes\n", run.method,
                          three_digits(run.outcome.self_difference));
    }
  }
  text += scenario.family() == Family::bodies
              ? "\ndistance   largest distance of a body from the reference ± what the reference may itself be off by\n"
                "turned     likewise the angle between its attitude and the reference's\n"
              : fmt::format(
                    "\nerror      largest angle error against the reference ± what the reference may itself be "
                    "off by\nlost at    first error above {:g} rad\n",
                    divergence_rad);
  text += "reference  " + reference.described + '\n';
  if (const auto lost = runs.front().metrics.reference_lost_at) {
    text += fmt::format("           itself unknown to {:g} rad from t = {:g} s: nothing is called lost after that\n",
                        divergence_rad, *lost);
  }
  return text;
}

std::string summaries_json(const std::vector<RunSummary>& runs) {
  std::string text = "[\n";
  for (const RunSummary& run : runs) text += (&run == &runs.front() ? "" : ",\n") + summary_json(run);
  return text + "]\n";
}

}  // namespace odeval
