// odeval manual and odeval completion: what --help says, as man and shells want it.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"

namespace odeval::cli {
namespace {

/// Text for roff: no dash is a hyphen, and no line begins a request.
std::string roff(const std::string& text) {
  std::string out = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char letter : text) {
    if (letter == '\\') {
      out += "\\e";
    } else if (letter == '-') {
      out += "\\-";
    } else {
      out += letter == '\n' ? ' ' : letter;
    }
  }
  return out;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string synopsis(const CommandHelp& command) {
  std::string text = bold("odeval " + command.name);
  for (const FlagHelp& flag : command.flags) {
    if (!flag.required) continue;
    text += flag.argument ? " " + italic(flag.name) : " " + bold(flag.name) + " " + italic(flag.value);
  }
  return text + " [" + italic("flags") + "]";
}

std::string paragraph(const FlagHelp& flag) {
  std::string text = ".TP\n" + (flag.argument ? italic(flag.name) : bold(flag.name));
  if (!flag.value.empty() && !flag.argument) text += " " + italic(flag.value);
  text += "\n" + roff(flag.meaning);
  if (!flag.choices.empty()) {
    text += ":";
    for (const std::string& choice : flag.choices) text += " " + bold(choice);
  }
  return text + (flag.required ? "; required" : "") + "\n";
}

/// Flags that every command with scenarios has are told once.
std::string manual_page(const std::vector<CommandHelp>& commands) {
  std::string text = fmt::format(
      ".TH ODEVAL 1 \"\" \"odeval {}\" \"User Commands\"\n.SH NAME\nodeval \\- how far can you trust the Open Dynamics "
      "Engine, and with which settings?\n.SH SYNOPSIS\n{} {} [{}]\n.br\n{} {} {}\n.SH COMMANDS\n",
      roff(catalogue::versions().front().second), bold("odeval"), italic("command"), italic("flags"), bold("odeval"),
      italic("command"), bold("--help"));
  std::vector<FlagHelp> shared;
  std::string shared_heading;
  for (const CommandHelp& command : commands) {
    text += ".SS " + synopsis(command) + "\n" + roff(command.summary) + "\n";
    std::string heading;
    bool has_shared = false;
    for (const FlagHelp& flag : command.flags) {
      if (flag.group.starts_with("Settings")) {
        has_shared = true;
        shared_heading = flag.group;
        if (std::ranges::find(shared, flag.name, &FlagHelp::name) == shared.end()) shared.push_back(flag);
        continue;
      }
      if (flag.group != heading && flag.group != "Options" && flag.group != "Positionals") {
        text += ".PP\n" + roff(flag.group) + "\n";
      }
      heading = flag.group;
      text += paragraph(flag);
    }
    if (has_shared) text += ".PP\nand settings, below\n";
  }
  text += ".SH SETTINGS\n" + roff(shared_heading) + "\n";
  for (const FlagHelp& flag : shared) text += paragraph(flag);
  text +=
      ".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\na tolerance failed, a run diverged, two folders differ, or nothing keeps "
      "a "
      "budget\n.TP\n2\nbad input; nothing was written\n.TP\n3\ncould not write, or another fault of the machine\n.TP\n"
      "128 + signal\nstopped\n.SH ENVIRONMENT\n.TP\n" +
      bold("NO_COLOR") + "\nwithout colours, on a terminal as well\n";
  return text;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<std::string> flag_names(const CommandHelp& command) {
  std::vector<std::string> names;
  for (const FlagHelp& flag : command.flags) {
    if (!flag.argument) names.push_back(flag.name);
  }
  names.emplace_back("--help");
  return names;
}

/// What may stand for a value, as words of a shell function: a list, names that the program knows, files.
std::string values_of(const FlagHelp& flag) {
  if (!flag.choices.empty()) return "words " + joined(flag.choices);
  if (flag.name == "--method") return "names methods";
  if (flag.name == "--set" || flag.name == "--grid") return "names keys";
  if (flag.name == "SCENARIO" || flag.name == "--scenario") return "names scenarios";
  if (flag.value == "DIR") return "folders";
  return "files";
}

/// One function for both shells: what stands before the cursor decides which list it is.
std::string cases(const std::vector<CommandHelp>& commands) {
  std::string text;
  for (const CommandHelp& command : commands) {
    text += "    " + command.name + ")\n      case $before in\n";
    std::string argument = "files";
    for (const FlagHelp& flag : command.flags) {
      if (flag.argument) {
        argument = values_of(flag);
      } else if (!flag.value.empty()) {
        text += "        " + flag.name + ") _odeval_values " + values_of(flag) + " ;;\n";
      }
    }
    text += "        *) _odeval_flags_or " + joined(flag_names(command)) + " -- " + argument + " ;;\n      esac ;;\n";
  }
  return text;
}

std::string bash_completion(const std::vector<CommandHelp>& commands) {
  std::vector<std::string> names;
  for (const CommandHelp& command : commands) names.push_back(command.name);
  return fmt::format(R"sh(# bash completion of odeval
_odeval_values() {{
  local kind=$1
  shift
  case $kind in
    words) mapfile -t COMPREPLY < <(compgen -W "$*" -- "$word") ;;
    names) # after the last comma, too
      local begun=""
      [[ $word == *,* ]] && begun=${{word%,*}},
      mapfile -t COMPREPLY < <(compgen -P "$begun" -W "$("$program" list --names "$1" 2>/dev/null)" -- "${{word##*,}}")
      [[ $1 == scenarios ]] && mapfile -t -O ${{#COMPREPLY[@]}} COMPREPLY < <(compgen -f -X '!*.toml' -- "$word") ;;
    folders) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
    files) mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
  esac
}}
_odeval_flags_or() {{
  local flags=()
  while [[ $1 != -- ]]; do
    flags+=("$1")
    shift
  done
  shift
  if [[ $word == -* ]]; then
    _odeval_values words "${{flags[@]}}"
  else
    _odeval_values "$@"
  fi
}}
_odeval() {{
  local program=$1 word=$2 before=$3
  if ((COMP_CWORD == 1)); then
    _odeval_values words {} --help --version
    return
  fi
  case ${{COMP_WORDS[1]}} in
{}  esac
}}
complete -o filenames -F _odeval odeval
)sh",
                     joined(names), cases(commands));
}

