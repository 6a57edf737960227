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

Content denavit_hartenberg(Laboratory& laboratory, Findings& findings) {
  const Trace& toolbox = laboratory.run("double_pendulum", "dh-ode45")->trace;
  const Trace& by_hand = laboratory.run("double_pendulum", "lagrange-ode45")->trace;
  report::Panel panel{.x_label = "t, s", .y_label = "difference of the angles, rad", .log_y = true};
  report::Table table{.name = "dh", .columns = {"until, s", "largest difference, rad"}};
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

  Content content;
  content.exhibits.emplace_back(report::Figure{.name = "dh-difference", .panels = {std::move(panel)}});
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
