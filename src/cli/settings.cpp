#include "cli/settings.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <string_view>

#include "catalogue/paths.hpp"
#include "odeval/error.hpp"
#include "odeval/metrics.hpp"
#include "output/number.hpp"
#include "scenario/find_scenario.hpp"
#include "scenario/scenario_keys.hpp"

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

}  // namespace

CLI::Validator number_within(double least, double most) {
  const std::string range = number_text(least) + " to " + number_text(most);
  const auto refuse = [=](const std::string& text) {
    double number = NAN;
    const bool right = CLI::detail::lexical_cast(text, number) && number >= least && number <= most;
    return right ? "" : "must be a number from " + range + ", not " + text;
  };
  return {refuse, ""};
}

CLI::Validator whole_within(long least, long most) {
  const auto refuse = [=](const std::string& text) {
    long number = 0;
    const bool right = CLI::detail::lexical_cast(text, number) && number >= least && number <= most;
    return right ? "" : fmt::format("must be a whole number from {} to {}, not {}", least, most, text);
  };
  return {refuse, ""};
}

void Settings::attach(CLI::App& app) {
  for (const char* key : flag_keys) {
    const KeyRow& row = row_of(key);
    Flag& flag = flags_.emplace_back(Flag{flag_of(key), key, ""});
    flag.option = app.add_option(flag.flag, flag.value, std::string(row.meaning))
                      ->type_name(row.unit.empty() ? "VALUE" : std::string(row.unit))
                      ->group("Settings, each on top of the scenario file");
  }
  app.add_option("--set", sets_, "any key of the file, e.g. --set links.0.mass=2 --set q0=[1.0,0.5]")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->group("Settings, each on top of the scenario file");
}

std::filesystem::path scenario_file(const std::string& name_or_path) {
  return find_scenario(name_or_path, catalogue::scenario_folder());
}

Scenario Settings::read(const std::string& name_or_path) const {
  return read_scenario(scenario_file(name_or_path), overrides(), known_names());
}

std::vector<Override> Settings::overrides() const {
  std::vector<Override> overrides;
  for (const Flag& flag : flags_) {
    if (flag.option->count() > 0) overrides.push_back({flag.key, flag.value, flag.flag});
  }
  for (const std::string& set : sets_) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw UserError("--set " + set + ": must be KEY=VALUE, e.g. --set links.0.mass=2");
    }
    overrides.push_back({set.substr(0, equals), set.substr(equals + 1), "--set"});
  }
  return overrides;
}

void add_method_option(CLI::App& app, std::vector<std::string>& methods) {
  app.add_option("--method", methods, "one or several, with commas; default: the scenario's own list")
      ->type_name("M[,M...]")
      ->delimiter(',')
      ->allow_extra_args(false);
}

void add_out_option(CLI::App& app, std::string& out) {
  app.add_option("--out", out, "folder of the results")
      ->type_name("DIR")
      ->check([](const std::string& folder) { return folder.empty() ? std::string("must name a folder") : ""; })
      ->capture_default_str();
}

std::vector<const catalogue::Method*> chosen_methods(const std::vector<std::string>& asked, const Scenario& scenario) {
  std::vector<const catalogue::Method*> chosen;
  for (const std::string& word : asked) {
    const std::string name = CLI::detail::trim_copy(word);
    const catalogue::Method& method = catalogue::find_method(name);
    catalogue::require_claim(method, *scenario.problem, "--method");
    if (std::ranges::find(chosen, &method) == chosen.end()) chosen.push_back(&method);
  }
  if (!asked.empty()) return chosen;

  std::string missing;
  for (const catalogue::Method& method : catalogue::methods()) {
    if (std::ranges::find(scenario.methods, method.name) == scenario.methods.end()) continue;
    catalogue::require_claim(method, *scenario.problem, scenario.file + ": methods");
    if (method.make != nullptr) {
      chosen.push_back(&method);
    } else {
      missing += (missing.empty() ? "" : ", ") + std::string(method.name);
    }
  }
  if (!missing.empty())
    std::cerr << "odeval: " << scenario.name << ": left out: " << missing << "; " << catalogue::why_missing << '\n';
  if (chosen.empty()) throw UserError(scenario.file + ": methods: names none to run; give --method M[,M...]");
  return chosen;
}

Names known_names() {
  Names names{catalogue::method_names(), {}};
  for (const auto& row : metric_table()) names.metrics.emplace_back(row.name);
  return names;
}

}  // namespace odeval::cli
