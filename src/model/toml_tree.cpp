#include "model/toml_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>

#include "model/nearest.hpp"
#include "model/one_line.hpp"
#include "model/scenario_keys.hpp"
#include "odeval/error.hpp"

namespace odeval {

namespace {

namespace fs = std::filesystem;

// A scenario is a page of text; whatever is longer (a trace, /dev/zero) is something else.
constexpr std::size_t longest_file = 1 << 20;

// `.5`, `1.` and `007` are numbers on a command line though not in TOML.
bool is_number(const std::string& text, double& number) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end;
}

bool is_bare_word(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '-' || letter == '.';
  });
}

// A table {value = ...} that owns the value.
toml::table parse_value(const Override& setting) {
  try {
    toml::table holder = toml::parse("value = " + setting.value);
    if (holder.size() == 1) return holder;
  } catch (const toml::parse_error&) {
    double number = 0;
    if (is_number(setting.value, number)) return toml::table{{"value", number}};
    if (is_bare_word(setting.value)) return toml::table{{"value", setting.value}};
  }
  throw UserError(typed(setting) + ": not a value; a number, a word or a list like [1.0, 0.5] is wanted");
}

std::vector<std::string> split_at_dots(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char letter : key) {
    if (letter == '.') {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  return parts;
}

toml::node* element(toml::array& list, const std::string& part) {
  std::size_t index = 0;
  const char* const end = part.data() + part.size();
  const auto [stop, error] = std::from_chars(part.data(), end, index);
  return error == std::errc() && stop == end && index < list.size() ? &list[index] : nullptr;
}

bool is_index(const std::string& part) { return std::isdigit(static_cast<unsigned char>(part.front())) != 0; }

// The node below `here`. A missing table is made, a missing list is not. Null where the key leads nowhere.
toml::node* descend(toml::node& here, const std::string& part, const std::string& next) {
  if (toml::array* list = here.as_array()) return element(*list, part);
  toml::table* table = here.as_table();
  if (table == nullptr || (is_index(next) && !table->contains(part))) return nullptr;
  return &table->insert(part, toml::table{}).first->second;
}

void apply(toml::table& tree, const Override& setting) {
  const toml::table holder = parse_value(setting);
  const toml::node& value = *holder.get("value");
  const std::vector<std::string> parts = split_at_dots(setting.key);
  if (std::find(parts.begin(), parts.end(), "") != parts.end()) {
    throw UserError(typed(setting) + ": a key like duration, ode.erp or links.0.mass is wanted");
  }
  const std::string& last = parts.back();

  toml::node* here = &tree;
  for (std::size_t i = 0; i + 1 < parts.size() && here != nullptr; ++i) here = descend(*here, parts[i], parts[i + 1]);
  if (toml::table* table = here == nullptr ? nullptr : here->as_table()) {
    table->insert_or_assign(last, value);
    return;
  }
  if (toml::array* list = here == nullptr ? nullptr : here->as_array()) {
    if (const toml::node* old = element(*list, last)) {
      const auto position = std::find_if(list->begin(), list->end(), [old](const auto& node) { return &node == old; });
      list->replace(position, value);
      return;
    }
  }
  const std::vector<std::string> sections = section_names();
  std::string hint;
  if (std::ranges::find(sections, parts.front()) == sections.end()) {
    const std::string meant = nearest_hint(parts.front(), sections).empty() ? "" : nearest(parts.front(), sections);
    if (!meant.empty())
      hint = fmt::format(" (nearest: '{}{}')", meant, one_line(setting.key.substr(parts.front().size())));
  }
  throw UserError(
      fmt::format("{}: the scenario has no '{}'{}; lists count from 0", typed(setting), one_line(setting.key), hint));
}

}  // namespace

std::string scenario_text(const fs::path& file) {
  const std::string name = one_line(file.string());
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) throw UserError(name + ": is a directory; a scenario file is wanted");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw UserError(fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
  std::string text(longest_file + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) throw UserError(fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > longest_file) throw UserError(name + ": is longer than 1 MiB; a scenario file is wanted");
  return text;
}

toml::table toml_tree(const fs::path& file, std::string_view text) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw UserError(fmt::format("{}:{}: not TOML: {}", one_line(file.string()), error.source().begin.line,
                                one_line(error.description(), 200)));
  }
}

void apply(toml::table& tree, const std::vector<Override>& overrides) {
  for (const Override& setting : overrides) apply(tree, setting);
}

std::string typed(const Override& setting) {
  return one_line(setting.origin == "--set" || setting.origin == "--grid"
                      ? fmt::format("{} {}={}", setting.origin, setting.key, setting.value)
                      : fmt::format("{} {}", setting.origin, setting.value));
}

namespace {

/// Whether the text has "KEY is" or "KEY =" of that key.
bool tells_value_of(std::string_view text, const std::string& key) {
  for (const char* const verb : {" is ", " = "}) {
    const std::size_t at = text.find(" " + key + verb);
    if (at != text.npos) return true;
  }
  return false;
}

}  // namespace

std::string blamed(const std::string& message, const std::vector<Override>& settings) {
  const std::size_t colon = message.find(": ");
  if (colon == message.npos || message.starts_with("--")) return message;
  const std::string rest = message.substr(colon + 2);
  const std::string key = rest.substr(0, rest.find(' '));
  auto gave = std::ranges::find_if(settings, [&](const Override& setting) { return overlap(setting.key, key); });
  if (gave == settings.end()) {
    gave = std::ranges::find_if(settings, [&](const Override& setting) { return tells_value_of(rest, setting.key); });
  }
  return gave == settings.end() ? message : typed(*gave) + ": " + rest;
}

}  // namespace odeval