std::string zsh_completion(const std::vector<CommandHelp>& commands) {
  std::string described;
  for (const CommandHelp& command : commands) {
    std::string summary = command.summary;
    std::erase(summary, '\'');
    described += fmt::format("    '{}:{}'\n", command.name, summary);
  }
  return fmt::format(R"sh(#compdef odeval
# zsh completion of odeval
_odeval_values() {{
  local kind=$1
  shift
  case $kind in
    words) compadd -- "$@" ;;
    names)
      compset -P '*,'
      compadd -- $("$program" list --names "$1" 2>/dev/null)
      [[ $1 == scenarios ]] && _files -g '*.toml' ;;
    folders) _files -/ ;;
    files) _files ;;
  esac
}}
_odeval_flags_or() {{
  local -a flags
  while [[ $1 != -- ]]; do
    flags+=("$1")
    shift
  done
  shift
  if [[ $word == -* ]]; then
    compadd -- $flags
  else
    _odeval_values "$@"
  fi
}}
_odeval() {{
  local program=$words[1] word=$words[CURRENT] before=$words[CURRENT-1]
  local -a commands
  commands=(
{}  )
  if ((CURRENT == 2)); then
    _describe command commands
    return
  fi
  case $words[2] in
{}  esac
}}
if [[ $funcstack[1] == _odeval ]]; then _odeval "$@"; else compdef _odeval odeval; fi
)sh",
                     described, cases(commands));
}

}  // namespace

Action attach_completion(Flags& flags) {
  const auto shell = std::make_shared<std::string>();
  flags.add_option("SHELL", *shell, "for which shell; bash reads it by 'source <(odeval completion bash)'")
      .one_of({"bash", "zsh"})
      .required();
  return [shell] {
    const std::vector<CommandHelp> help = CommandLine().help();
    std::cout << (*shell == "bash" ? bash_completion(help) : zsh_completion(help));
    return 0;
  };
}

Action attach_manual(Flags&) {
  return [] {
    std::cout << manual_page(CommandLine().help());
    return 0;
  };
}

}  // namespace odeval::cli
