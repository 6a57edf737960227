#include "cli/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <string_view>

#include "catalogue/paths.hpp"
#include "catalogue/self_converged.hpp"
#include "model/find_scenario.hpp"
#include "model/scenario_keys.hpp"
#include "odeval/error.hpp"
#include "odeval/metrics.hpp"
#include "output/number.hpp"

namespace odeval::cli {
namespace {

// Keys of the scenario file with a flag of their own. Any other key goes through --set.
constexpr std::array flag_keys{"step",
                               "duration",
                               "sample",
                               "rtol",
                               "atol",
                               "ode.erp",
                               "ode.cfm",
                               "ode.kp",
                               "ode.kd",
                               "ode.iterations",
                               "ode.sor_w",
                               "ode.bounce",
                               "ode.bounce_vel",
                               "ode.max_correcting_vel",
                               "ode.surface_layer",
                               "ode.start",
                               "ode.seed"};

std::string flag_of(std::string key) {
  key = key.substr(key.find('.') + 1);
  std::ranges::replace(key, '_', '-');
  return "--" + key;
}

const KeyRow& row_of(std::string_view key) {
  const auto rows = key_table();
  return *std::ranges::find_if(rows, [&](const KeyRow& row) {
    return key == (row.section.empty() ? "" : std::string(row.section) + ".") + std::string(row.name);
  });
}

/// What stands for a value in the help: its unit, or the words that it may be, as they stand where a flag checks them.
std::string value_of(const KeyRow& row) {
  if (row.kind == KeyKind::word && row.allowed != nullptr) {
    return fmt::format("TEXT:{{{}}}", fmt::join(row.allowed({}), ", "));
  }
  return row.unit.empty() ? "VALUE" : std::string(row.unit);
}

std::string_view trimmed(std::string_view word) {
  constexpr std::string_view blanks = " \t\n\v\f\r";
  const std::size_t first = word.find_first_not_of(blanks);
  return first == word.npos ? "" : word.substr(first, word.find_last_not_of(blanks) - first + 1);
}

}  // namespace

// What is checked late, when a reference is made, knows the file that was read and not who gave the key.
std::string Settings::retold(const std::string& message) const { return blamed(message, overrides()); }

void Settings::attach(Flags& flags) {
  flags.retell([this](const std::string& message) { return retold(message); });
  for (const char* key : flag_keys) {
    const KeyRow& row = row_of(key);
    KeyFlag& added = flags_.emplace_back(KeyFlag{flag_of(key), key, "", Flag(nullptr)});
    added.flag = flags.add_option(added.name, added.value, std::string(row.meaning));
    added.flag.type_name(value_of(row)).group("Settings, each on top of the scenario file");
  }
  flags.add_option("--set", sets_, "any key of the file, e.g. --set links.0.mass=2 --set q0=[1.0,0.5]")
      .type_name("KEY=VALUE")
      .one_value()
      .group("Settings, each on top of the scenario file");
  robot_.attach(flags);
}

std::string as_flag(const std::string& key, const std::string& value) {
  const bool has_flag = std::ranges::find(flag_keys, key) != flag_keys.end();
  return has_flag ? flag_of(key) + " " + value : "--set " + key + "=" + value;
}

std::filesystem::path scenario_file(const std::string& name_or_path) {
  return find_scenario(name_or_path, catalogue::scenario_folder());
}

Scenario Settings::read(const std::string& name_or_path) const {
  const std::filesystem::path file = scenario_file(name_or_path);
  Scenario scenario = read_file(file);
  tell_of_import(file);
  return scenario;
}

Scenario Settings::read_file(const std::filesystem::path& file) const {
  return read_scenario(file, overrides(), known_names(), import_options(file));
}

ImportOptions Settings::import_options(const std::filesystem::path& file) const { return robot_.options(file); }

std::vector<Override> Settings::overrides() const {
  std::vector<Override> overrides;
  for (const KeyFlag& typed : flags_) {
    if (typed.flag.given()) overrides.push_back({typed.key, typed.value, typed.name});
  }
  for (const std::string& set : sets_) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw UserError("--set " + set + ": must be KEY=VALUE, e.g. --set links.0.mass=2");
    }
    overrides.push_back({set.substr(0, equals), set.substr(equals + 1), "--set"});
  }
  for (auto one = overrides.begin(); one != overrides.end(); ++one) {
    const auto first =
        std::ranges::find_if(overrides, [&](const Override& other) { return overlap(one->key, other.key); });
    if (first != one)
      throw UserError(typed(*one) + ": " + one->key + " has a value from " + typed(*first) + " already");
  }
  return overrides;
}

