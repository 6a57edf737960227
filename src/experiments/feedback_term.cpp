// The feedback term -ks C - kd C' of the methods with Lagrange multipliers: claim C16.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "experiments/all.hpp"
#include "experiments/parts.hpp"

namespace odeval::experiments {
namespace {

using catalogue::Evaluation;
using catalogue::Evaluator;

constexpr const char* methods[] = {"maximal-euler", "maximal-rk4"};
constexpr double early_s = 3;

/// A method with the feedback of the file, and without.
struct Pair {
  Evaluation with;
  Evaluation without;
  double followed_s;  // until when both are the motion they mean to be
};

Pair pair_of(Evaluator& evaluator, Evaluator& unfed, const char* name) {
  Pair pair{evaluator.evaluate(*available(name)), unfed.evaluate(*available(name)), 0};
  const double end = evaluator.scenario().duration_s;
  const auto lost_at = [&](Evaluator& of, const Evaluation& run) {
    return of.measure(run, end)[quantity::divergence_time].value_or(end);
  };
  pair.followed_s = std::min(lost_at(evaluator, pair.with), lost_at(unfed, pair.without));
  return pair;
}

double gap_until(Evaluator& evaluator, const Evaluation& run, double until_s) {
  return evaluator.measure(run, until_s)[quantity::max_gap].value();
}

}  // namespace

Content feedback_term(Laboratory& laboratory, Findings& findings) {
  Evaluator& evaluator = laboratory.evaluator("double_pendulum");
  const Scenario& file = evaluator.scenario();
  Scenario no_feedback = file;
  no_feedback.maximal = {0, 0};
  Evaluator unfed(no_feedback, evaluator.reference());

  report::Table table{.name = "feedback-term",
                      .columns = {"method", "until, s", "chosen since", "gap without, m", "gap with, m", "ratio",
                                  "angle error without, rad", "angle error with, rad"}};
  report::Figure figure{.name = "feedback-gap", .columns = 2};
  double least = std::numeric_limits<double>::infinity();
  for (const char* name : methods) {
    const Pair pair = pair_of(evaluator, unfed, name);
    struct Window {
      double until_s;
      std::string why;
    };
    const bool to_the_end = pair.followed_s >= file.duration_s;
    std::vector<Window> windows{{pair.followed_s, to_the_end ? "judged: never lost" : "judged: then one is lost"},
                                {early_s, "for comparison"}};
    if (!to_the_end) windows.push_back({file.duration_s, "for comparison"});
    for (const Window& window : windows) {
      const double without = gap_until(unfed, pair.without, window.until_s);
      const double with = gap_until(evaluator, pair.with, window.until_s);
      table.rows.push_back({std::string(name), window.until_s, window.why, without, with, without / with,
                            error_until(unfed, pair.without, window.until_s),
                            error_until(evaluator, pair.with, window.until_s)});
      if (&window == &windows.front()) least = std::min(least, without / with);
    }
    report::Panel panel{.x_label = "t, s", .y_label = "gap, m", .log_y = true};
    panel.series = {curve(fmt::format("{}, with feedback", name), pair.with.trace.t, above_zero(pair.with.trace.gap),
                          colour_of(name)),
                    curve(fmt::format("{}, without feedback", name), pair.without.trace.t,
                          above_zero(pair.without.trace.gap), colour_of(name), true)};
    if (!to_the_end) {
      panel.shade = report::Shade{pair.followed_s, fmt::format("one of the two is off by more than {} rad, and their "
                                                               "gaps are those of different motions",
                                                               divergence_rad)};
    } else {
      panel.shade = lost_shade(evaluator, pair.with);
    }
    figure.panels.push_back(std::move(panel));
  }
  findings.add("C16.gap_ratio",
               measured("widest gap without feedback over that with it, while both follow the motion; the smaller of "
                        "both methods",
                        "", least));
  Content content;
  content.values = {{"ks", file.maximal.ks},
                    {"kd", file.maximal.kd},
                    {"lost", divergence_rad},
                    {"known", reference_known(evaluator, {early_s, file.duration_s})}};
  content.exhibits.emplace_back(std::move(figure));
  content.exhibits.emplace_back(std::move(table));
  return content;
}

}  // namespace odeval::experiments
