// The feedback term -ks C - kd C' of the methods with Lagrange multipliers: claim C16.
#include <fmt/format.h>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

constexpr double until_s = 3;

}  // namespace

Section feedback_term(Laboratory& laboratory, Findings& findings) {
  const Scenario& file = laboratory.scenario("double_pendulum");
  report::Table table{"feedback-term",
                      "The widest gap of a joint until 3 s",
                      {"method", "ks, 1/s²", "kd, 1/s", "gap, m", "angle error, rad"},
                      {},
                      ""};
  report::Panel panel{.x_label = "t, s", .y_label = "gap, m", .log_y = true};
  double gaps[2] = {};
  for (const char* name : {"maximal-euler", "maximal-rk4"}) {
    for (const bool with : {false, true}) {
      Scenario scenario = file;
      scenario.duration_s = until_s;
      if (!with) scenario.maximal = {0, 0};
      catalogue::Evaluator evaluator(scenario);
      const catalogue::Evaluation run = evaluator.evaluate(*available(name));
      const double gap = evaluator.measure(run, until_s).max_gap.value();
      table.rows.push_back(
          {std::string(name), scenario.maximal.ks, scenario.maximal.kd, gap, error_until(evaluator, run, until_s)});
      panel.series.push_back(curve(fmt::format("{}, {} feedback", name, with ? "with" : "without"), run.trace.t,
                                   above_zero(run.trace.gap), colour_of(name), !with));
      if (std::string_view(name) == "maximal-euler") gaps[with ? 1 : 0] = gap;
    }
  }
  findings.add(
      "C16.gap_ratio",
      measured_ratio("widest gap of maximal-euler without feedback over that with it, until 3 s", gaps[0], gaps[1]));
  Section section{"feedback-term", "What the feedback term keeps together", {}};
  section.blocks.emplace_back(
      report::Text{"The report's equation 5.38 adds feedback of joint errors to the multipliers. Both methods run with "
                   "the file's ks "
                   "and kd, and without."});
  section.blocks.emplace_back(
      report::Figure{"feedback-gap", "Gaps of the joints", "The wider of the two joints.", {std::move(panel)}, 1});
  section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace odeval::experiments
