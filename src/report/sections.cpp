#include "report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "odeval/error.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

constexpr Embedded layout[] = {
#include "page_layout.inc"
};

/// Reasons for missing cells, lettered below their table.
class Footnotes {
 public:
  std::string mark(const std::string& why) {
    auto at = std::ranges::find(reasons_, why);
    if (at == reasons_.end()) at = reasons_.insert(at, why);
    return letter(static_cast<std::size_t>(at - reasons_.begin()));
  }
  Items all() const {
    Items all;
    for (std::size_t i = 0; i < reasons_.size(); ++i) all.push_back({{"letter", letter(i)}, {"why", reasons_[i]}});
    return all;
  }

 private:
  static std::string letter(std::size_t number) {
    return number < 26 ? std::string(1, static_cast<char>('a' + number)) : std::to_string(number + 1);
  }
  std::vector<std::string> reasons_;
};

Values cell_values(const Cell& cell, Footnotes& notes) {
  if (const std::string* const text = std::get_if<std::string>(&cell)) {
    const bool one_word = text->find(' ') == std::string::npos;  // a name, which no hyphen may break
    const bool command = text->starts_with("odeval ");
    return {{"class", command ? "command" : one_word ? "whole" : ""}, {"text", *text}, {"mark", ""}};
  }
  if (const double* const number = std::get_if<double>(&cell); number != nullptr && std::isfinite(*number)) {
    return {{"class", "number"}, {"text", shown(*number)}, {"mark", ""}};
  }
  const Missing* const missing = std::get_if<Missing>(&cell);
  const std::string mark = notes.mark(missing != nullptr ? missing->why : "no finite number");
  return {{"class", "number"}, {"text", ""}, {"mark", mark}};
}

/// Whether a column has numbers, so that its head stands above their right ends.
bool is_numeric(const Table& table, std::size_t column) {
  return std::ranges::any_of(table.rows, [column](const std::vector<Cell>& row) {
    return column < row.size() && !std::holds_alternative<std::string>(row[column]);
  });
}

/// Each label and look of a panel once; last and in one what is grey, by name while that is short.
Items legend(const Panel& panel, const std::vector<Look>& looks) {
  constexpr std::size_t most_named = 4;
  struct Entry {
    std::string label;
    Look look;
    bool drawn;
  };
  std::vector<Entry> entries;
  std::vector<Entry> rest;
  for (std::size_t s = 0; s < panel.series.size(); ++s) {
    const Series& series = panel.series[s];
    if (series.label.empty()) continue;
    std::vector<Entry>& all = looks[s].colour == rest_colour ? rest : entries;
    const bool drawn = report::has_points(series, panel);
    const auto known = std::ranges::find_if(
        all, [&](const Entry& entry) { return entry.label == series.label && entry.look == looks[s]; });
    if (known == all.end()) {
      all.push_back({series.label, looks[s], drawn});
    } else {
      known->drawn = known->drawn || drawn;
    }
  }
  if (!rest.empty()) {
    Entry one{"", rest.front().look, false};
    for (const Entry& entry : rest) {
      one.label += (one.label.empty() ? "" : ", ") + entry.label;
      one.drawn = one.drawn || entry.drawn;
    }
    if (rest.size() > most_named) one.label = fmt::format("{} other methods", rest.size());
    entries.push_back(std::move(one));
  }
  Items items;
  for (const Entry& entry : entries) {
    items.push_back({{"swatch", swatch_svg(entry.look)}, {"label", entry.label}, {"undrawn", !entry.drawn}});
  }
  return items;
}

/// What is said above a panel; without a title of its own what its y axis has, without the unit.
std::string title_of(const Panel& panel) {
  return panel.title.empty() ? panel.y_label.substr(0, panel.y_label.find(", ")) : panel.title;
}

std::string letter_of(std::size_t panel) { return std::string(1, static_cast<char>('a' + panel % 26)); }

/// The reasons of its shades, each once, and of each panel what has no place on its axis: to be put behind its caption.
std::string behind_caption(const Figure& figure) {
  std::vector<std::string> said;
  for (const Panel& panel : figure.panels) {
    const std::string text = shade_text(panel);
    if (!text.empty() && std::ranges::find(said, text) == said.end()) said.push_back(text);
  }
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const std::string text = not_drawn_text(figure.panels[i]);
    if (!text.empty()) said.push_back(figure.panels.size() > 1 ? letter_of(i) + ": " + text : text);
  }
  std::string all;
  for (const std::string& text : said) all += (all.empty() ? "" : " ") + text + (text.ends_with('.') ? "" : ".");
  return all;
}

}  // namespace

