#include "report/template.hpp"

#include <algorithm>
#include <kainjow/mustache.hpp>
#include <optional>
#include <set>
#include <stdexcept>

namespace odeval::report {
namespace {

namespace mustache = kainjow::mustache;

constexpr std::string_view again = "again";  // what every item of a list but the first has

[[noreturn]] void fail(std::string_view title, const std::string& why) {
  throw std::logic_error(fmt::format("template of '{}': {}", title, why));
}

const std::vector<Values>* items_of(const Value& value) { return std::get_if<std::vector<Values>>(&value.get()); }

/// {{name}}, {{{name}}}, {{#name}}, {{^name}} or {{/name}}.
struct Tag {
  char kind;  // of '#', '^', '/', '{'; else a blank
  std::string_view name;
};

/// The next tag from `at` on, which is moved behind it; nothing when there is none.
std::optional<Tag> next_tag(std::string_view text, std::size_t& at) {
  const std::size_t begin = text.find("{{", at);
  const std::size_t end = text.find("}}", begin);
  if (begin == std::string_view::npos || end == std::string_view::npos) return std::nullopt;
  at = end + 2;
  std::string_view name = text.substr(begin + 2, end - begin - 2);
  if (name.empty() || std::string_view("#^/{").find(name.front()) == std::string_view::npos) return Tag{' ', name};
  return Tag{name.front(), name.substr(1)};
}

void no_value_is_left(std::string_view title, const std::set<std::string, std::less<>>& wanted, const Values& values) {
  for (const auto& [name, value] : values) {
    if (!wanted.contains(name)) fail(title, "the value of {{" + name + "}} stands nowhere");
    if (items_of(value) == nullptr) continue;
    for (const Values& item : *items_of(value)) no_value_is_left(title, wanted, item);
  }
}

/// Also what a condition leaves out this time; of a list as often as it has items. `scopes` from the outermost on.
void every_name_has_a_value(std::string_view title, std::string_view text, std::vector<const Values*>& scopes) {
  for (std::size_t at = 0; const auto tag = next_tag(text, at);) {
    if (tag->kind == '/' || tag->name == again) continue;
    const auto scope =
        std::find_if(scopes.rbegin(), scopes.rend(), [&](const Values* values) { return values->contains(tag->name); });
    if (scope == scopes.rend()) fail(title, fmt::format("{{{{{}}}}} has no value", tag->name));
    const std::vector<Values>* const items = items_of((*scope)->find(tag->name)->second);
    if (items == nullptr || tag->kind != '#') continue;
    const std::size_t end = std::min(text.find(fmt::format("{{{{/{}}}}}", tag->name), at), text.size());
    for (const Values& item : *items) {
      scopes.push_back(&item);
      every_name_has_a_value(title, text.substr(at, end - at), scopes);
      scopes.pop_back();
    }
    at = end;
  }
}

mustache::data data_of(const Values& values) {
  mustache::data data;
  for (const auto& [name, value] : values) {
    if (const auto* const text = std::get_if<std::string>(&value.get())) {
      data.set(name, text->empty() ? mustache::data(false) : mustache::data(*text));
      continue;
    }
    mustache::data items(mustache::data::type::list);
    for (const Values& item : *items_of(value)) {
      mustache::data one = data_of(item);
      one.set(std::string(again), items.is_non_empty_list());
      items << one;
    }
    data.set(name, items);
  }
  return data;
}

}  // namespace

std::set<std::string, std::less<>> names_in(std::string_view text) {
  std::set<std::string, std::less<>> names;
  for (std::size_t at = 0; const auto tag = next_tag(text, at);) names.emplace(tag->name);
  return names;
}

std::string filled(std::string_view title, std::string_view text, const Values& values,
                   std::string (*escape)(std::string_view)) {
  std::vector<const Values*> scopes{&values};
  every_name_has_a_value(title, text, scopes);
  no_value_is_left(title, names_in(text), values);
  mustache::mustache whole{std::string(text)};
  if (!whole.is_valid()) fail(title, whole.error_message());
  whole.set_custom_escape([escape](const std::string& value) { return escape(value); });
  return whole.render(data_of(values));
}

}  // namespace odeval::report
