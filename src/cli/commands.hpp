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

/// A flag or an argument, as the help says it.
struct FlagHelp {
  std::string name;   // "--until", "SCENARIO"
  std::string value;  // "T"; empty: it takes none
  std::string meaning;
  std::string group;                 // its heading
  std::vector<std::string> choices;  // what a value may be; empty: anything
  bool argument = false;             // without dashes
  bool required = false;
};

struct CommandHelp {
  std::string name;
  std::string summary;
  std::vector<FlagHelp> flags;
};

/// The program's command line: every command with its flags.
class CommandLine {
 public:
  CommandLine();
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// What the words after the program's name ask for, not yet done. Throws UserError.
  Action read(std::vector<std::string> words);

  /// What `--help` says, for whoever says it otherwise.
  std::vector<CommandHelp> help() const;

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
Action attach_plot(Flags& flags);
Action attach_completion(Flags& flags);
Action attach_manual(Flags& flags);
Action attach_report(Flags& flags);

}  // namespace odeval::cli
