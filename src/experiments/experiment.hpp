#pragma once
// Experiments: each measures one question, and leaves numbers for its section of the page and findings for the claims.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "catalogue/evaluation.hpp"
#include "odeval/scenario.hpp"
#include "report/document.hpp"
#include "report/findings.hpp"
#include "report/prose.hpp"

namespace odeval::experiments {

/// What experiments share: the scenarios as their files have them, and the runs of those that several look at.
class Laboratory {
 public:
  /// Reads a scenario of the program's own folder by name.
  explicit Laboratory(std::function<Scenario(const std::string& name)> read);

  /// The scenario as its file has it.
  const Scenario& scenario(const std::string& name);
  /// The evaluator of the scenario as its file has it; solves the reference once.
  catalogue::Evaluator& evaluator(const std::string& name);
  /// The run of the scenario as its file has it; done once. Null when the build lacks the method.
  const catalogue::Evaluation* run(const std::string& name, std::string_view method);

 private:
  struct Case {
    std::unique_ptr<catalogue::Evaluator> evaluator;
    std::map<std::string, catalogue::Evaluation, std::less<>> runs;
  };
  Case& at(const std::string& name);

  std::function<Scenario(const std::string&)> read_;
  std::map<std::string, Case, std::less<>> cases_;
};

struct Experiment {
  std::string_view name;   // of the section: "contact-delay"
  std::string_view prose;  // the section's template, text/NAME.mustache
  /// Measures. What cannot be measured (a method the build lacks) becomes a Missing cell and a Finding without a value,
  /// never an exception.
  report::Content (*run)(Laboratory& laboratory, report::Findings& findings);
};

/// Runs an experiment and puts what it measures into its template.
report::Section section_of(const Experiment& experiment, Laboratory& laboratory, report::Findings& findings);

/// The one table, in the order of the page.
std::span<const Experiment> experiments();

/// What experiments are made of.

/// Null when the build lacks the method (a single-precision ODE).
const catalogue::Method* available(std::string_view method);

/// The colour that a method has in all figures; grey for those that are only there to compare with.
int colour_of(std::string_view method);

/// At most `most` rows, evenly spread, first and last included: what a plot can show.
Column thinned(const Column& column, std::size_t most = 800);

}  // namespace odeval::experiments