void require_read(const std::vector<Override>& settings, std::span<const Chosen> chosen) {
  for (const Override& setting : settings) {
    if (!catalogue::is_engine_setting(setting.key)) continue;  // of the motion, or of when it is looked at
    const bool read = std::ranges::any_of(chosen, [&](const Chosen& run) {
      return std::ranges::any_of(run.methods, [&](const catalogue::Method* method) {
        return catalogue::reads(*method, setting.key, run.scenario);
      });
    });
    if (!read) {
      throw UserError(fmt::format("{}: none of the methods of this run reads {}; it is for {}", typed(setting),
                                  setting.key, catalogue::readers_of(setting.key)));
    }
  }
}

void refuse_searched(const std::vector<Override>& settings, std::span<const std::string_view> searched,
                     const std::string& who) {
  for (const Override& setting : settings) {
    if (std::ranges::find(searched, setting.key) == searched.end()) continue;
    throw UserError(fmt::format("{}: is what {} chooses; leave it out", typed(setting), who));
  }
}

void add_method_option(Flags& flags, std::vector<std::string>& methods) {
  flags.add_option("--method", methods, "one or several, with commas; default: the scenario's own list")
      .type_name("M[,M...]")
      .delimiter(',')
      .one_value();
}

void add_out_option(Flags& flags, std::string& out) {
  flags.add_option("--out", out, "folder of the results").type_name("DIR").check(folder_name()).capture_default_str();
}

void add_jobs_option(Flags& flags, int& jobs) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  jobs = ::sched_getaffinity(0, sizeof cores, &cores) == 0 ? std::max(1, CPU_COUNT(&cores)) : 1;
  flags.add_option("--jobs", jobs, "runs at a time; default: one for each core")
      .type_name("N")
      .check(whole_within(1, 1024));
}

namespace {

void require_all_do(std::span<const catalogue::Method* const> methods, const Scenario& scenario,
                    const std::string& origin, const std::vector<Override>& settings) {
  try {
    catalogue::require_does(methods, scenario, origin);
  } catch (const UserError& error) {
    throw UserError(blamed(error.what(), settings));
  }
}

}  // namespace

std::vector<const catalogue::Method*> chosen_methods(const std::vector<std::string>& asked, const Scenario& scenario,
                                                     const std::vector<Override>& settings) {
  std::vector<const catalogue::Method*> chosen;
  for (const std::string& word : asked) {
    const std::string name(trimmed(word));
    const catalogue::Method& method = catalogue::find_method(name);
    if (std::ranges::find(chosen, &method) == chosen.end()) chosen.push_back(&method);
  }
  require_all_do(chosen, scenario, "--method", settings);
  if (!asked.empty()) return chosen;

  std::vector<const catalogue::Method*> named;
  std::map<std::string_view, std::string> missing;  // by why
  for (const catalogue::Method& method : catalogue::methods()) {
    if (std::ranges::find(scenario.methods, method.name) == scenario.methods.end()) continue;
    named.push_back(&method);
    if (method.make != nullptr) {
      chosen.push_back(&method);
    } else {
      std::string& names = missing[method.why_missing];
      names += (names.empty() ? "" : ", ") + std::string(method.name);
    }
  }
  require_all_do(named, scenario, scenario.file + ": methods", settings);
  for (const auto& [why, names] : missing) {
    std::cerr << "odeval: " << scenario.name << ": left out: " << names << "; " << why << '\n';
  }
  if (chosen.empty()) throw UserError(scenario.file + ": methods: names none to run; give --method M[,M...]");
  return chosen;
}

std::vector<std::string> shipped_scenarios() {
  const std::filesystem::path folder = catalogue::scenario_folder();
  std::vector<std::string> names = scenario_names(folder);
  std::erase_if(names, [&](const std::string& name) {
    const Scenario scenario = read_scenario(find_scenario(name, folder), {}, known_names());
    try {
      catalogue::provider_of(scenario);
      return false;
    } catch (const UserError& why) {
      std::cerr << "odeval: " << name << ": left out: " << why.what() << '\n';
      return true;
    }
  });
  return names;
}

Names known_names() {
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  return names;
}

}  // namespace odeval::cli
