#pragma once
// Another program, run to its end whatever it does.
#include <string>
#include <utility>
#include <vector>

namespace odeval::run {

struct Program {
  std::vector<std::string> words;  // its name, found as a shell finds it, and its arguments
  std::vector<std::pair<std::string, std::string>> environment;  // in place of or besides this process's
  double timeout_s = 0;
};

struct ProgramEnd {
  int status = 0;     // of exit
  int signal = 0;     // that ended it; 0: none
  bool late = false;  // took longer than it may, and was ended with all that it had started
  double cpu_s = 0;
  std::string last_line;  // that it wrote on standard error
};

/// Reads nothing, and what it writes on standard output goes nowhere. Ends with the process that calls. Throws
/// UserError where there is no such program, MachineError where the machine has no processes.
ProgramEnd run_program(const Program& program);

/// "exit status 3", "signal 11 (Segmentation fault)", "ended after 60 s".
std::string end_text(const ProgramEnd& end, double timeout_s);

/// As one text and back, for the answer of a worker.
std::string packed(const ProgramEnd& end);
ProgramEnd unpacked(const std::string& text);

}  // namespace odeval::run
