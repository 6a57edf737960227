#pragma once
// A scenario in a method beside the reference: the sentence the whole program says.
#include <memory>
#include <string>
#include <vector>

#include "catalogue/methods.hpp"
#include "odeval/metrics.hpp"
#include "odeval/reference.hpp"
#include "odeval/trace.hpp"

namespace odeval::catalogue {

/// CPU seconds this thread has used.
double cpu_seconds();

struct Evaluation {
  const Method* method = nullptr;
  Outcome outcome;
  Trace trace;
  double cpu_s = 0;  // of the run and its recording, set-up and comparison left out
};

/// Runs methods on one scenario and keeps the reference they share.
class Evaluator {
 public:
  /// Throws UserError when the scenario's sampling does not fit its step.
  explicit Evaluator(Scenario scenario);
  /// The same with a reference that another evaluator of the motion solved, whose rows stand at the same times.
  Evaluator(Scenario scenario, Reference reference);
  Evaluator(Scenario scenario, std::shared_ptr<const Reference> reference);

  const Scenario& scenario() const { return scenario_; }
  const SampleGrid& grid() const { return grid_; }

  /// Solved on first use. Throws MachineError when CVODE gives up.
  const Reference& reference();

  /// A simulation as the settings ask for it, `--start half-step` included.
  std::unique_ptr<Simulation> make(const Method& method) const;

  /// The trace holds the errors against the reference.
  Evaluation evaluate(const Method& method);

  /// The same with other settings of the engine, on which the reference does not depend.
  Evaluation evaluate(const Method& method, const OdeSettings& ode);

  Metrics measure(const Evaluation& evaluation, double until_s);

  /// CPU time of what moves the bodies in a run that `evaluate` made. A method that chooses its steps has to find each
  /// row between two of them, and of other engines the forces of joints are made for each step: such a run is done once
  /// more, without rows. Of the others recording is a small part, and `cpu_s` it is.
  double stepping_s(const Evaluation& evaluation, double (*clock)() = cpu_seconds) const;

 private:
  Scenario scenario_;
  SampleGrid grid_;
  std::shared_ptr<const Reference> reference_;  // null: not needed yet
};

/// While one lives, it keeps the runs of this process that ODE itself complained of, each once: "SCENARIO in
/// ode-step-double, h = 0.001 s: 736 messages of ODE (LCP internal error)".
///
/// One within another keeps its runs from the outer one: for trials of which nothing is shown. Who runs thousands
/// without one, as a sweep does, keeps nothing.
class Suspects {
 public:
  Suspects();
  ~Suspects();
  Suspects(const Suspects&) = delete;
  Suspects& operator=(const Suspects&) = delete;

  const std::vector<std::string>& lines() const { return lines_; }

  /// Tells the one that lives, if any. `evaluate` has done so once.
  static void note(const Evaluation& run, const Scenario& scenario);

 private:
  Suspects* outer_;
  std::vector<std::string> lines_;
};

}  // namespace odeval::catalogue
