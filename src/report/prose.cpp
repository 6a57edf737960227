#include "report/prose.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace odeval::report {
namespace {

[[noreturn]] void fail(std::string_view section, const std::string& why) {
  throw std::logic_error(fmt::format("template of '{}': {}", section, why));
}

std::string as_it_is(std::string_view text) { return std::string(text); }

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
  std::string words;

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
  auto all = paragraphs(filled(section.name, prose, content.values, as_it_is));
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
