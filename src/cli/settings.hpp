#pragma once
// The settings every command that runs scenarios shares: flags on top of the scenario file.
#include <deque>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "catalogue/methods.hpp"
#include "cli/flags.hpp"
#include "cli/robots.hpp"
#include "model/read_scenario.hpp"

namespace odeval::cli {

class Settings {
 public:
  /// Adds `--step`, `--duration`, ... and `--set` to a command.
  void attach(Flags& flags);

  /// Reads a scenario by name or path with the flags on top. Of a robot's file a line on standard error says that rules
  /// were applied. Throws UserError.
  Scenario read(const std::string& name_or_path) const;
  /// The same of a file, without that line.
  Scenario read_file(const std::filesystem::path& file) const;

  /// How robots' files are read. Throws UserError where the flags say so and the file is none.
  ImportOptions import_options(const std::filesystem::path& file) const;

  /// The flags that were typed, in the order in which they count. Throws UserError where two give the same key.
  std::vector<Override> overrides() const;

  /// "FILE: KEY must ..." as "--set KEY=VALUE: KEY must ...", where a flag gave the key; else as it is.
  std::string retold(const std::string& message) const;

 private:
  struct KeyFlag {
    std::string name;
    std::string key;
    std::string value;
    Flag flag;  // knows whether it was typed
  };
  std::deque<KeyFlag> flags_;  // stable addresses: the parser writes into them
  std::vector<std::string> sets_;
  RobotFlags robot_;
};

/// `--method M[,M...]` and `--out DIR`, as every command that has them spells them.
void add_method_option(Flags& flags, std::vector<std::string>& methods);
void add_out_option(Flags& flags, std::string& out);
/// Sets it to the cores that this process may use, and adds `--jobs`.
void add_jobs_option(Flags& flags, int& jobs);

/// The methods to run: those asked for, or else the scenario's own list. A method of that list that is missing in this
/// build is left out with a line on stderr; one that was asked for is a UserError.
/// `settings` are blamed for what they make wrong.
std::vector<const catalogue::Method*> chosen_methods(const std::vector<std::string>& asked, const Scenario& scenario,
                                                     const std::vector<Override>& settings = {});

/// A scenario in the methods chosen for it.
struct Chosen {
  Scenario scenario;
  std::vector<const catalogue::Method*> methods;
};

/// Throws UserError for a setting of an engine that none of the methods reads in its scenario.
void require_read(const std::vector<Override>& settings, std::span<const Chosen> chosen);

/// Throws UserError for a setting that a search chooses itself: a key of `searched`. `who` chooses it.
void refuse_searched(const std::vector<Override>& settings, std::span<const std::string_view> searched,
                     const std::string& who);

/// What has to be typed for a setting: `--erp 1`, or `--set ode.rotation=finite` where a key has no flag of its own.
std::string as_flag(const std::string& key, const std::string& value);

/// The file of a scenario by name or path. Throws UserError.
std::filesystem::path scenario_file(const std::string& name_or_path);

/// The words a scenario file may use for methods and metrics, from the catalogues.
Names known_names();

/// Names of the scenarios that come with the program and that this build has a reference for; of the others a line each
/// on standard error says why they are left out.
std::vector<std::string> shipped_scenarios();

}  // namespace odeval::cli
