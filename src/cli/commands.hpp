#pragma once
// The commands of the program: one row each, one file each. Parsing, help and `odeval list` read this table.
#include <functional>
#include <span>
#include <string_view>

namespace CLI {
class App;
}

namespace odeval::cli {

/// Runs a parsed command and returns the exit status.
using Action = std::function<int()>;

struct Command {
  std::string_view name;
  std::string_view summary;
  Action (*attach)(CLI::App& app);  // adds the command's options to its part of the command line
};

std::span<const Command> commands();

/// Reads the command line and does what it says. Throws UserError and MachineError.
int run_command_line(int argc, char** argv);

Action attach_list(CLI::App& app);
Action attach_run(CLI::App& app);
Action attach_bench(CLI::App& app);
Action attach_sweep(CLI::App& app);
Action attach_merge(CLI::App& app);
Action attach_recommend(CLI::App& app);
Action attach_snapshot(CLI::App& app);
Action attach_check(CLI::App& app);
Action attach_compare(CLI::App& app);
Action attach_report(CLI::App& app);

}  // namespace odeval::cli
