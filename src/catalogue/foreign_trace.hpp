#pragma once
// A trace that somebody else made, beside a scenario's reference.
#include <string>
#include <vector>

#include "catalogue/evaluation.hpp"

namespace odeval::catalogue {

/// What a trace that may lack columns tells.
class ForeignTrace {
 public:
  /// The trace has its rows at the times of the scenario's grid, and a place for each angle and each body of the
  /// scenario, with empty columns where it has none. Throws UserError, which begins with `name`, where no quantity can
  /// be taken from it.
  ForeignTrace(Trace trace, Evaluator& evaluator, const std::string& name);

  /// Every quantity that its columns tell.
  Metrics measure(double until_s) const;

  /// What they do not tell, or of the other angles or bodies alone: "max_gap (needs gap)", "max_error_q (told without
  /// q2)".
  const std::vector<std::string>& untold() const { return untold_; }

 private:
  /// Some of the angles or bodies, with the reference's, and what is taken from them.
  struct Part {
    Trace trace;
    Reference reference;
    std::vector<quantity::Id> ids;
  };
  struct Need;

  static std::vector<Need> needs_of(const Scenario& scenario, const Reference& reference);
  void take(const Need& need, const Trace& trace, const Reference& reference);

  std::vector<Part> parts_;
  std::vector<std::string> untold_;
};

}  // namespace odeval::catalogue
