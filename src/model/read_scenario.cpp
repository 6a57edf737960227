#include "model/read_scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "model/draft.hpp"
#include "model/generate.hpp"
#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"

namespace odeval {

namespace {

// The name becomes a folder below the output folder and a cell of tables.
void check_name(const Scenario& scenario) {
  const bool plain = std::all_of(scenario.name.begin(), scenario.name.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '-' || letter == '.';
  });
  if (!plain || scenario.name.empty() || scenario.name.front() == '.') {
    throw UserError(
        fmt::format("{}: a scenario file is named with letters, digits, '_' and '-'", one_line(scenario.file)));
  }
}

/// Wall, ground and joint: there if the problem has them, and no others. Bodies of a mechanism may all fly.
void check_sections(const Draft& draft) {
  const Problem& problem = *draft.said.problem;
  for (const auto& [section, needed] :
       {std::pair{"wall", problem.wall}, std::pair{"ground", problem.ground}, std::pair{"joint", problem.joint}}) {
    if (needed && !draft.tree.contains(section)) {
      draft.fail(section, "", fmt::format("is missing; {} needs [{}]", problem.name, section));
    }
    if (!needed) draft.refuse(section);
  }
  if (!problem.joints) {
    draft.refuse("joints");
    for (const char* key : {"name", "inertia", "centre", "shapes"}) draft.refuse_in("bodies", key);
    for (const char* list : {"springs", "torques", "controllers", "planes", "contacts", "struts"}) draft.refuse(list);
  }
  if (problem.ground && !problem.friction) {
    for (const char* key : {"friction", "friction_model"}) draft.refuse("ground", key);
    draft.refuse("ode", "friction_axes");
  }
}

void check_tolerances(const Draft& draft) {
  for (std::size_t i = 0; i < draft.scenario.tolerances.size(); ++i) {
    const Tolerance& tolerance = draft.scenario.tolerances[i];
    if (!tolerance.at_most && !tolerance.at_least) {
      draft.fail(fmt::format("tolerances.{}", i), "", "must have at_most or at_least");
    }
  }
}

// What no single key can be blamed for is blamed on a setting if there is one.
void check_grid(const Draft& draft) {
  if (draft.scenario.duration_s < draft.scenario.step_s) {
    const bool step_typed = draft.setting_of("step") != nullptr && draft.setting_of("duration") == nullptr;
    const std::string rule =
        fmt::format("step is {} s and duration {} s", draft.scenario.step_s, draft.scenario.duration_s);
    if (step_typed) draft.fail("step", "", "must be at most the duration: " + rule);
    draft.fail("duration", fmt::format("{}", draft.scenario.duration_s), "must be at least one step: " + rule);
  }
  if (draft.scenario.sample_s.value_or(0) > draft.scenario.duration_s) {
    draft.fail(draft.setting_of("sample") == nullptr && draft.setting_of("duration") != nullptr ? "duration" : "sample",
               fmt::format("{}", *draft.scenario.sample_s),
               fmt::format("must not leave sample = {} s above duration = {} s", *draft.scenario.sample_s,
                           draft.scenario.duration_s));
  }
  try {
    sample_grid(draft.scenario);
  } catch (const UserError& error) {
    for (const char* path : {"sample", "step", "duration"}) {
      if (const Override* setting = draft.setting_of(path)) {
        throw UserError(fmt::format("{}: {}", typed(*setting), error.what()));
      }
    }
    throw UserError(fmt::format("{}: {}", one_line(draft.scenario.file), error.what()));
  }
}

void generate(const Description& said, Scenario& scenario) {
  if (said.problem->planar) {
    put_planar(scenario, {said.problem->frame, said.links, said.q0, said.qd0, said.wall});
  } else {
    put_bodies(scenario, said);
  }
  scenario.summary = said.problem->summary;
}

}  // namespace

Scenario read_scenario(const std::filesystem::path& file, const std::vector<Override>& overrides, const Names& names,
                       const ImportOptions& options) {
  return ScenarioFile(file, options).read(overrides, names);
}

struct ScenarioFile::Tree {
  toml::table table;
};

ScenarioFile::ScenarioFile(std::filesystem::path file, const ImportOptions& options)
    : ScenarioFile(file, is_robot_file(file) ? import_robot(file, options).toml : scenario_text(file)) {}

ScenarioFile::ScenarioFile(std::filesystem::path file, std::string_view text)
    : file_(std::move(file)), tree_(new Tree{toml_tree(file_, text)}) {}

ScenarioFile::~ScenarioFile() = default;

// A value of the file may be wrong beside another that was typed: the fault is then of what, left out, leaves none or
// another.
Scenario ScenarioFile::read(const std::vector<Override>& overrides, const Names& names) const {
  try {
    return read_all(overrides, names);
  } catch (const UserError& error) {
    const std::string message = error.what();
    const std::string file = one_line(file_.string()) + ": ";
    if (!message.starts_with(file)) throw;
    const std::string at = message.substr(0, message.find(' ', file.size()));  // the file and the key
    const auto stays_without = [&](std::size_t left_out) {
      std::vector<Override> others = overrides;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
      try {
        read_all(others, names);
      } catch (const UserError& other) {
        return std::string_view(other.what()).starts_with(at);
      }
      return false;
    };
    for (std::size_t i = overrides.size(); i-- > 0;) {
      if (!stays_without(i)) throw UserError(typed(overrides[i]) + ": " + message.substr(file.size()));
    }
    throw;
  }
}

Scenario ScenarioFile::read_all(const std::vector<Override>& overrides, const Names& names) const {
  toml::table tree = tree_->table;
  apply(tree, overrides);
  Draft draft{tree, overrides, names, {}, {}};
  draft.scenario.name = file_.stem().string();
  draft.scenario.file = file_.string();
  check_name(draft.scenario);
  refuse_misplaced(draft);
  read_keys(draft);
  choose_softness(draft);
  check_softness_of_contacts(draft);
  const bool pendulum = draft.said.problem->planar;
  // A definition can be put into a file again: it is complete, and nothing in it is worked into something else yet.
  if (pendulum) {
    settle_links(draft);
    draft.scenario.definition = definition_of(draft.said);
  } else {
    settle_shapes(draft);
    draft.scenario.definition = definition_of(draft.said);
    settle_bodies(draft);
  }
  check_sections(draft);
  if (pendulum) {
    check_start_of_links(draft);
  } else {
    place_bodies(draft);
  }
  generate(draft.said, draft.scenario);
  check_tolerances(draft);
  check_grid(draft);
  return draft.scenario;
}

std::string ScenarioFile::text(const std::vector<Override>& overrides) const {
  toml::table table = tree_->table;
  apply(table, overrides);
  table.erase("tolerances");
  std::ostringstream out;
  out << table;
  return out.str();
}

}  // namespace odeval
