#pragma once
// One motion by dWorldStep and by QuickStep over its iterations and over-relaxation.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "experiments/experiment.hpp"

namespace odeval::experiments {

struct QuickRun {
  OdeSettings settings;
  double error;         // largest of an angle, rad; NaN when the run blew up
  double gap;           // largest in a joint, m; likewise
  double uncertainty;   // of the reference, rad
  double a_step_s = 0;  // CPU time, median of rounds in turn, nothing recorded
};

struct QuickRuns {
  QuickRun direct;  // dWorldStep
  QuickRun as_set;  // QuickStep with the scenario's own settings
  std::vector<QuickRun> iterative;

  /// The error of QuickStep as set over dWorldStep's.
  report::Finding error_ratio(std::string meaning) const;

  report::Table table(std::string name) const;

  /// One curve an over-relaxation, on logarithmic axes.
  report::Panel panel(std::string x_label, const std::function<double(const QuickRun&)>& x, std::string y_label,
                      const std::function<double(const QuickRun&)>& y) const;
};

/// Each until the time, s; timed over as many steps as take no long time.
QuickRuns quickstep_runs(catalogue::Evaluator& evaluator, std::span<const int> iterations, double until_s);

/// A level of dWorldStep's over all iterations.
report::Series direct_level(const QuickRuns& runs, double level);

}  // namespace odeval::experiments
