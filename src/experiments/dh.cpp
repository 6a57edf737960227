// Recursive Newton-Euler from DH parameters beside the hand-derived equations: claim C13.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

// Both runs round differently, by about 1e-16 a step, and the motion makes that grow. Until here what is left is far
// below any error of ode45's own; later the difference is the motion's answer to rounding and not to the equations.
constexpr double judged_until_s = 5;

}  // namespace

Section denavit_hartenberg(Laboratory& laboratory, Findings& findings) {
  const Trace& toolbox = laboratory.run("double_pendulum", "dh-ode45")->trace;
  const Trace& by_hand = laboratory.run("double_pendulum", "lagrange-ode45")->trace;
  report::Panel panel{.x_label = "t, s", .y_label = "difference of the angles, rad", .log_y = true};
  report::Table table{"dh", "dh-ode45 against lagrange-ode45", {"until, s", "largest difference, rad"}, {}, ""};
  Column difference(toolbox.rows());
  for (std::size_t k = 0; k < toolbox.rows(); ++k) {
    for (std::size_t i = 0; i < toolbox.q.size(); ++i) {
      difference[k] = std::max(difference[k], std::fabs(toolbox.q[i][k] - by_hand.q[i][k]));
    }
  }
  for (const double until : {1.0, 3.0, 5.0, 10.0}) {
    const Column early = part(difference, rows_between(toolbox.t, 0, until));
    if (!early.empty()) table.rows.push_back({until, *std::ranges::max_element(early)});
  }
  const Column judged = part(difference, rows_between(toolbox.t, 0, judged_until_s));
  findings.add("C13.largest_difference",
               measured(fmt::format("largest difference of an angle between dh-ode45 and lagrange-ode45 until {} s",
                                    judged_until_s),
                        "rad", *std::ranges::max_element(judged)));
  if (toolbox.t.back() > judged_until_s) {
    panel.shade = report::Shade{judged_until_s, "from here on the difference is what the motion makes of rounding"};
  }
  panel.series.push_back(curve("dh-ode45 - lagrange-ode45", toolbox.t, above_zero(difference)));

  Section section{"dh", "A toolbox's equations and the hand-derived ones", {}};
  section.blocks.emplace_back(
      report::Text{"The report found a toolbox's recursive Newton-Euler identical to its hand-derived equations. Here "
                   "Orocos KDL does "
                   "the recursion, and both are integrated by the same ode45 with the same tolerances, so that only "
                   "rounding, and what "
                   "the motion makes of it, is left to differ. The verdict looks at the first seconds; after that the "
                   "chaotic motion has "
                   "made a visible difference out of rounding."});
  section.blocks.emplace_back(report::Figure{
      "dh-difference", "Two ways to the same equations", "Gaps are differences of exactly 0.", {std::move(panel)}, 1});
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
