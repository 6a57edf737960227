#include "cli/commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <tuple>

#include "catalogue/versions.hpp"
#include "cli/flags.hpp"
#include "model/nearest.hpp"
#include "odeval/error.hpp"

namespace odeval::cli {
namespace {

constexpr std::array table{
    Command{"list", "scenarios, methods, metrics, keys of scenario files, commands and versions of this build",
            attach_list},
    Command{"run", "traces, summaries and energy drift of one scenario", attach_run},
    Command{"bench", "timing table, methods interleaved, no output while timing", attach_bench},
    Command{"sweep", "a grid of settings in every method, on every core; stopped, it goes on where it was",
            attach_sweep},
    Command{"merge", "the shards of one sweep as one table", attach_merge},
    Command{"recommend", "the cheapest settings that keep an error, and the runs that prove it", attach_recommend},
    Command{"snapshot", "pictures of poses: single, on a sheet, or the run as a film", attach_snapshot},
    Command{"check", "every tolerance of the scenario files; exit status 1 if one fails", attach_check},
    Command{"compare", "two folders of results: same bytes, same within uncertainty, or different (exit 1)",
            attach_compare},
    Command{"convert", "the scenario file of a robot's file (URDF, SDFormat), and what of it was not taken",
            attach_convert},
    Command{"audit", "how wrong is a running ODE program? It is run unchanged and at smaller steps", attach_audit},
    Command{"judge", "a trace of one's own beside a scenario's reference, or beside its run at half the step",
            attach_judge},
    Command{"plot", "any columns of any traces as SVG or PNG, or their difference from the reference", attach_plot},
    Command{"report", "all of it, and the verdicts on the 2010 report's claims, as one page", attach_report},
    Command{"completion", "what a shell completes commands, flags and names from", attach_completion},
    Command{"manual", "the manual page: odeval manual | man -l -", attach_manual},
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// What CLI11 found wrong, in the words of the other messages.
std::string in_plain_words(const CLI::ParseError& error) {
  const std::string said = first_line(error.what());
  const std::string flag = said.substr(0, said.find(':'));
  if (said.find(": At Most 1 required") != std::string::npos) return flag + ": is given more than once; give it once";
  if (said.ends_with(" missing")) return flag + ": a value is missing";
  if (said == "A subcommand is required") return "a command is missing";
  const std::string_view unread = "Could not convert: ";
  if (said.starts_with(unread)) return said.substr(unread.size()) + ": is a flag, which takes no value";
  return said;
}

/// CLI11 knows what was wrong; this adds the nearest flag or command that would be right.
[[noreturn]] void refuse(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = app.get_subcommands().empty() ? &app : app.get_subcommands().front();
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  if (command == &app) {
    for (const Command& row : table) known.emplace_back(row.name);
  }
  const std::string who = command == &app ? "odeval" : "odeval " + command->get_name();
  std::vector<std::string> extra = app.remaining(true);
  std::erase(extra, "--");  // after which no word is a flag
  if (!extra.empty()) {
    // A flag that nobody knows leaves its value over, and all that follows.
    const auto flag = std::ranges::find_if(extra, [](const std::string& word) { return word.starts_with("-"); });
    const std::string& wrong = flag != extra.end() ? *flag : extra.front();
    if (command != &app && !wrong.starts_with("-")) {
      throw UserError(wrong + ": one argument too many; '" + who + " --help' shows all");
    }
    throw UserError(wrong + ": no such " + (command == &app ? "command" : "flag") + nearest_hint(wrong, known) + "; '" +
                    who + " --help' shows all");
  }
  throw UserError(in_plain_words(error) + "; '" + who + " --help' shows how");
}

/// "TEXT:{a, b}" is a value of those choices, "DIR" one of any text.
std::pair<std::string, std::vector<std::string>> value_and_choices(const std::string& type) {
  const std::size_t brace = type.find(":{");
  if (brace == std::string::npos) return {type, {}};
  std::vector<std::string> choices(1);
  for (const char letter : type.substr(brace + 2, type.find('}') - brace - 2)) {
    if (letter == ',') {
      choices.emplace_back();
    } else if (letter != ' ') {
      choices.back() += letter;
    }
  }
  return {"WORD", choices};
}

}  // namespace

std::span<const Command> commands() { return table; }

CommandLine::CommandLine()
    : app_(std::make_unique<CLI::App>(
          "odeval: how far can you trust the Open Dynamics Engine, and with which settings?", "odeval")) {
  app_->set_version_flag("--version", [] { return "odeval " + catalogue::versions().front().second; });
  app_->require_subcommand(1);
  for (const Command& row : table) {
    CLI::App* part = app_->add_subcommand(std::string(row.name), std::string(row.summary));
    Flags flags(*part);
    const Action action = row.attach(flags);
    actions_.emplace_back(part, [action, flags] {
      try {
        return action();
      } catch (const UserError& error) {
        throw UserError(flags.retold(error.what()));
      }
    });
  }
}

CommandLine::~CommandLine() = default;

std::vector<CommandHelp> CommandLine::help() const {
  std::vector<CommandHelp> all;
  for (const auto& [part, action] : actions_) {
    CommandHelp& command = all.emplace_back(CommandHelp{part->get_name(), part->get_description(), {}});
    for (const CLI::Option* option : part->get_options()) {
      if (option->get_group().empty() || option == part->get_help_ptr()) continue;
      FlagHelp flag;
      flag.argument = option->get_positional();
      flag.name = flag.argument ? option->get_name() : "--" + option->get_lnames().front();
      std::tie(flag.value, flag.choices) =
          value_and_choices(option->get_type_size() == 0 ? "" : option->get_type_name());
      flag.meaning = option->get_description();
      flag.group = option->get_group();
      flag.required = option->get_required();
      command.flags.push_back(std::move(flag));
    }
  }
  return all;
}

Action CommandLine::read(std::vector<std::string> words) {
  std::ranges::reverse(words);  // as the parser wants them
  try {
    app_->parse(std::move(words));
  } catch (const CLI::Success& asked_for_help) {
    return [this, asked_for_help] { return app_->exit(asked_for_help); };
  } catch (const CLI::ParseError& error) {
    refuse(*app_, error);
  }
  return std::ranges::find_if(actions_, [](const auto& action) { return action.first->parsed(); })->second;
}

}  // namespace odeval::cli
