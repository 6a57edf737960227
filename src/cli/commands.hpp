#pragma once
// The commands of the program: one row each, one file each. Parsing, help and `odeval list` read this table.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace odeval::cli {

class Flags;

/// Runs a parsed command and returns the exit status.
using Action = std::function<int()>;

struct Command {
  std::string_view name;
  std::string_view summary;
  Action (*attach)(Flags& flags);  // adds the command's options to its part of the command line
};

std::span<const Command> commands();

/// The program's command line: every command with its flags.
class CommandLine {
 public:
  CommandLine();
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// What the words after the program's name ask for, not yet done. Throws UserError.
  Action read(std::vector<std::string> words);

 private:
  std::unique_ptr<CLI::App> app_;
  std::vector<std::pair<CLI::App*, Action>> actions_;
};

Action attach_list(Flags& flags);
Action attach_run(Flags& flags);
Action attach_bench(Flags& flags);
Action attach_sweep(Flags& flags);
Action attach_merge(Flags& flags);
Action attach_recommend(Flags& flags);
Action attach_snapshot(Flags& flags);
Action attach_check(Flags& flags);
Action attach_compare(Flags& flags);
Action attach_convert(Flags& flags);
Action attach_audit(Flags& flags);
Action attach_judge(Flags& flags);
Action attach_report(Flags& flags);

}  // namespace odeval::cli
