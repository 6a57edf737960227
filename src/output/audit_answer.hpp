#pragma once
// The answer of an audit, for a terminal and for programs.
#include <filesystem>
#include <string>

#include "odeval/audit.hpp"
#include "output/file.hpp"

namespace odeval {

/// At most 25 lines.
std::string audit_text(const audit::Answer& answer);

/// answer.json.
std::string audit_json(const audit::Answer& answer);

/// steps.csv: a row a step of the program.
class AuditSteps {
 public:
  explicit AuditSteps(const std::filesystem::path& file);
  void add(const audit::StepRow& row);
  void finish() { file_.finish(); }

 private:
  WholeFile file_;
};

}  // namespace odeval
