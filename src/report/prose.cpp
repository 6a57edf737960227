#include "report/prose.hpp"

#include <algorithm>
#include <kainjow/mustache.hpp>
#include <optional>
#include <set>
#include <stdexcept>

namespace odeval::report {
namespace {

namespace mustache = kainjow::mustache;
using Names = std::set<std::string, std::less<>>;

constexpr const char* again = "again";  // what every item of a list but the first has

[[noreturn]] void fail(std::string_view section, const std::string& why) {
  throw std::logic_error(fmt::format("template of '{}': {}", section, why));
}

const std::vector<Values>* items_of(const Values& values, std::string_view name) {
  const auto found = values.find(name);
  return found == values.end() ? nullptr : std::get_if<std::vector<Values>>(&found->second.get());
}

/// Of {{name}}, {{#name}}, {{^name}} and {{/name}}. What a list without items leaves out is not looked at.
Names names_in(std::string_view prose, const Values& values) {
  Names names;
  for (std::size_t at = prose.find("{{"); at != std::string_view::npos; at = prose.find("{{", at)) {
    at += 2;
    const std::size_t end = std::min(prose.find("}}", at), prose.size());
    std::string_view name = prose.substr(at, end - at);
    if (!name.empty() && std::string_view("#^/").find(name.front()) != std::string_view::npos) name.remove_prefix(1);
    if (name != again) names.emplace(name);
    const auto* const items = items_of(values, name);
    if (items != nullptr && items->empty())
      at = std::min(prose.find(fmt::format("{{{{/{}}}}}", name), at), prose.size());
  }
  return names;
}

/// Those of the items of lists as well.
Names names_of(const Values& values) {
  Names names;
  for (const auto& [name, value] : values) {
    names.insert(name);
    const auto* const items = items_of(values, name);
    if (items == nullptr || items->empty()) continue;
    Names own = names_of(items->front());
    for (const Values& item : *items) {
      if (names_of(item) != own) throw std::logic_error("the items of {{#" + name + "}} differ in their names");
    }
    names.merge(own);
  }
  return names;
}

mustache::data data_of(const Values& values) {
  mustache::data data;
  for (const auto& [name, value] : values) {
    if (const auto* const text = std::get_if<std::string>(&value.get())) {
      data.set(name, text->empty() ? mustache::data(false) : mustache::data(*text));
      continue;
    }
    mustache::data items(mustache::data::type::list);
    for (const Values& item : std::get<std::vector<Values>>(value.get())) {
      mustache::data one = data_of(item);
      one.set(again, items.is_non_empty_list());
      items << one;
    }
    data.set(name, items);
  }
  return data;
}

std::string rendered(const std::string& section, std::string_view prose, const Values& values) {
  const Names wanted = names_in(prose, values);
  const Names given = names_of(values);
  for (const std::string& name : wanted) {
    if (!given.contains(name)) fail(section, "{{" + name + "}} has no value");
  }
  for (const std::string& name : given) {
    if (!wanted.contains(name)) fail(section, "the value of {{" + name + "}} stands nowhere");
  }
  mustache::mustache text{std::string(prose)};
  if (!text.is_valid()) fail(section, text.error_message());
  text.set_custom_escape([](const std::string& value) { return value; });
  return text.render(data_of(values));
}

/// Lines between empty ones.
std::vector<std::vector<std::string>> paragraphs(std::string_view text) {
  std::vector<std::vector<std::string>> all(1);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) {
      all.back().emplace_back(text.substr(0, end));
    } else if (!all.back().empty()) {
      all.emplace_back();
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (all.back().empty()) all.pop_back();
  return all;
}

std::string joined(const std::vector<std::string>& lines, std::size_t first) {
  std::string text;
  for (std::size_t i = first; i < lines.size(); ++i) text += (text.empty() ? "" : " ") + lines[i];
  return text;
}

/// "[table friction] How far a box slides"
struct Place {
  std::string kind;
  std::string name;
  std::string title;
};

std::optional<Place> place_of(const std::string& line) {
  if (!line.starts_with('[')) return std::nullopt;
  const std::size_t space = line.find(' ');
  const std::size_t end = line.find("] ");
  if (end == std::string::npos || space > end) return std::nullopt;
  return Place{line.substr(1, space - 1), line.substr(space + 1, end - space - 1), line.substr(end + 2)};
}

std::string_view kind_of(const Exhibit& exhibit) {
  static constexpr std::string_view kinds[] = {"table", "figure", "picture", "lacking"};
  return kinds[exhibit.index()];
}

const std::string& name_of(const Exhibit& exhibit) {
  return std::visit([](const auto& one) -> const std::string& { return one.name; }, exhibit);
}

bool belongs(const Exhibit& exhibit, const Place& place) {
  return name_of(exhibit) == place.name && (kind_of(exhibit) == place.kind || std::holds_alternative<Lacking>(exhibit));
}

/// An exhibit with its words from the template.
struct Worded {
  const Place& place;
  const std::string& words;

  Block operator()(Table table) const {
    table.title = place.title;
    table.note = words;
    return table;
  }
  Block operator()(Lacking lacking) const { return Text{fmt::format("{} is missing: {}.", place.title, lacking.why)}; }
  Block operator()(auto figure_or_picture) const {
    figure_or_picture.title = place.title;
    figure_or_picture.caption = words;
    return figure_or_picture;
  }
};

}  // namespace

std::string title_of(std::string_view prose) {
  if (!prose.starts_with("# ")) throw std::logic_error("a template does not begin with '# ' and its title");
  return std::string(prose.substr(2, prose.find('\n') - 2));
}

Section section_of(std::string name, std::string_view prose, Content content) {
  Section section{std::move(name), title_of(prose), {}};
  auto all = paragraphs(rendered(section.name, prose, content.values));
  all.front().erase(all.front().begin());  // the title
  for (const std::vector<std::string>& lines : all) {
    if (lines.empty()) continue;
    const std::optional<Place> place = place_of(lines.front());
    if (!place) {
      section.blocks.emplace_back(Text{joined(lines, 0)});
      continue;
    }
    const auto exhibit =
        std::ranges::find_if(content.exhibits, [&](const Exhibit& one) { return belongs(one, *place); });
    if (exhibit == content.exhibits.end()) {
      fail(section.name, fmt::format("no {} '{}' was measured", place->kind, place->name));
    }
    section.blocks.push_back(std::visit(Worded{*place, joined(lines, 1)}, std::move(*exhibit)));
    content.exhibits.erase(exhibit);
  }
  if (!content.exhibits.empty()) {
    const Exhibit& left = content.exhibits.front();
    fail(section.name, fmt::format("it has no place for {} '{}'", kind_of(left), name_of(left)));
  }
  return section;
}

}  // namespace odeval::report
