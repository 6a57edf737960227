// odeval list: what this build can do.
#include <algorithm>
#include <array>
#include <iostream>

#include "catalogue/methods.hpp"
#include "catalogue/paths.hpp"
#include "catalogue/versions.hpp"
#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/settings.hpp"
#include "model/find_scenario.hpp"
#include "model/scenario_keys.hpp"
#include "odeval/metrics.hpp"
#include "output/listing.hpp"

namespace odeval::cli {
namespace {

constexpr std::array kinds{"scenarios", "methods", "metrics", "keys", "commands", "versions"};

struct Options {
  bool json = false;
  std::string kind;   // empty: all
  std::string names;  // a kind, of which the names alone
};

/// Keys as --set and --grid take them; of a list of tables those of the first.
Listing keys() {
  Listing listing{"keys", {}};
  // Their names would fill a page, and have listings of their own.
  const Names names{{"the methods"}, {"the metrics"}};
  for (const KeyRow& row : key_table()) {
    std::string path;
    for (const SectionRow& section : section_table()) {
      if (section.name != row.section) continue;
      path = std::string(section.name) + (section.list ? ".0." : ".");
      if (section.inner()) path.insert(path.find('.'), ".0");
    }
    const std::string fallback = row.required() ? "required" : "default: " + std::string(row.fallback);
    listing.rows.push_back(
        {path + std::string(row.name), std::string(row.meaning) + "; " + rule_of(row, names) + "; " + fallback});
  }
  return listing;
}

/// The engines beside ODE have to be loaded for theirs.
Listing versions() {
  Listing listing{"versions", catalogue::versions()};
  for (const auto& engine : catalogue::engine_versions()) listing.rows.push_back(engine);
  return listing;
}

std::vector<Listing> listings() {
  Listing scenarios{"scenarios", {}};
  for (const std::string& name : scenario_names(catalogue::scenario_folder())) {
    const Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, known_names());
    scenarios.rows.push_back({name, scenario.summary});
  }
  Listing methods{"methods", {}};
  for (const auto& method : catalogue::methods()) {
    const std::string missing = method.make == nullptr ? " (not in this build)" : "";
    methods.rows.push_back(
        {std::string(method.name), std::string(method.formulation) + ": " + std::string(method.advanced_by) + missing});
  }
  Listing metrics{"metrics", {}};
  for (const Quantity& row : quantities) {
    const std::string unit = row.unit.empty() ? "" : ", " + std::string(row.unit);
    metrics.rows.push_back({std::string(row.name), std::string(row.meaning) + unit});
  }
  Listing names{"commands", {}};
  for (const Command& command : commands()) {
    names.rows.push_back({std::string(command.name), std::string(command.summary)});
  }
  return {scenarios, methods, metrics, keys(), names};
}

int list(const Options& options) {
  std::vector<Listing> all = listings();
  if ((options.kind.empty() && options.names.empty()) || options.kind == "versions" || options.names == "versions") {
    all.push_back(versions());
  }
  if (!options.kind.empty()) std::erase_if(all, [&](const Listing& listing) { return listing.name != options.kind; });
  if (!options.names.empty()) {
    const auto wanted = std::ranges::find(all, options.names, &Listing::name);
    for (const auto& row : wanted->rows) std::cout << row.first << '\n';
  } else {
    std::cout << (options.json ? listing_json(all) : listing_text(all));
  }
  return 0;
}

}  // namespace

Action attach_list(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("KIND", options->kind, "only one kind; default: all").one_of({kinds.begin(), kinds.end()});
  flags.add_flag("--json", options->json, "print JSON");
  flags.add_option("--names", options->names, "only the names of one kind, one a line")
      .one_of({kinds.begin(), kinds.end()})
      .excludes("KIND");
  return [options] { return list(*options); };
}

}  // namespace odeval::cli
