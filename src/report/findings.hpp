#pragma once
// The numbers that experiments measured and claims are judged by.
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace odeval::report {

/// What a number's uncertainty is. Only the reference's stands behind ±; the others are shown as a range.
enum class Source {
  reference,  // how far the reference may be off
  fit,        // half the 95 % interval of a fit
  timing,     // half the spread of times on this machine
  step,       // a time is known to a step
};

/// One measured number. A number that could not be had keeps its place and says why.
struct Finding {
  std::string meaning;                                   // one line, for the page
  std::string unit;                                      // empty: a ratio or a count
  std::optional<double> value;                           // empty: see `missing`
  double uncertainty = 0;                                // half width
  std::string missing;                                   // why there is no value
  Source source = Source::reference;                     // of the uncertainty
  std::optional<std::pair<double, double>> nearby = {};  // least and largest value over neighbouring settings, where
                                                         // the number hangs on a hair
};

/// All findings of a report, by name: "order.ode-step-double".
class Findings {
 public:
  /// Throws std::logic_error when the name is taken: every number is measured in one place.
  void add(const std::string& name, Finding finding);

  /// Null when no experiment said anything under that name.
  const Finding* find(std::string_view name) const;

  const std::map<std::string, Finding, std::less<>>& all() const { return findings_; }

 private:
  std::map<std::string, Finding, std::less<>> findings_;
};

}  // namespace odeval::report
