#include "model/draft.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "model/one_line.hpp"
#include "odeval/error.hpp"

namespace odeval {

namespace {

// As TOML, but numbers as short as the user wrote them, and 20.0 not as the whole number 20.
std::string text_of(const toml::node& node) {
  if (node.is_floating_point()) {
    const std::string text = fmt::format("{}", node.as_floating_point()->get());
    return text + (text.find_first_not_of("-0123456789") == std::string::npos ? ".0" : "");
  }
  if (const toml::array* list = node.as_array()) {
    std::string text;
    for (const toml::node& element : *list) text += (text.empty() ? "" : ", ") + text_of(element);
    return "[" + text + "]";
  }
  std::ostringstream out;
  node.visit([&out](const auto& value) { out << value; });
  return out.str();
}

/// Whether the key is of one number of the list at the path: "q0.1" of "q0".
bool is_number_in(std::string_view path, std::string_view key) {
  if (!is_or_holds(path, key) || key.size() == path.size()) return false;
  return key.find_first_not_of("0123456789", path.size() + 1) == std::string_view::npos;
}

}  // namespace

std::string joined(std::string_view section, std::string_view name) {
  return section.empty() ? std::string(name) : fmt::format("{}.{}", section, name);
}

std::string shown(const toml::node& node) { return one_line(text_of(node), 60); }

const Override* Draft::setting_of(std::string_view path, Blame blame) const {
  for (auto setting = overrides.rbegin(); setting != overrides.rend(); ++setting) {
    if (is_or_holds(setting->key, path)) return &*setting;
    if (blame != Blame::length && is_number_in(path, setting->key)) return &*setting;
    if (blame == Blame::parts && is_or_holds(path, setting->key)) return &*setting;
  }
  return nullptr;
}

void Draft::fail(const std::string& where, const std::string& value, const std::string& rule, Blame blame) const {
  const std::string path = one_line(where);
  if (const Override* setting = setting_of(where, blame)) {
    throw UserError(fmt::format("{}: {} {}", typed(*setting), path, rule));
  }
  const std::string file = one_line(scenario.file);
  throw UserError(value.empty() ? fmt::format("{}: {} {}", file, path, rule)
                                : fmt::format("{}: {} = {}: {}", file, path, value, rule));
}

void Draft::make_unit(const std::string& where, Vec3& direction) const {
  if (direction == Vec3{}) fail(where, "[0, 0, 0]", "must have a direction");
  double largest = 0;  // squares of what is tiny or huge are no numbers
  for (const double x : direction) largest = std::fmax(largest, std::fabs(x));
  for (double& x : direction) x /= largest;
  direction = unit(direction);
}

void Draft::refuse(const char* key) const {
  if (!tree.contains(key)) return;
  fail(key, "", fmt::format("has no meaning for {}; remove it", said.problem->name), Blame::parts);
}

void Draft::refuse(const char* section, const char* key) const {
  const toml::table* const table = tree[section].as_table();
  if (table == nullptr || !table->contains(key)) return;
  fail(joined(section, key), "", fmt::format("has no meaning for {}; remove it", said.problem->name));
}

void Draft::refuse_in(const char* list, const char* key) const {
  const toml::array* const tables = tree[list].as_array();
  for (std::size_t i = 0; tables != nullptr && i < tables->size(); ++i) {
    const toml::table* const table = (*tables)[i].as_table();
    if (table == nullptr || !table->contains(key)) continue;
    fail(fmt::format("{}.{}.{}", list, i, key), "",
         fmt::format("has no meaning for {}; remove it", said.problem->name));
  }
}

}  // namespace odeval
