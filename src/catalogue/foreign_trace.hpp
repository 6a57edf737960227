#pragma once
// A trace that somebody else made, beside a scenario's reference.
#include <string>
#include <vector>

#include "catalogue/evaluation.hpp"

namespace odeval::catalogue {

/// What a trace that may lack columns tells.
class ForeignTrace {
 public:
  /// The trace has its rows at the times of the scenario's grid. Throws UserError, which begins with `name`, where it
  /// has neither all angles of the scenario nor the positions of all its bodies.
  ForeignTrace(Trace trace, Evaluator& evaluator, const std::string& name);

  /// Every quantity that its columns tell.
  Metrics measure(double until_s);

 private:
  void complete();

  Evaluator& evaluator_;
  Evaluation run_;
  std::vector<quantity::Id> untold_;  // columns that they are taken from are missing
};

}  // namespace odeval::catalogue
