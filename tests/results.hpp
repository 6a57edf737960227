#pragma once
// What a run writes, as its files have it, beside what it was made from.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "catalogue/paths.hpp"
#include "catalogue/summaries.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "output/trace_csv.hpp"
#include "tests/check.hpp"

namespace odeval::test {

/// A trace as its file has it.
class Table {
 public:
  explicit Table(const std::string& text) : csv_(parse_csv(text, "trace")) {}

  std::size_t rows() const { return csv_.columns[0].size(); }
  bool has(const std::string& name) const { return std::ranges::find(csv_.header, name) != csv_.header.end(); }
  const Column& operator[](const std::string& name) const {
    const auto found = std::ranges::find(csv_.header, name);
    if (found == csv_.header.end()) throw std::runtime_error("no column " + name);
    return csv_.columns[static_cast<std::size_t>(found - csv_.header.begin())];
  }
  Vec3 vector(const std::string& letter, const std::string& body, std::size_t row) const {
    return {(*this)[letter + "x" + body][row], (*this)[letter + "y" + body][row], (*this)[letter + "z" + body][row]};
  }
  /// Where an axis of the body points.
  Vec3 axis(const std::string& body, std::size_t axis, std::size_t row) const {
    const std::string column = std::to_string(axis + 1);
    return {(*this)["r" + body + "1" + column][row], (*this)["r" + body + "2" + column][row],
            (*this)["r" + body + "3" + column][row]};
  }

 private:
  CsvColumns csv_;
};

struct Results {
  Scenario scenario;
  const catalogue::Method* method;
  Reference reference;
  std::string csv;
  std::string summary;
  std::string table;  // summary.csv, with this method alone
};

inline Results results_of(const char* name, const std::vector<Override>& settings, const char* method) {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  const Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), settings, names);
  catalogue::Evaluator evaluator(scenario);
  const auto run = evaluator.evaluate(catalogue::find_method(method));
  const RunSummary summary = catalogue::summarise(run, evaluator);
  return {
      scenario, run.method, evaluator.reference(), trace_csv(run.trace), summary_json(summary), summary_csv({summary})};
}

inline std::string number(std::size_t i) { return std::to_string(i + 1); }

/// A run to look at.
struct Case {
  const char* scenario;
  std::vector<Override> settings;
  const char* method;
};

/// One of each family of scenarios and methods.
inline const std::vector<Case>& cases() {
  static const std::vector<Override> second{{"duration", "1", ""}};
  static const std::vector<Override> two_seconds{{"duration", "2", ""}};
  static const std::vector<Override> five_links{{"duration", "0.5", ""}, {"n", "5", ""}};
  static const std::vector<Case> all{
      {"double_pendulum", two_seconds, "ode-step-double"},
      {"double_pendulum", two_seconds, "ode-rk4-double"},
      {"double_pendulum", two_seconds, "maximal-rk4"},
      {"double_pendulum", two_seconds, "lagrange-ode45"},
      {"double_pendulum", two_seconds, "lagrange-euler"},
      {"chain", five_links, "ode-quickstep-double"},
      {"chain", five_links, "lagrange-rk4"},
      {"potra_pendulum", second, "ode-step-double"},
      {"wall_pendulum", second, "lagrange-rk4"},
      {"wall_pendulum", second, "ode-step-double"},
      {"free_box", second, "ode-quickstep-double"},
      {"free_box", second, "analytic"},
      {"thin_body", second, "ode-step-double"},
      {"bouncing_ball", second, "ode-rk4-double"},
      {"bouncing_ball", second, "ode-step-double"},
      {"friction_slide", {}, "ode-step-double"},
      {"friction_slide", {}, "analytic"},
      {"spring_joint", second, "ode-step-double"},
      {"open_hinge", {}, "ode-quickstep-double"},
      {"open_hinge", {}, "ode-step-double"},
  };
  return all;
}

/// Says of which run it was where one of its checks fails.
template <class Check>
void check_all(const Check& check) {
  for (const Case& one : cases()) {
    const int before = failures;
    check(results_of(one.scenario, one.settings, one.method));
    if (failures > before) std::printf("  of %s, %s\n", one.scenario, one.method);
  }
}

}  // namespace odeval::test
