#pragma once
// The reference where nobody else knows the motion: what ODE itself tends to as its step goes to 0.
#include <string>
#include <string_view>
#include <vector>

#include "odeval/origin.hpp"
#include "odeval/reference.hpp"
#include "odeval/scenario.hpp"

namespace odeval::catalogue {

/// Bodies on joints that touch something, without controllers that look once a step: another step is another motion
/// with them.
bool can_self_converge(const Scenario& scenario);

/// Runs of dWorldStep at h, h/2, h/4 and h/8 on the scenario's rows, extrapolated as the audit of a program does it,
/// with the spread of the extrapolations until then as the uncertainty. ERP and CFM stay the spring and damper that
/// they are at h, or as the scenario asks for it their numbers. Throws UserError when a run blows up.
Reference self_converged(const Scenario& scenario, const SampleGrid& grid);

/// "self-converged" of such a reference, for tables of numbers that are measured against it; empty of others.
std::string_view mark_of(const Reference& reference);

/// While one lives, it keeps the scenarios of this process whose numbers are measured against such a reference, each
/// once: "NAME (self-converged: dWorldStep's own limit ...)". For who shows numbers and does not know of what.
/// One within another keeps them from the outer one.
class OwnLimits {
 public:
  OwnLimits();
  ~OwnLimits();
  OwnLimits(const OwnLimits&) = delete;
  OwnLimits& operator=(const OwnLimits&) = delete;

  const std::vector<std::string>& lines() const { return lines_; }

  /// Tells the one that lives, if any. `Evaluator::reference` has done so.
  static void note(const Reference& reference, const Scenario& scenario);

 private:
  OwnLimits* outer_;
  std::vector<std::string> lines_;
};

/// Who knows the true motion: as reference::provider_for, and ODE itself where that knows nobody.
const ReferenceProvider& provider_of(const Scenario& scenario);

}  // namespace odeval::catalogue
