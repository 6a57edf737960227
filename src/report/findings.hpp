#pragma once
// The numbers that experiments measured and claims are judged by.
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace odeval::report {

/// One measured number. A number that could not be had keeps its place and says why.
struct Finding {
  std::string meaning;          // one line, for the page
  std::string unit;             // empty: a ratio or a count
  std::optional<double> value;  // empty: see `missing`
  double uncertainty = 0;       // half width: the reference's own error, or a fit's 95 % interval
  std::string missing;          // why there is no value
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
