#pragma once
// The runs of a program that an audit takes, and what they say together.
#include <string>
#include <vector>

namespace odeval::cli {

inline std::vector<std::string> default_refinements() { return {"1", "2", "4", "8"}; }

struct AuditOptions {
  std::vector<std::string> program;
  std::vector<std::string> refine = default_refinements();
  std::string hold = "springs";
  std::string contacts = "renewed";
  std::vector<std::string> tries;
  bool accurate = false;
  std::string clock = "wall";
  double tick_s = 1.0 / 60;
  double until_s = 0;
  double timeout_s = 60;
  double records_gb = 4;
  int jobs = 1;
  std::string out = "results";
  bool film = false;
  bool quiet = false;
  bool json = false;
};

/// Runs the program, writes the answer and says it. Returns the exit status.
int run_audit(const AuditOptions& options);

}  // namespace odeval::cli