std::string page_layout(std::string_view name) {
  constexpr std::string_view place = "{{>blocks}}";
  const auto* const found = std::ranges::find(layout, name, &Embedded::name);
  if (found == std::end(layout)) throw std::logic_error(fmt::format("no page has a part '{}'", name));
  std::string text(found->text);
  for (std::size_t at = 0; (at = text.find(place, at)) != std::string::npos;) {
    text.replace(at, place.size(), text_of(layout, "blocks"));
  }
  return text;
}

Values SectionWriter::values(const Section& section, std::string (*csv)(const Table&)) {
  csv_ = csv;
  Items blocks;
  for (const Block& block : section.blocks) {
    Values values{{"lead", ""},        {"paragraph", ""},    {"shown_in", ""},      {"table", Items{}},
                  {"figure", Items{}}, {"picture", Items{}}, {"highlight", Items{}}};
    std::visit([&](const auto& one) { add_block(values, one); }, block);
    blocks.push_back(std::move(values));
  }
  return {{"name", section.name}, {"title", section.title}, {"blocks", std::move(blocks)}};
}

void SectionWriter::add_block(Values& block, const Text& text) {
  block.insert_or_assign("lead", text.lead);
  block.insert_or_assign("paragraph", text.text);
  block.insert_or_assign("shown_in", anchors_.has(text.evidence) ? text.evidence : "");
}

void SectionWriter::add_block(Values& block, const Table& table) {
  if (!tables_.insert(table.name).second) throw std::logic_error("two tables are named '" + table.name + "'");
  Items columns;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    columns.push_back({{"numeric", is_numeric(table, i)}, {"text", table.columns[i]}});
  }
  Footnotes notes;
  Items rows;
  for (const auto& row : table.rows) {
    Items cells;
    for (const Cell& cell : row) cells.push_back(cell_values(cell, notes));
    for (Values& cell : cells) cell.insert({"anchor", ""});
    if (rows.size() < table.evidence.size()) cells.front().insert_or_assign("anchor", table.evidence[rows.size()]);
    rows.push_back({{"cells", std::move(cells)}});
  }
  block.insert_or_assign("table", Items{{{"id", anchors_.take("table", table.name)},
                                         {"title", table.title},
                                         {"csv", csv_ != nullptr ? csv_(table) : ""},
                                         {"long", table.rows.size() > long_rows},
                                         {"columns", std::move(columns)},
                                         {"rows", std::move(rows)},
                                         {"footnotes", notes.all()},
                                         {"note", table.note}}});
}

Values SectionWriter::panel_values(const Figure& figure, std::size_t number, const std::vector<Look>& looks,
                                   const std::string& id) {
  const Panel& panel = figure.panels[number];
  std::string plot;
  std::string why_not;
  try {
    if (has_points(panel)) {
      plot = plot_svg(panel, looks, fmt::format("{}-{}", id, number + 1));
    } else {
      why_not = "there is no number to draw";
    }
  } catch (const MachineError& error) {
    why_not = error.what();
  }
  if (!why_not.empty()) missing_.push_back(fmt::format("{}: {}", figure.name, why_not));
  const Items labels = legend(panel, looks);
  const bool several = figure.panels.size() > 1;
  return {{"letter", several ? letter_of(number) : ""},
          {"panel_title", title_of(panel)},
          {"plot", plot},
          {"why_not", why_not},
          {"x", panel.x_label},
          {"y", panel.y_label},
          {"has_legend", !labels.empty()},
          {"legend", labels}};
}

void SectionWriter::add_block(Values& block, const Figure& figure) {
  const std::string id = anchors_.take("figure", figure.name);
  const auto looks = looks_of(figure);
  Items panels;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) panels.push_back(panel_values(figure, i, looks[i], id));
  const std::string behind = behind_caption(figure);
  block.insert_or_assign("figure", Items{{{"id", id},
                                          {"columns", std::clamp(figure.columns, 1, 4)},
                                          {"panels", std::move(panels)},
                                          {"title", figure.title},
                                          {"caption", figure.caption + (behind.empty() ? "" : " " + behind)}}});
}

void SectionWriter::add_block(Values& block, const Picture& picture) {
  block.insert_or_assign("picture", Items{{{"id", anchors_.take("picture", picture.name)},
                                           {"png", base64(picture.png)},
                                           {"title", picture.title},
                                           {"caption", picture.caption}}});
}

void SectionWriter::add_block(Values& block, const Highlight& highlight) {
  const Figure& figure = highlight.figure;
  const std::string id = anchors_.take("short", figure.name);
  block.insert_or_assign("highlight", Items{{{"id", id},
                                             {"sentence", highlight.sentence},
                                             {"evidence", highlight.evidence},
                                             {"note", behind_caption(figure)},
                                             {"panels", Items{panel_values(figure, 0, looks_of(figure)[0], id)}}}});
}

}  // namespace odeval::report
