#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "model/draft.hpp"
#include "model/nearest.hpp"

namespace odeval {

namespace {

const SectionRow* find_section(std::string_view name) {
  const auto found = std::ranges::find(section_table(), name, &SectionRow::name);
  return found == section_table().end() ? nullptr : &*found;
}

bool is_section(std::string_view name) {
  const SectionRow* const section = find_section(name);
  return section != nullptr && !section->inner();
}

std::string keys_of(std::string_view section) {
  std::vector<std::string_view> names;
  for (const KeyRow& row : key_table()) {
    if (row.section == section) names.push_back(row.name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

// The nearest key by its full name or by its own: `erp` means `ode.erp`, and not the one of each of a list's tables.
// Inside a list the same element is meant, and where a table has none like it, all it has are told.
[[noreturn]] void fail_unknown(const Draft& draft, std::string_view section, const std::string& path,
                               std::string_view key, const toml::node& node) {
  if (section.empty() && (node.is_table() || node.is_array_of_tables())) {
    draft.fail(std::string(key), "", fmt::format("is no known key{}", nearest_hint(key, section_names())),
               Draft::Blame::parts);
  }
  std::string best;
  bool best_in_list = false;
  std::size_t least = 0;
  for (const KeyRow& row : key_table()) {
    const bool here = row.section == section;
    const std::size_t distance = std::min(edit_distance(key, row.name) + (here ? 0 : 1),
                                          edit_distance(joined(section, key), joined(row.section, row.name)));
    const SectionRow* const table = find_section(row.section);
    const bool in_list = !here && table != nullptr && table->list;
    if (best.empty() || distance < least || (distance == least && best_in_list && !in_list)) {
      least = distance;
      best_in_list = in_list;
      best = here ? joined(path, row.name) : joined(row.section, row.name);
    }
  }
  const bool elsewhere = !section.empty() && !best.starts_with(path);
  const bool alike = least <= (elsewhere ? 1 : 1 + key.size() / 2);
  const std::string hint = alike             ? fmt::format(" (nearest: '{}')", best)
                           : section.empty() ? ""
                                             : fmt::format(" (there are {})", keys_of(section));
  draft.fail(joined(path, key), shown(node), "is no known key" + hint, Draft::Blame::parts);
}

double number_of(const Draft& draft, const KeyRow& row, const toml::node& node, const std::string& path) {
  if (row.kind == KeyKind::whole ? node.is_integer() : node.is_number()) {
    // A whole number beyond 2^53 is rounded; the library would have it no number at all.
    const double number =
        node.is_integer() ? static_cast<double>(node.as_integer()->get()) : node.as_floating_point()->get();
    const bool inside =
        row.ends_excluded ? number > row.least && number < row.greatest : number >= row.least && number <= row.greatest;
    if (inside) return number;
  }
  KeyRow one = row;
  if (one.kind == KeyKind::numbers || one.kind == KeyKind::several) one.kind = KeyKind::number;
  draft.fail(path, shown(node), rule_of(one, draft.names));
}

std::string word_of(const Draft& draft, const KeyRow& row, const toml::node& node, const std::string& path) {
  const std::vector<std::string> allowed = row.allowed(draft.names);
  const auto word = node.value<std::string>();
  if (word && std::find(allowed.begin(), allowed.end(), *word) != allowed.end()) return *word;
  KeyRow one = row;
  one.kind = KeyKind::word;
  constexpr std::size_t readable = 4;
  if (!word || allowed.size() <= readable) draft.fail(path, shown(node), rule_of(one, draft.names));
  draft.fail(path, shown(node), fmt::format("is not known (nearest: '{}')", nearest(*word, allowed)));
}

bool is_name(std::string_view name) {
  constexpr std::size_t longest = 40;
  const auto plain = [](unsigned char letter) { return std::isalnum(letter) != 0 || letter == '_' || letter == '-'; };
  return !name.empty() && name.size() <= longest && std::ranges::all_of(name, plain);
}

std::string name_of(const Draft& draft, const KeyRow& row, const toml::node& node, const std::string& path) {
  const auto name = node.value<std::string>();
  if (name && is_name(*name)) return *name;
  draft.fail(path, shown(node), rule_of(row, draft.names));
}

/// A name, or two with a dot between them: of a body and one of its shapes.
std::string dotted_name_of(const Draft& draft, const KeyRow& row, const toml::node& node, const std::string& path) {
  const auto name = node.value<std::string>();
  const std::size_t dot = name ? name->find('.') : std::string::npos;
  if (dot == std::string::npos) return name_of(draft, row, node, path);
  const std::string_view whole = *name;
  if (is_name(whole.substr(0, dot)) && is_name(whole.substr(dot + 1))) return *name;
  draft.fail(path, shown(node), rule_of(row, draft.names));
}

KeyValue value_of(const Draft& draft, const KeyRow& row, const toml::node& node, const std::string& path) {
  KeyValue value;
  if (row.kind == KeyKind::number || row.kind == KeyKind::whole) {
    value.number = number_of(draft, row, node, path);
  } else if (row.kind == KeyKind::several && node.is_number()) {
    value.numbers = {number_of(draft, row, node, path)};
  } else if (row.kind == KeyKind::word) {
    value.word = word_of(draft, row, node, path);
  } else if (row.kind == KeyKind::name) {
    value.word = name_of(draft, row, node, path);
  } else {
    const toml::array* list = node.as_array();
    if (list == nullptr || (row.count != 0 && list->size() != row.count)) {
      draft.fail(path, shown(node), rule_of(row, draft.names), Draft::Blame::length);
    }
    for (std::size_t i = 0; i < list->size(); ++i) {
      const std::string element = fmt::format("{}.{}", path, i);
      if (row.kind == KeyKind::names) {
        value.words.push_back(dotted_name_of(draft, row, (*list)[i], element));
      } else if (row.kind == KeyKind::numbers || row.kind == KeyKind::several) {
        value.numbers.push_back(number_of(draft, row, (*list)[i], element));
      } else {
        value.words.push_back(word_of(draft, row, (*list)[i], element));
      }
    }
  }
  return value;
}

void read_table(Draft& draft, const toml::table& table, std::string_view section, const std::string& path);

void read_list(Draft& draft, const std::string& section, const toml::node& node, const std::string& path);

void read_inner(Draft& draft, const std::string& section, const toml::node& node, const std::string& path) {
  if (find_section(section)->list) return read_list(draft, section, node, path);
  const toml::table* const table = node.as_table();
  if (table == nullptr) draft.fail(path, shown(node), fmt::format("must be a table [{}]", section));
  for (std::size_t k = 0; k < motor_keys.size(); ++k) {
    if (section == joined("joints", motor_keys[k])) draft.said.joints.back().motors[k].emplace();
  }
  read_table(draft, *table, section, path);
}

/// Adds an element to the list that a section's tables fill.
void add_to(Draft& draft, std::string_view section) {
  Description& said = draft.said;
  if (section == "links") said.links.emplace_back();
  if (section == "bodies") said.bodies.emplace_back();
  if (section == "bodies.shapes") said.bodies.back().shapes.emplace_back();
  if (section == "joints") said.joints.emplace_back();
  if (section == "springs") said.springs.emplace_back();
  if (section == "torques") said.torques.emplace_back();
  if (section == "controllers") said.controllers.emplace_back().load.sampled = true;
  if (section == "planes") said.planes.emplace_back();
  if (section == "contacts") said.contacts.emplace_back();
  if (section == "struts") said.struts.emplace_back();
  if (section == "tolerances") draft.scenario.tolerances.emplace_back();
}

/// Reads one table: `section` names its rows, `path` says where it stands ("links.0").
void read_table(Draft& draft, const toml::table& table, std::string_view section, const std::string& path) {
  for (const auto& [key, node] : table) {
    const KeyRow* row = find_key(section, key.str());
    if (row != nullptr) {
      row->put(draft.said, draft.scenario, value_of(draft, *row, node, joined(path, key.str())));
    } else if (!section.empty() && find_section(joined(section, key.str())) != nullptr) {
      read_inner(draft, joined(section, key.str()), node, joined(path, key.str()));
    } else if (!(section.empty() && is_section(key.str()))) {
      fail_unknown(draft, section, path, key.str(), node);
    }
  }
  for (const KeyRow& row : key_table()) {
    if (row.section == section && row.required() && !table.contains(row.name)) {
      draft.fail(joined(path, row.name), "", fmt::format("is missing; it {}", rule_of(row, draft.names)));
    }
  }
}

void read_list(Draft& draft, const std::string& section, const toml::node& node, const std::string& path) {
  const toml::array* list = node.as_array();
  if (list == nullptr) draft.fail(path, shown(node), fmt::format("must be tables [[{}]]", section));
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string element = fmt::format("{}.{}", path, i);
    const toml::table* table = (*list)[i].as_table();
    if (table == nullptr) draft.fail(element, shown((*list)[i]), fmt::format("must be a table [[{}]]", section));
    add_to(draft, section);
    read_table(draft, *table, section, element);
  }
}

void read_section(Draft& draft, const SectionRow& section, const toml::node& node) {
  const std::string name(section.name);
  if (section.list) return read_list(draft, name, node, name);
  const toml::table* table = node.as_table();
  if (table == nullptr) draft.fail(name, shown(node), fmt::format("must be a table [{}]", name));
  if (name == "wall") draft.said.wall.emplace();
  if (name == "ground") draft.said.ground.emplace();
  if (name == "joint") draft.said.joint.emplace();
  read_table(draft, *table, name, name);
}

}  // namespace

void read_keys(Draft& draft) {
  read_table(draft, draft.tree, "", "");
  for (const SectionRow& section : section_table()) {
    if (section.inner()) continue;
    if (const toml::node* node = draft.tree.get(section.name)) read_section(draft, section, *node);
  }
}

}  // namespace odeval
